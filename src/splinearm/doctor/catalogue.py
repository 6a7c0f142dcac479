"""Every finding that there can be, and which is to be mended first."""

from dataclasses import dataclass

from .finding import Finding, Severity

_ERROR, _WARNING, _HINT = Severity.ERROR, Severity.WARNING, Severity.HINT


@dataclass(frozen=True, slots=True)
class Ailment:
    """What findings of one code have in common."""

    code: str
    """The code."""
    severity: Severity
    """How much it usually matters."""
    what: str
    """What it is."""
    remedy: str
    """What mends it, in general."""


AILMENTS = (
    Ailment("C01", _ERROR, "Python is too old", "install Python 3.11 or newer"),
    Ailment("C02", _ERROR, "a library is missing", "`pip install` it again"),
    Ailment(
        "C03",
        _ERROR,
        "remains of another MuJoCo",
        "`pip uninstall -y mujoco mujoco-core && pip install mujoco`",
    ),
    Ailment("P01", _ERROR, "there is no such port", "plug the adapter in, or name another port"),
    Ailment("P02", _ERROR, "you may not open the port", "`sudo usermod -aG dialout $USER`"),
    Ailment("P03", _ERROR, "you may open the port only after logging in anew", "log out and in"),
    Ailment("P04", _ERROR, "another program holds the port", "end that program"),
    Ailment("P05", _WARNING, "the adapter holds bytes back", "set its latency timer to 1 ms"),
    Ailment("P06", _ERROR, "the port is no servo adapter", "name the port of the adapter"),
    Ailment("P07", _ERROR, "this is no serial port", "name a serial port"),
    Ailment("P08", _ERROR, "the port cannot be used", "plug the adapter in anew"),
    Ailment("L01", _ERROR, "no servo answers", "switch the servos' power on, check the cable"),
    Ailment("L02", _ERROR, "a servo has another baud rate", "`splinearm setup ARM`"),
    Ailment("L03", _ERROR, "a servo speaks another protocol", "`splinearm setup ARM`"),
    Ailment(
        "L05", _ERROR, "two servos have one id", "connect them one by one: `splinearm setup ARM`"
    ),
    Ailment("L04", _ERROR, "a servo is missing", "check its cable and its power"),
    Ailment("L06", _WARNING, "a servo that the arm's file does not name", "name it or unplug it"),
    Ailment("L07", _WARNING, "answers come damaged", "shorten and tighten the cables"),
    Ailment("L08", _WARNING, "answers get lost", "tighten the plugs, change the cable"),
    Ailment("L09", _WARNING, "a servo waits before it answers", "`splinearm setup ARM`"),
    Ailment("L10", _WARNING, "a servo answers pings and no reads", "switch its power off and on"),
    Ailment("L11", _WARNING, "the adapter hears itself", "switch the echo of the adapter off"),
    Ailment("S01", _ERROR, "a servo of another model", "correct the arm's file or the id"),
    Ailment("S06", _ERROR, "input voltage error", "mend the supply, then `splinearm recover`"),
    Ailment("S07", _ERROR, "overheating error", "let it cool down, then `splinearm recover`"),
    Ailment("S08", _ERROR, "motor encoder error", "power off and on; else replace the servo"),
    Ailment("S09", _ERROR, "electrical shock error", "check cables and supply, then recover"),
    Ailment("S10", _ERROR, "overload error", "free the joint, then `splinearm recover`"),
    Ailment("S11", _ERROR, "the servo refuses torque", "`splinearm recover ARM`"),
    Ailment("S12", _ERROR, "the servo has torque but no force", "`splinearm setup ARM`"),
    Ailment("S04", _WARNING, "low voltage", "a stronger supply or thicker cables"),
    Ailment("S05", _WARNING, "high voltage", "lower the supply"),
    Ailment("S13", _WARNING, "hot", "let it rest, lighten its load"),
    Ailment("S14", _ERROR, "the direction is reversed", "`splinearm setup ARM`"),
    Ailment("S15", _ERROR, "another Drive Mode", "`splinearm setup ARM`"),
    Ailment("S16", _ERROR, "another Operating Mode", "`splinearm setup ARM`"),
    Ailment("S17", _ERROR, "another Homing Offset", "`splinearm setup ARM`"),
    Ailment("S18", _ERROR, "another secondary id", "`splinearm setup ARM`"),
    Ailment("S19", _ERROR, "the servo ends within the joint's range", "`splinearm setup ARM`"),
    Ailment("S20", _WARNING, "another setting", "`splinearm setup ARM`"),
    Ailment("S21", _ERROR, "the joint's zero is not known", "`splinearm calibrate ARM`"),
    Ailment("S22", _ERROR, "the joint is outside its range", "move it back by hand"),
    Ailment("S23", _ERROR, "a shadow stands apart from its leader", "set its Homing Offset"),
    Ailment("S24", _WARNING, "its watchdog has stopped the servo", "`splinearm recover ARM`"),
    Ailment("S02", _WARNING, "old firmware", "update it with DYNAMIXEL Wizard 2"),
    Ailment("S03", _WARNING, "firmware without fast reads", "update it with DYNAMIXEL Wizard 2"),
    Ailment("C07", _WARNING, "the loop is slow", "a higher baud rate, fewer delays"),
    Ailment("C08", _HINT, "the loop is slower than the line", "close other programs"),
    Ailment("C06", _HINT, "no real-time priority", "permit it in /etc/security/limits.conf"),
    Ailment("C05", _HINT, "no display and no EGL", "`sudo apt install libegl1 libgl1`"),
    Ailment("C04", _HINT, "an extra is missing", "`pip install 'splinearm[EXTRA]'`"),
)
"""All of them; of those of one severity the first is to be mended first."""

_BY_CODE = {ailment.code: ailment for ailment in AILMENTS}
_RANK = {ailment.code: k for k, ailment in enumerate(AILMENTS)}


def found(
    code: str, where: str, cause: str, remedy: str, *, severity: Severity | None = None
) -> Finding:
    """Make a finding.

    Args:
        code: One of the catalogue.
        where: What is concerned.
        cause: What was found.
        remedy: What mends it.
        severity: How much it matters here; None: as usually.
    """
    ailment = _BY_CODE[code]
    return Finding(
        code=code,
        severity=severity or ailment.severity,
        what=ailment.what,
        cause=cause,
        remedy=remedy,
        where=where,
    )


def in_order(findings: list[Finding]) -> tuple[Finding, ...]:
    """Give findings in the order in which they are to be mended: what keeps the arm still first."""
    severities = list(Severity)
    return tuple(sorted(findings, key=lambda f: (severities.index(f.severity), _RANK[f.code])))
