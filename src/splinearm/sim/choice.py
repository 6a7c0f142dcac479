"""What the manual leaves open, in one place: each choice, its default, and why.

A choice belongs to a servo: ``servo.choices = replace(servo.choices, overload_time=5.0)`` while it
runs (holding the bus' lock). The defaults take the less convenient of what servos are known to do,
unless that was seen once only.

Chosen as well, but not switchable:

- the loop runs at 1 kHz, D acts on the trajectory's velocity less the measured one, and the sum of
  I stops where it alone gives full duty (``law``); gains of P servos are scaled as those of X;
- Goal PWM and Goal Current begin at 0 in the modes that follow them (``wide_controls``);
- the gains of mode 5, of which the manual gives no numbers: D brakes there as the motor's own
  voltage does in the other modes (``wide_controls``);
- PWM Slope of an XL330 counts on its nominal supply (``wide_controls``);
- what P, I and D of an XL-320 do to the output (``narrow_controls``), and what it and an AX-12A
  read where their manual says "invalid angle" (``horn``);
- the line of a motor of which only the continuous torque is published (``motor``);
- how a servo warms (``heat``) and that it looks at temperature, supply and load every 20 ms
  (``core``); that the Torque Enable of a servo that has shut down answers an access error
  (``virtual_servo``), and within which distance it counts as arrived or not following (``sensor``).
"""

from dataclasses import dataclass
from enum import Enum

BOOT_TIME = 0.4
"""How long a servo is deaf after a reboot, s. Measured on an XC330 (ROBOTIS-GIT/emanual, issue
1698: it answers the reboot at once and is then silent for about 0.4 s); the manual is silent."""


class TripStop(Enum):
    """What a servo does when its bus watchdog trips."""

    BRAKE = "brake"
    """It brakes as hard as its PWM limit allows and holds where it came to rest, keeping the output
    that carried its load. The manual says that the servo stops and that profile velocity and
    acceleration count as 0, which is infinite; that it then holds is an assumption."""

    HOLD = "hold"
    """It takes its present position for its goal: it overshoots, and sags by its load."""

    GO_ON = "go on"
    """It reports the trip and goes on to its goal: seen on an XC330."""

    BY_HOMING_OFFSET = "by homing offset"
    """It takes its present position without its Homing Offset for its goal, so that it first moves
    by the offset: seen on an XM540 in position mode. In other modes it brakes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Choices:
    """How one servo does what its manual does not say."""

    on_trip: TripStop = TripStop.BRAKE
    """What it does when its watchdog trips."""
    boot_time: float = BOOT_TIME
    """How long it is deaf after a reboot or when the power comes back, s."""
    goal_survives_torque_off: bool = True
    """Whether a goal written with the torque off is run to when the torque comes on. Seen on X
    servos, and it is the way in which arms jump; False: the goal becomes the present position, as
    the maker's support saw on an RX-28."""
    torque_on_by_goal: bool = False
    """Whether Goal Position switches the torque on in servos without Drive Mode (AX-12A, XL-320).
    Their manuals do not say so. Others have a bit of Drive Mode for it."""
    overload_share: float = 0.8
    """Share of the stall current from which on a load counts as overload. The manual says only "a
    persistent load that exceeds maximum output". An XM430 was seen to give up at 0.41 after 5 s
    (ROBOTIS-GIT/DynamixelSDK, issue 285), which many arms would not survive at rest."""
    overload_time: float = 3.0
    """How long such a load lasts before it is an error, s; infinite: never. An estimate."""
    voltage_error_stays: bool = True
    """Whether an input voltage error stays in Hardware Error Status until a reboot, as the others
    do; False: it goes when the supply is well again, unless it has cut the torque."""


DEFAULT_CHOICES = Choices()
"""What servos do unless something else is said."""
