"""What the manual leaves open about servos on a line, and what is known of it: switches."""

from dataclasses import dataclass

from splinearm.drivers.packets import Instruction

AX_TURN_AROUND = {Instruction.PING: 18e-6, Instruction.READ: 22e-6}
AX_WRITE_TURN_AROUND = (24e-6, 6e-6)
"""What an AX-12 takes to answer at Return Delay Time 0, s: for a write the second number for each
byte written. Measured by xevelabs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LineHabits:
    """How servos behave where the manual is silent."""

    turn_around: float = 0.0
    """What servos take to answer at Return Delay Time 0, s, where nothing is known of the model."""
    known_turn_around: bool = True
    """Whether models of which it is known take what is known."""
    sync_read_ends: bool = False
    """Whether a sync or bulk read ends at a servo that is missing; else the others answer."""
    bulk_read_1_ends: bool = True
    """The same for the bulk read of Protocol 1.0, in which servos wait for their predecessors."""
    stuck_time: float = 0.0
    """For how long servos hear nothing after a fast read whose first servo is missing, s. On an arm
    of XL330 and XM430 servos pings right after it timed out (DynamixelHandler-ros2, developer
    notes); for how long is not known."""
    answers_bad_crc: bool = False
    """Whether a servo answers a damaged packet with an error; else it is silent."""
    noise_at_wrong_baud: bool = False
    """Whether noise comes back for a packet at a baud rate that its servo does not have."""


def turn_around(habits: LineHabits, model: str, instruction: int, written: int) -> float:
    """Give what a servo takes to answer, s.

    Args:
        habits: What is switched.
        model: Name of its model.
        instruction: What it does.
        written: How many bytes are written.
    """
    if not (habits.known_turn_around and model.startswith("AX-")):
        return habits.turn_around
    at_once, each = AX_WRITE_TURN_AROUND
    known = AX_TURN_AROUND.get(Instruction(instruction)) if instruction in _NUMBERS else None
    return at_once + each * written if known is None else known


_NUMBERS = frozenset(map(int, Instruction))
