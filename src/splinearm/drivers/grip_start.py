"""A gripper's servo taken into use: checked, understood, and given torque without a jump."""

import numpy as np

from splinearm.errors import ServoError

from .ability import range_registers, voltage_register
from .asking import read_all, read_torque
from .bus import ServoBus
from .chain import ServoSpec
from .gauge import Gauge
from .grip_force import MOST, GripForce, force_register
from .grip_line import GripLine, duration_of, pace, profile_register
from .scaling import MULTI_TURN_MODES, operating_mode
from .startup import call_roll, check_health, check_settings, let_all_answer, write_ram_settings
from .watchdog import let_go

_GOAL, _PRESENT, _TORQUE = "Goal Position", "Present Position", "Torque Enable"
_TRAVEL_TIME = 1.0
"""How long the whole travel takes if the file sets no profile, s."""
_TURN_KNOWN = 0.95
"""Share of a turn up to which a travel says in which turn it is."""


def begin(bus: ServoBus, servo: ServoSpec, gauge: Gauge, *, recovered: bool = False) -> GripLine:
    """Check a gripper's servo, and let it have torque where it stands.

    One that has torque keeps its goal and its force.

    Args:
        bus: The bus.
        servo: The servo.
        gauge: Reads what it says of its motion.
        recovered: Whether it was just recovered: those that know no reboot go on reporting their
            error until their torque is on.

    Raises:
        ServoError: If it is not calibrated, not as the file says, or has stopped itself.
        BusError: If it does not answer.
    """
    closed, opened = require_travel(servo)
    servos = [servo]
    let_all_answer(bus, servos)
    call_roll(bus, servos)
    check_settings(bus, servos)
    if not recovered:
        check_health(bus, servos)
    if not _counts_turns(servo):
        _check_range(bus, servo, closed, opened)
    line = GripLine(
        model=servo.servo_model,
        gauge=gauge,
        force=_find_force(bus, servo),
        closed=closed + _turn(bus, servo, closed, opened),
        travel=opened - closed,
        duration=_duration(servo, opened - closed),
    )
    if read_torque(bus, servos)[servo.servo_id]:
        goal = _ask(bus, servo, _GOAL)
        let_go(bus, servos)  # if its watchdog has stopped it, it takes that goal again
        _write(bus, servo, _GOAL, goal)
        _set_pace(bus, servo, line)
    else:
        _switch_on(bus, servo, line)
    return line


def require_travel(servo: ServoSpec) -> tuple[int, int]:
    """Give the ticks where a gripper is closed and where it is open.

    Raises:
        ServoError: If they are not known.
    """
    travel = None if servo.grip is None else servo.grip.travel
    if travel is None:
        raise _refused(
            servo,
            "where it is open and where it is closed is not known; calibrate it, or write its "
            "open_ticks and closed_ticks into the arm's file",
        )
    return travel


def _counts_turns(servo: ServoSpec) -> bool:
    return operating_mode(servo) in MULTI_TURN_MODES


def _check_range(bus: ServoBus, servo: ServoSpec, closed: int, opened: int) -> None:
    """Refuse a travel that the servo does not take as a whole."""
    low, high = _range(bus, servo)
    for what, ticks in (("open", opened), ("closed", closed)):
        if not low <= ticks <= high:
            raise _refused(
                servo,
                f"it is {what} at {ticks}, and takes goals from {low} to {high}: widen its "
                "position limits, or calibrate it anew",
            )


def _turn(bus: ServoBus, servo: ServoSpec, closed: int, opened: int) -> int:
    """Give the ticks of the turns that a servo counts which has forgotten how many it made."""
    pulses = servo.servo_model.pulses
    if not _counts_turns(servo) or abs(opened - closed) > _TURN_KNOWN * pulses:
        return 0
    return round((_ask(bus, servo, _PRESENT) - 0.5 * (closed + opened)) / pulses) * pulses


def _range(bus: ServoBus, servo: ServoSpec) -> tuple[int, int]:
    low, high = range_registers(servo.servo_model)
    return _ask(bus, servo, low), _ask(bus, servo, high)


def _find_force(bus: ServoBus, servo: ServoSpec) -> GripForce:
    most, model = MOST[force_register(servo)], servo.servo_model
    limits = {most: _ask(bus, servo, most)} if most in model.table else {}
    return GripForce.of(servo, _ask(bus, servo, voltage_register(model).name) / 10.0, limits)


def _switch_on(bus: ServoBus, servo: ServoSpec, line: GripLine) -> None:
    """Give it its settings and, where it stands, torque."""
    force = line.force
    let_go(bus, [servo])
    write_ram_settings(bus, [servo])
    _set_pace(bus, servo, line)
    usual = 1.0 if servo.grip is None else servo.grip.force
    _write(bus, servo, force.name, min(round(usual * force.full), force.most))
    goal = _ask(bus, servo, _PRESENT)
    if not _counts_turns(servo):
        goal = int(np.clip(goal, *_range(bus, servo)))
    _write(bus, servo, _GOAL, goal)
    if _ask(bus, servo, _GOAL) != goal:
        raise _refused(
            servo, f"Goal Position is not {goal} after that was written; reboot the servo"
        )
    _write(bus, servo, _TORQUE, 1)


def _set_pace(bus: ServoBus, servo: ServoSpec, line: GripLine) -> None:
    """Let the whole travel take a second, unless the file says how fast it shall go."""
    name = profile_register(line.model)
    if name is not None and name not in servo.settings:
        _write(bus, servo, name, pace(servo, line.travel, _TRAVEL_TIME))


def _duration(servo: ServoSpec, travel: int) -> float:
    """Give how long the whole travel takes, s."""
    name = profile_register(servo.servo_model)
    if name is None or name not in servo.settings:
        return _TRAVEL_TIME
    return duration_of(servo, travel, servo.settings[name])


def _ask(bus: ServoBus, servo: ServoSpec, name: str) -> int:
    return read_all(bus, [servo], name)[servo.servo_id]


def _write(bus: ServoBus, servo: ServoSpec, name: str, value: int) -> None:
    bus.write(servo.servo_id, servo.servo_model.table[name], value)


def _refused(servo: ServoSpec, reason: str) -> ServoError:
    return ServoError(servo.servo_id, reason, name=servo.name)
