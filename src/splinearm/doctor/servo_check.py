"""What is wrong with a servo by itself: errors, supply, heat, firmware, and how it answers."""

from collections.abc import Iterator

from splinearm.drivers.health_limit import HealthLimits

from .advice import recover, set_register, setup
from .catalogue import found
from .chart import Chart
from .finding import Finding

_ERRORS = {
    "input voltage": (
        "S06",
        "its supply was too low or too high",
        "measure the supply at this servo under load and mend it (stronger supply, thicker cable)",
    ),
    "overheating": ("S07", "it got too hot", "let it cool down and lighten its load"),
    "motor encoder": (
        "S08",
        "its encoder cannot be trusted",
        "switch its power off and on, see that Present Position follows the joint moved by hand; "
        "replace the servo if it does not",
    ),
    "electrical shock": (
        "S09",
        "its electronics met a surge or have too little power",
        "check the supply and that no wire is pinched or touches another",
    ),
    "overload": (
        "S10",
        "its load was too high for too long",
        "free the joint and lighten its load",
    ),
}
_TRIPPED = 255
_ANSWER_ALL = 2
_DELAY_UNIT, _LONG_DELAY = 2e-6, 40e-6  # s
_X_AS_DESCRIBED, _XL330_AS_DESCRIBED = 42, 53
"""First firmwares of which the register tables of this package hold: before 42 an X servo knows no
Clear and no profile by time (e-Manual, "Drive Mode"), before 53 an XL330 has other indirect
addresses (e-Manual, "XL330", control table)."""


def check_errors(chart: Chart, port: str, arm: str | None) -> Iterator[Finding]:
    """Say which hardware errors are latched, and whether torque is refused because of them."""
    values = chart.values
    status = values.get("Hardware Error Status", 0)
    comeback = recover(port, arm)
    for name in chart.model.hardware_errors(status):
        code, cause, act = _ERRORS.get(name, ("S10", f"it reports {name}", "see its manual"))
        text = f"{cause} (Hardware Error Status 0x{status:02X})"
        yield found(code, chart.where, text, f"{act}; then {comeback}")
    cutting = chart.model.hardware_errors(status & values.get("Shutdown", 0))
    if cutting and not values.get("Torque Enable", 0):
        yield found(
            "S11",
            chart.where,
            f"it has cut its torque because of {' and '.join(cutting)} and refuses it until it "
            "is rebooted",
            f"once the cause is gone {comeback}",
        )
    if values.get("Bus Watchdog") == _TRIPPED:
        yield found(
            "S24",
            chart.where,
            "the bus was silent while it moved, so that its watchdog stopped it; it takes no goals",
            comeback,
        )
    for name in ("PWM Limit", "Current Limit"):
        if values.get(name) == 0:
            initial = chart.model.table[name].initial
            value = initial if isinstance(initial, int) else 0
            mend = setup(port, arm)
            remedy = set_register(mend, chart.model, chart.servo_id, name, value)
            yield found("S12", chart.where, f"its {name} is 0: it cannot push at all", remedy)


def check_health(chart: Chart, health: HealthLimits) -> Iterator[Finding]:
    """Say whether its supply and its temperature are where they should be."""
    values = chart.values
    borne = health.resolved(chart.model, values)
    if "Present Input Voltage" in values:
        volts = values["Present Input Voltage"] / 10.0
        if volts <= borne.voltage_low_warn:
            cause = f"its supply is {volts:g} V; at {borne.voltage_low_stop:g} V it stops"
            remedy = "charge the battery, or take a stronger supply or thicker cables"
            yield found("S04", chart.where, cause, remedy)
        elif volts >= borne.voltage_high_warn:
            cause = f"its supply is {volts:g} V; {borne.voltage_high_stop:g} V is its limit"
            yield found("S05", chart.where, cause, "lower the supply to what its manual names")
    if "Present Temperature" in values:
        degrees = values["Present Temperature"]
        if degrees >= borne.temperature_warn:
            yield found(
                "S13",
                chart.where,
                f"it is at {degrees} degC; at {borne.temperature_stop:g} degC the arm stops",
                "switch its torque off and let it cool down; then lighten its load",
            )


def check_firmware(chart: Chart) -> Iterator[Finding]:
    """Say whether its firmware is older than its registers here, or has no fast reads."""
    model, firmware = chart.model, chart.firmware
    remedy = "update it with DYNAMIXEL Wizard 2 (Firmware Recovery or Update)"
    first = _XL330_AS_DESCRIBED if model.name.startswith("XL330") else _X_AS_DESCRIBED
    if model.name.startswith("X") and model.protocols[0] == 2 and firmware < first:
        lacks = (
            "it has other indirect addresses"
            if model.name.startswith("XL330")
            else "it knows no fast reads, no Clear and no profiles by time"
        )
        cause = f"its firmware is {firmware}, older than {first}: {lacks}"
        if model.name != "XL320":
            yield found("S02", chart.where, cause, remedy)
    elif model.fast_read_firmware > 0 and firmware < model.fast_read_firmware:
        yield found(
            "S03",
            chart.where,
            f"its firmware is {firmware}; from {model.fast_read_firmware} on it answers fast reads,"
            " without which a cycle takes longer",
            remedy,
        )


def check_manner(chart: Chart, told_delay: int, mend: str) -> Iterator[Finding]:
    """Say whether it answers late, or not everything.

    Args:
        chart: Its registers.
        told_delay: What its Return Delay Time should be.
        mend: The command that sets servos.
    """
    level = chart.values.get("Status Return Level", _ANSWER_ALL)
    if level < _ANSWER_ALL:
        yield found(
            "L10",
            chart.where,
            f"its Status Return Level is {level}: it answers no writes",
            _speak_again(),
        )
    delay = chart.values.get("Return Delay Time", 0)
    if delay * _DELAY_UNIT > _LONG_DELAY and delay != told_delay:
        yield found(
            "L09",
            chart.where,
            f"it waits {delay * 2} us before every answer (Return Delay Time is {delay}, not "
            f"{told_delay})",
            set_register(mend, chart.model, chart.servo_id, "Return Delay Time", told_delay),
        )


def mute(where: str) -> Finding:
    """Make the finding of a servo that answers pings and nothing else."""
    cause = "it answers pings and no reads: its Status Return Level is 0, or its answers are lost"
    return found("L10", where, cause, _speak_again())


def _speak_again() -> str:
    return "switch its power off and on, which sets its Status Return Level to 2"
