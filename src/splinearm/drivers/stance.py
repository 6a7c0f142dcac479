"""Where an arm stands before its torque comes on, and how it comes on without a jump.

On every way to torque each servo's goal is first written, then read back, to be where the servo is.
"""

import logging
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import BusError, ServoError
from splinearm.joints import JointLimits
from splinearm.units import DEG

from .bus import ServoBus
from .chain import ServoSpec
from .crew import Crew
from .scaling import ONE_TURN_MODE, operating_mode, position_range
from .startup import read_all
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
    torque = {i: bool(on) for i, on in read_all(bus, everyone, "Torque Enable").items()}
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
    for servo in crew.targets:
        number = servo.servo_id
        holders = [number, *(s.servo_id for s in crew.coupled if crew.leader_of(s) is servo)]
        still = [holder for holder in holders if torque[holder] and holder not in stopped]
        held = _held(still, goal, present, keep * servo.servo_model.pulses_per_rad)
        stays = present[number] if held is None else held
        goals[number] = _within(servo, stays, ranges[number])
    bounds = np.array([ranges[servo.servo_id] for servo in crew.targets], dtype=np.float64)
    return Stance(
        goals=goals,
        energised=torque,
        written=goal,
        zero_ticks=np.array(zeros, dtype=np.float64),
        ticks_min=bounds[:, 0],
        ticks_max=bounds[:, 1],
    )


def switch_on(bus: ServoBus, crew: Crew, stance: Stance) -> None:
    """Write every goal, see that it was taken, then switch the torque on where it is off.

    A servo that has torque and holds the goal that it shall have is not touched.

    Raises:
        BusError: If a servo does not answer or refuses.
        ServoError: If a goal was not taken.
    """
    concerned = [servo for servo in crew.everyone if _is_concerned(servo, crew, stance)]
    sources = [crew.leader_of(s) if s in crew.coupled else s for s in concerned]
    for servo in crew.targets:
        if servo in sources:
            register = servo.servo_model.table["Goal Position"]
            bus.write(servo.servo_id, register, stance.goals[servo.servo_id])
    taken = read_all(bus, concerned, "Goal Position")
    for servo in concerned:
        source = crew.leader_of(servo) if servo in crew.coupled else servo
        wanted = stance.goals[source.servo_id]
        if taken[servo.servo_id] != wanted:
            raise ServoError(
                servo.servo_id,
                f"Goal Position is {taken[servo.servo_id]} after {wanted} was written to servo "
                f"{source.servo_id}; the torque stays as it was; reboot the servo",
                name=servo.name,
            )
    for servo in concerned:
        if not stance.energised[servo.servo_id]:
            bus.write(servo.servo_id, servo.servo_model.table["Torque Enable"], 1)


def switch_off(bus: ServoBus, crew: Crew) -> None:
    """Switch the torque of every servo off, also if one of them does not answer.

    Raises:
        BusError: The first that occurred, after all were told.
    """
    first: BusError | None = None
    for servo in crew.everyone:
        try:
            bus.write(servo.servo_id, servo.servo_model.table["Torque Enable"], 0)
        except BusError as error:
            _log.error("servo %d (%s): torque off: %s", servo.servo_id, servo.name, error)
            first = first or error
    if first is not None:
        raise first


def _is_concerned(servo: ServoSpec, crew: Crew, stance: Stance) -> bool:
    """Tell whether a servo lacks torque, or its goal is not the one at which it stays."""
    source = crew.leader_of(servo) if servo in crew.coupled else servo
    number = servo.servo_id
    return not stance.energised[number] or stance.written[number] != stance.goals[source.servo_id]


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
    lows = read_all(bus, one_turn, "Min Position Limit")
    highs = read_all(bus, one_turn, "Max Position Limit")
    return ranges | {number: (lows[number], highs[number]) for number in lows}


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


def _within(servo: ServoSpec, ticks: int, span: tuple[int, int]) -> int:
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
