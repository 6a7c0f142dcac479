"""What is to be said of a servo: the doctor's findings, and the levels at which arms would stop."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import isnan

from splinearm.doctor.catalogue import found, in_order
from splinearm.doctor.chart import Chart
from splinearm.doctor.finding import Finding, Severity
from splinearm.doctor.servo_check import check_errors, check_health
from splinearm.drivers.ability import HARDWARE_ERROR
from splinearm.drivers.health import LIGHTEN
from splinearm.drivers.health_limit import HealthLimits

from .sample import Level, ServoSample, Verdict

_LEVELS = {Severity.ERROR: Level.STOP, Severity.WARNING: Level.WARN, Severity.HINT: Level.WELL}


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Evidence:
    """What is known of a servo besides its sample."""

    chart: Chart | None
    """Its registers; None: they are not known."""
    limits: HealthLimits
    """What is borne, with a number in every field once it has answered."""
    effort: float
    """Its current, A, or its load as a share, over half a second."""
    port: str
    """The port, for remedies."""
    arm: str | None
    """How the user named the arm, for remedies."""
    complaint: tuple[str, str] | None = None
    """The doctor's code and the cause, where too many of its answers are damaged or lost."""
    other: Finding | None = None
    """That it is of another model than the file says."""
    is_calibrated: bool = True
    """Whether the zero of its joint is known."""


def judge(facts: ServoSample, evidence: Evidence) -> Verdict:
    """Say how a servo fares, and what mends what is worst."""
    fields = _fields(facts, evidence)
    findings = in_order(list(_findings(facts, evidence)))
    if not findings:
        return _by_effort(facts, evidence, fields)
    worst = findings[0]
    level = max((*fields.values(), *(_LEVELS[finding.severity] for finding in findings)))
    return Verdict(
        level=level, code=worst.code, what=worst.what, remedy=worst.remedy, fields=fields
    )


def _findings(facts: ServoSample, evidence: Evidence) -> Iterator[Finding]:
    where = f"servo {facts.servo_id} ({facts.name})"
    if not facts.answers and not facts.model and evidence.other is not None:
        yield evidence.other  # it answers pings, but who can read it?
        return
    if not facts.answers:
        yield found("L04", where, "it does not answer", "check its cable and its power")
        return
    if evidence.other is not None:
        yield evidence.other
    chart = evidence.chart
    if chart is not None:
        if facts.errors and HARDWARE_ERROR not in chart.model.table:
            chart = replace(chart, values={**chart.values, HARDWARE_ERROR: _status(facts, chart)})
        yield from check_errors(chart, evidence.port, evidence.arm)
        yield from check_health(chart, evidence.limits)
    if evidence.complaint is not None:
        code, cause = evidence.complaint
        yield found(code, where, cause, "shorten and tighten its cables and plugs")
    if not evidence.is_calibrated:
        arm = evidence.arm or "ARM"
        cause = "its position is from the middle of its travel"
        yield found(
            "S21", where, cause, f"run `splinearm calibrate {arm}`", severity=Severity.WARNING
        )


def _status(facts: ServoSample, chart: Chart) -> int:
    """Give the bits of errors that a servo without a register for them has told."""
    bits = chart.model.error_bits.items()
    return sum(bit for bit, name in bits if name in facts.errors)


def _fields(facts: ServoSample, evidence: Evidence) -> dict[str, Level]:
    """Give the levels of single quantities that are not well."""
    limits = evidence.limits
    effort = "current" if isnan(facts.load) else "load"
    voltage = max(
        _high(facts.voltage, limits.voltage_high_warn, limits.voltage_high_stop),
        _high(-facts.voltage, -limits.voltage_low_warn, -limits.voltage_low_stop),
    )
    levels = {
        "temperature": _high(facts.temperature, limits.temperature_warn, limits.temperature_stop),
        "voltage": voltage,
        effort: _high(
            evidence.effort, getattr(limits, f"{effort}_warn"), getattr(limits, f"{effort}_stop")
        ),
        "errors": Level.STOP if facts.errors else Level.WELL,
    }
    return {name: level for name, level in levels.items() if level is not Level.WELL}


def _high(value: float, warn: float, stop: float) -> Level:
    """Give the level of a value that may be too high; one that is not known is well."""
    if value >= stop:
        return Level.STOP
    return Level.WARN if value >= warn else Level.WELL


def _by_effort(facts: ServoSample, evidence: Evidence, fields: dict[str, Level]) -> Verdict:
    """Give the verdict where the doctor has nothing to say: at most it works too hard."""
    level = max(fields.values(), default=Level.WELL)
    if level is Level.WELL:
        return Verdict()
    if "load" in fields:
        what = f"load {evidence.effort * 100.0:.0f} % over half a second"
    else:
        what = f"current {evidence.effort:.2f} A over half a second"
    return Verdict(level=level, what=what, remedy=LIGHTEN, fields=fields)
