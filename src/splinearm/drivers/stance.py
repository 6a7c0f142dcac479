"""Where an arm stands before its torque comes on: its joints' turns, and the goals that hold it."""

import logging
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import ServoError
from splinearm.joints import JointLimits
from splinearm.units import DEG

from .ability import range_registers
from .asking import read_all, read_torque
from .bus import ServoBus
from .chain import ServoSpec
from .crew import Crew
from .scaling import ONE_TURN_MODE, operating_mode, position_range
from .turn import fold, unwrapped_zero

_log = logging.getLogger(__name__)

_APART = 3.0 * DEG
"""How far a shadow may stand from its leader, rad: they fight each other by that angle."""
_SAG = 2.0 * DEG
"""How far beyond its servo's own limits a joint may rest, rad; its goal is then the limit."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Stance:
    """Where the servos that are sent goals stand: m of them, leaders first."""

    goals: Mapping[int, int]
    """By id the goal at which the servo stays where it is, ticks."""
    limp: frozenset[int]
    """Ids of those among them whose joint nothing holds: it may be elsewhere by now."""
    energised: Mapping[int, bool]
    """By id of every servo whether its torque is on."""
    written: Mapping[int, int]
    """By id of every servo what its Goal Position holds."""
    zero_ticks: FloatArray
    """Position register at joint zero in the turn that counts now, shape (m,), ticks."""
    ticks_min: FloatArray
    """Lowest goal that the servo takes, shape (m,), ticks."""
    ticks_max: FloatArray
    """Highest goal that the servo takes, shape (m,), ticks."""


def take_stance(
    bus: ServoBus,
    crew: Crew,
    limits: JointLimits,
    keep: float,
    *,
    near: FloatArray | None = None,
    stopped: Collection[int] = (),
) -> Stance:
    """Find out where the servos stand.

    Args:
        bus: The bus.
        crew: The servos.
        limits: Limits of the joints, in the order of the leaders.
        keep: How far from its goal a servo with torque may stand for that goal to be kept, rad. An
            arm that carries a load hangs a little below its goal; taking where it hangs as the new
            goal would let it sink each time.
        near: Where the joints are known to be, to less than half a turn, shape (n,), rad; NaN of
            those that are not. It tells turns that a servo has forgotten.
        stopped: Ids of servos that their watchdog stopped: they do not stand where their goal is,
            so it is not kept.

    Raises:
        BusError: If a servo does not answer.
        ServoError: If a joint's turn cannot be told, it stands where its servo takes no goal, its
            limits reach beyond those of the servo, or a shadow stands elsewhere than its leader.
    """
    everyone = crew.everyone
    torque = read_torque(bus, everyone)
    present = read_all(bus, everyone, "Present Position")
    goal = read_all(bus, everyone, "Goal Position")
    for servo in everyone:
        if not torque[servo.servo_id]:
            present[servo.servo_id] = fold(servo, present[servo.servo_id])
    zeros = _zeros(crew, present, limits, near)
    ranges = _ranges(bus, crew)
    for i, servo in enumerate(crew.leaders):
        _check_reach(servo, zeros[i], ranges[servo.servo_id], limits, i)
    _check_shadows(crew, present, zeros)
    goals: dict[int, int] = {}
    limp: set[int] = set()
    for servo in crew.targets:
        number = servo.servo_id
        holders = [number, *(s.servo_id for s in crew.coupled if crew.leader_of(s) is servo)]
        still = [holder for holder in holders if torque[holder] and holder not in stopped]
        held = _held(still, goal, present, keep * servo.servo_model.pulses_per_rad)
        stays = present[number] if held is None else held
        if any(torque[holder] for holder in holders):
            goals[number] = within_range(servo, stays, ranges[number])
        else:
            goals[number] = stays
            limp.add(number)
    bounds = np.array([ranges[servo.servo_id] for servo in crew.targets], dtype=np.float64)
    return Stance(
        goals=goals,
        limp=frozenset(limp),
        energised=torque,
        written=goal,
        zero_ticks=np.array(zeros, dtype=np.float64),
        ticks_min=bounds[:, 0],
        ticks_max=bounds[:, 1],
    )


def _held(
    holders: Sequence[int], goal: Mapping[int, int], present: Mapping[int, int], keep: float
) -> int | None:
    """Give the goal at which one of the servos of a joint holds it, None if none does.

    A shadow may hold alone while its leader has no torque: where its leader begins anew then is
    where the shadow holds, lest the joint sink.
    """
    for number in holders:
        if abs(goal[number] - present[number]) <= keep:
            return goal[number]
    return None


def _zeros(
    crew: Crew, present: Mapping[int, int], limits: JointLimits, near: FloatArray | None
) -> list[int]:
    """Give the position register at joint zero of every target, in the turn that counts now."""
    zeros: list[int] = []
    for i, servo in enumerate(crew.leaders):
        low, high = float(limits.q_min[i]), float(limits.q_max[i])
        known = None if near is None or np.isnan(near[i]) else float(near[i])
        ticks = present[servo.servo_id]
        zero = servo.zero_ticks or 0
        zeros.append(unwrapped_zero(servo, zero, ticks, low, high, near=known))
    for servo, i in zip(crew.followers, crew.joint_index[len(zeros) :], strict=True):
        leader = crew.leaders[i]
        zero = servo.zero_ticks if servo.zero_ticks is not None else leader.zero_ticks or 0
        q = (present[leader.servo_id] - zeros[i]) / leader.servo_model.pulses_per_rad
        ticks = present[servo.servo_id]
        zeros.append(unwrapped_zero(servo, zero, ticks, q - np.pi, q + np.pi, near=q))
    return zeros


def _ranges(bus: ServoBus, crew: Crew) -> dict[int, tuple[int, int]]:
    """Give by id the goals that each target takes; in position mode the servo itself says."""
    ranges = {servo.servo_id: position_range(servo) for servo in crew.targets}
    one_turn = [servo for servo in crew.targets if operating_mode(servo) == ONE_TURN_MODE]
    kinds = {range_registers(servo.servo_model) for servo in one_turn}
    for low, high in sorted(kinds):
        alike = [s for s in one_turn if range_registers(s.servo_model) == (low, high)]
        lows, highs = read_all(bus, alike, low), read_all(bus, alike, high)
        ranges |= {number: (lows[number], highs[number]) for number in lows}
    return ranges


def _check_reach(
    servo: ServoSpec, zero: int, span: tuple[int, int], limits: JointLimits, i: int
) -> None:
    """Refuse a joint that may go where its servo takes no goal (a tick of rounding is free)."""
    per_rad = servo.servo_model.pulses_per_rad
    low, high = zero + limits.q_min[i] * per_rad, zero + limits.q_max[i] * per_rad
    if low < span[0] - 1.5 or high > span[1] + 1.5:
        raise ServoError(
            servo.servo_id,
            f"it takes goals from {span[0]} to {span[1]} ticks, but joint {servo.joint!r} may go "
            f"from {low:.0f} to {high:.0f}; set Min and Max Position Limit, or narrow the joint's "
            "limits in the arm's file",
            name=servo.name,
        )


def _check_shadows(crew: Crew, present: Mapping[int, int], zeros: list[int]) -> None:
    """Refuse shadows that would fight their leaders."""
    for servo in crew.followers + crew.coupled:
        leader = crew.leader_of(servo)
        model = servo.servo_model
        gap = present[servo.servo_id] - present[leader.servo_id]
        if servo in crew.followers:
            own, its = crew.targets.index(servo), crew.leaders.index(leader)
            gap -= zeros[own] - zeros[its]
        elif operating_mode(servo) == ONE_TURN_MODE:  # whole turns fold away
            gap = (gap + model.pulses // 2) % model.pulses - model.pulses // 2
        if abs(gap) / model.pulses_per_rad > _APART:
            raise ServoError(
                servo.servo_id,
                f"it stands {gap} ticks from its leader {leader.name!r}: they would fight each "
                f"other; set its Homing Offset {-gap} higher, or mount its horn anew",
                name=servo.name,
            )


def within_range(servo: ServoSpec, ticks: int, span: tuple[int, int]) -> int:
    """Give the goal nearest to where a servo stands; refuse if that is too far to go unasked."""
    nearest = min(max(ticks, span[0]), span[1])
    beyond = abs(ticks - nearest) / servo.servo_model.pulses_per_rad
    if beyond > _SAG:
        raise ServoError(
            servo.servo_id,
            f"it stands at {ticks} ticks, {beyond / DEG:.1f} deg beyond the goals it takes "
            f"({span[0]} to {span[1]}); move the joint back by hand, with the torque off",
            name=servo.name,
        )
    if nearest != ticks:
        _log.warning(
            "servo %d (%s) rests %.1f deg beyond its own limit; it is held at the limit",
            servo.servo_id,
            servo.name,
            beyond / DEG,
        )
    return nearest
