"""Torque on without a jump, and torque off.

On every way to torque each servo's goal is first written, then read back, to be where the servo is.
Joints may be sinking meanwhile, as those of a servo that was rebooted do: what holds nowhere is
measured at the last moment, and watched until it rests.
"""

import logging
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

from splinearm.errors import BusError, ServoError

from .asking import read_all, read_torque
from .bus import ServoBus
from .chain import ServoSpec
from .crew import Crew
from .sending import GroupWrite
from .stance import Stance, within_range
from .turn import fold

_log = logging.getLogger(__name__)

_TORQUE, _GOAL = "Torque Enable", "Goal Position"
_TRIES = 3
_GLANCE, _GLANCES = 0.02, 8
"""How often is looked whether joints move, s, and how many such times they must not."""
_REST = 2
"""So many ticks in that time are no motion."""
_LONGEST_FALL = 2.0
"""How long joints whose torque has come on are given to come to rest, s."""


def switch_on(bus: ServoBus, crew: Crew, stance: Stance) -> Stance:
    """Write every goal, see that it was taken, then switch the torque on where it is off.

    A servo that has torque and holds the goal that it shall have is not touched. Give the stance
    with the goals that were written.

    Raises:
        BusError: If a servo does not answer or refuses.
        ServoError: If a goal was not taken.
    """
    concerned = [servo for servo in crew.everyone if _is_concerned(servo, crew, stance)]
    if not concerned:
        return stance
    sources = {id(_source(servo, crew)) for servo in concerned}
    targets = [servo for servo in crew.targets if id(servo) in sources]
    places = [(s.servo_id, s.servo_model.table[_GOAL]) for s in targets]
    for attempt in range(_TRIES):  # nobody answers a sync write: one may be lost
        stance = _measured_now(bus, crew, stance)
        bus.sync_write(GroupWrite(places), [stance.goals[s.servo_id] for s in targets])
        wrong = _not_taken(bus, crew, stance, concerned)
        if wrong is None:
            break
        if attempt == _TRIES - 1:
            raise wrong
    _give_torque(bus, [s for s in concerned if not stance.energised[s.servo_id]])
    return stance


def await_rest(bus: ServoBus, servos: Sequence[ServoSpec]) -> None:
    """Wait until servos whose torque has come on do not move any more.

    Raises:
        BusError: If a servo does not answer.
    """
    deadline = time.monotonic() + _LONGEST_FALL
    resting = read_all(bus, servos, "Present Position")
    still = 0
    while still < _GLANCES and time.monotonic() < deadline:
        time.sleep(_GLANCE)
        still += 1
        now = read_all(bus, servos, "Present Position")
        if any(abs(now[number] - resting[number]) > _REST for number in now):
            resting, still = now, 0


def switch_off(bus: ServoBus, crew: Crew) -> None:
    """Switch the torque of every servo off, also if one of them does not answer.

    Raises:
        BusError: The first that occurred, after all were told.
    """
    first: BusError | None = None
    for servo in crew.everyone:
        try:
            bus.write(servo.servo_id, servo.servo_model.table[_TORQUE], 0)
        except BusError as error:
            _log.error("servo %d (%s): torque off: %s", servo.servo_id, servo.name, error)
            first = first or error
    if first is not None:
        raise first


def _source(servo: ServoSpec, crew: Crew) -> ServoSpec:
    """Give the servo whose goals a servo obeys."""
    return crew.leader_of(servo) if servo in crew.coupled else servo


def _is_concerned(servo: ServoSpec, crew: Crew, stance: Stance) -> bool:
    """Tell whether a servo lacks torque, or its goal is not the one at which it stays."""
    number = servo.servo_id
    wanted = stance.goals[_source(servo, crew).servo_id]
    return not stance.energised[number] or stance.written[number] != wanted


def _not_taken(
    bus: ServoBus, crew: Crew, stance: Stance, concerned: Sequence[ServoSpec]
) -> ServoError | None:
    """Give the error of the first servo that does not have its goal; None: all have."""
    taken = read_all(bus, concerned, _GOAL)
    for servo in concerned:
        source = _source(servo, crew)
        wanted = stance.goals[source.servo_id]
        if taken[servo.servo_id] != wanted:
            return ServoError(
                servo.servo_id,
                f"Goal Position is {taken[servo.servo_id]} after {wanted} was written to servo "
                f"{source.servo_id}; the torque stays as it was; reboot the servo",
                name=servo.name,
            )
    return None


def _measured_now(bus: ServoBus, crew: Crew, stance: Stance) -> Stance:
    """Give the stance with the goals of joints that nothing holds where they are by now.

    One that has just fallen against its end stop may rebound from where its servo takes no goal.
    """
    limp = [servo for servo in crew.targets if servo.servo_id in stance.limp]
    deadline = time.monotonic() + _LONGEST_FALL
    while True:
        present = read_all(bus, limp, "Present Position")
        try:
            goals = {servo.servo_id: _held_at(servo, crew, stance, present) for servo in limp}
        except ServoError:
            if time.monotonic() > deadline:
                raise
            time.sleep(_GLANCE)
        else:
            return replace(stance, goals={**stance.goals, **goals})


def _held_at(servo: ServoSpec, crew: Crew, stance: Stance, present: Mapping[int, int]) -> int:
    """Give the goal at which a servo stays where it is."""
    k = crew.targets.index(servo)
    span = int(stance.ticks_min[k]), int(stance.ticks_max[k])
    return within_range(servo, fold(servo, present[servo.servo_id]), span)


def _give_torque(bus: ServoBus, servos: Sequence[ServoSpec]) -> None:
    """Switch the torque on, of all at once; ask those again that were not heard."""
    if not servos:
        return
    places = [(s.servo_id, s.servo_model.table[_TORQUE]) for s in servos]
    bus.sync_write(GroupWrite(places), [1] * len(places))
    on = read_torque(bus, servos)
    for servo in servos:
        if not on[servo.servo_id]:
            bus.write(servo.servo_id, servo.servo_model.table[_TORQUE], 1)
