"""Where the EEPROM of a servo differs from what the arm's file says."""

from collections.abc import Iterator, Mapping

from splinearm.drivers.bus import PingReply
from splinearm.drivers.chain import ServoSpec
from splinearm.drivers.model import servo_models
from splinearm.drivers.registers import Area
from splinearm.drivers.scaling import ONE_TURN_MODE, operating_mode
from splinearm.drivers.startup import is_coupled
from splinearm.joints import JointLimits

from .advice import set_register
from .catalogue import found
from .chart import Chart
from .finding import Finding
from .model_number import model_of

_NO_SECONDARY_ID = 253
_REVERSED = 1
_CODES = {
    "Drive Mode": "S14",
    "Operating Mode": "S16",
    "Secondary(Shadow) ID": "S18",
    "Homing Offset": "S17",
}
_USUAL = {
    "Drive Mode": 0,
    "Operating Mode": ONE_TURN_MODE,
    "Secondary(Shadow) ID": 255,
    "Homing Offset": 0,
}
_SINGLED_OUT = (*_CODES, "Min Position Limit", "Max Position Limit", "Return Delay Time")


def other_model(servo: ServoSpec, reply: PingReply) -> Finding | None:
    """Make the finding of a servo that is of another model than the file says; None: it is not."""
    wanted = servo.servo_model
    if reply.model_number == wanted.number:
        return None
    model, where = model_of(reply.model_number), f"servo {servo.servo_id} ({servo.name})"
    if model is None:
        return unknown_model(where, reply, f"; the arm's file says {wanted.name}")
    name = model.name
    return found(
        "S01",
        where,
        f"it is a {name}; the arm's file says {wanted.name}",
        f'write model = "{name}" for {servo.name!r} into the arm\'s file; or, if servos were '
        "swapped, correct their ids",
    )


def unknown_model(where: str, reply: PingReply, more: str = "") -> Finding:
    """Make the finding of a servo whose model is not known here, so that nothing is read of it."""
    known = ", ".join(model.name for model in servo_models())
    return found(
        "S01",
        where,
        f"its model number, {reply.model_number}, is not known here{more}",
        f"use a servo of a known model ({known})",
    )


def check_settings(chart: Chart, servo: ServoSpec, mend: str) -> Iterator[Finding]:
    """Compare a servo's EEPROM with the file; its position limits are not looked at here."""
    settings, values = servo.settings, chart.values
    # what moves a joint must agree with the file even where that says nothing
    usual = {} if servo.joint is None else _USUAL
    for name, code in _CODES.items():
        wanted = settings.get(name, usual.get(name))
        if wanted is None or name not in values:
            continue
        if name == "Drive Mode":
            yield from _check_direction(chart, wanted, mend)
        elif name == "Secondary(Shadow) ID":
            if min(values[name], _NO_SECONDARY_ID) != min(wanted, _NO_SECONDARY_ID):
                yield from _differs(chart, code, name, wanted, mend)
        elif not (name == "Homing Offset" and is_coupled(servo) and name not in settings):
            yield from _differs(chart, code, name, wanted, mend)
    for name, wanted in settings.items():
        area = servo.servo_model.table[name].area
        if name not in _SINGLED_OUT and area is Area.EEPROM:
            yield from _differs(chart, "S20", name, wanted, mend)


def check_limits(
    chart: Chart, servo: ServoSpec, limits: JointLimits, joint: int, mend: str
) -> Iterator[Finding]:
    """See that a leader in position mode takes every goal within its joint's range."""
    names = ("Min Position Limit", "Max Position Limit")
    if servo.zero_ticks is None or any(name not in chart.values for name in names):
        return
    if operating_mode(servo) != ONE_TURN_MODE:
        return
    per_rad = servo.servo_model.pulses_per_rad
    low = servo.zero_ticks + float(limits.q_min[joint]) * per_rad
    high = servo.zero_ticks + float(limits.q_max[joint]) * per_rad
    have = tuple(chart.values[name] for name in names)
    for name, limit, reach, beyond in (
        (names[0], have[0], low, have[0] - low),
        (names[1], have[1], high, high - have[1]),
    ):
        if beyond > 1.5:  # a tick of rounding is free
            wanted = servo.settings.get(name, round(reach))
            yield found(
                "S19",
                chart.where,
                f"its {name} is {limit}, but joint {servo.joint!r} may go to {reach:.0f} ticks",
                f"{set_register(mend, chart.model, chart.servo_id, name, wanted)}; or narrow the "
                "joint in the arm's file",
            )


def check_other_limits(chart: Chart, servo: ServoSpec, mend: str) -> Iterator[Finding]:
    """Compare the position limits with the file where no joint's range asks for them."""
    for name in ("Min Position Limit", "Max Position Limit"):
        if name in servo.settings:
            yield from _differs(chart, "S20", name, servo.settings[name], mend)


def _check_direction(chart: Chart, wanted: int, mend: str) -> Iterator[Finding]:
    have = chart.values.get("Drive Mode", wanted)
    if have == wanted:
        return
    remedy = set_register(mend, chart.model, chart.servo_id, "Drive Mode", wanted)
    if (have ^ wanted) & _REVERSED:
        cause = (
            f"its Drive Mode is {have}, the arm's file says {wanted}: the joint would turn the "
            "other way"
        )
        yield found("S14", chart.where, cause, f"{remedy}; or correct drive_mode in the arm's file")
    else:
        cause = f"its Drive Mode is {have}, the arm's file says {wanted}"
        yield found("S15", chart.where, cause, remedy)


def _differs(chart: Chart, code: str, name: str, wanted: int, mend: str) -> Iterator[Finding]:
    have = chart.values.get(name, wanted)
    if have != wanted:
        remedy = set_register(mend, chart.model, chart.servo_id, name, wanted)
        cause = f"its {name} is {have}, the arm's file says {wanted}"
        yield found(code, chart.where, cause, f"{remedy}; or correct the arm's file")


def named(charts: Mapping[int, Chart], servo: ServoSpec) -> Chart | None:
    """Give the chart of a servo of the file; None: it could not be read, or is another model."""
    chart = charts.get(servo.servo_id)
    return chart if chart is not None and chart.model is servo.servo_model else None
