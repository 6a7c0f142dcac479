"""A sample as plain numbers in the units that people use: the same in JSON, CSV, UDP and tables.

Everything is rounded here, once: what a table shows is what a program gets.
"""

from collections.abc import Iterator, Mapping
from math import isnan, pi
from typing import TypeAlias

from splinearm.joints import JointKind

from .sample import Sample, ServoSample

SCHEMA = "splinearm-monitor/1"
"""What the JSON of a sample says it is."""

Document: TypeAlias = Mapping[str, "Value"]
"""Names and what they hold."""
Value: TypeAlias = str | float | int | bool | list[str] | Document | None
"""A number, a word, nothing where nothing is known, or more of the same."""

_UNITS = {JointKind.REVOLUTE: ("deg", 180.0 / pi), JointKind.PRISMATIC: ("mm", 1e3)}


def unit_of_kind(kind: JointKind) -> tuple[str, float]:
    """Give the unit of the positions of such joints, "deg" or "mm", and how many an SI unit has."""
    return _UNITS[kind]


def unit_of(servo: ServoSample) -> str:
    """Give the unit of a servo's position, "deg" or "mm"."""
    return _UNITS[servo.kind][0]


def document(sample: Sample) -> dict[str, Value]:
    """Give a sample for JSON: one object, in it one for each servo by its name.

    PlotJuggler takes it as it is: its ``timestamp`` is the time, each number a curve.
    """
    rhythm, servos = sample.rhythm, sample.servos
    return {
        "schema": SCHEMA,
        "timestamp": round(sample.t, 6),
        "sample": sample.number,
        "arm": sample.arm,
        "port": sample.port,
        "baud": sample.baud,
        "connected": not sample.trouble,
        "trouble": sample.trouble or None,
        "level": sample.level.word,
        "rate_hz": rounded(rhythm.rate, 2),
        "wanted_rate_hz": rounded(rhythm.wanted, 2),
        "jitter_ms": {
            "p50": rounded(rhythm.jitter_p50 * 1e3, 3),
            "p99": rounded(rhythm.jitter_p99 * 1e3, 3),
            "max": rounded(rhythm.jitter_max * 1e3, 3),
        },
        "reads": sum(servo.reads for servo in servos),
        "lost": sum(servo.lost for servo in servos),
        "damaged": sum(servo.damaged for servo in servos),
        "retries": sum(servo.retries for servo in servos),
        "servos": {servo.name: servo_document(servo) for servo in servos},
    }


def servo_document(servo: ServoSample) -> dict[str, Value]:
    """Give what a document says of one servo."""
    unit, per_si = _UNITS[servo.kind]
    verdict = servo.verdict
    return {
        "id": servo.servo_id,
        "joint": servo.joint,
        "model": servo.model or None,
        "answers": servo.answers,
        f"position_{unit}": rounded(servo.position * per_si, 3),
        f"velocity_{unit}_s": rounded(servo.velocity * per_si, 2),
        "current_a": rounded(servo.current, 3),
        "mean_current_a": rounded(servo.mean_current, 3),
        "load_percent": rounded(servo.load * 100.0, 1),
        "temperature_degc": rounded(servo.temperature, 0),
        "voltage_v": rounded(servo.voltage, 1),
        "errors": list(servo.errors),
        "torque": servo.torque,
        "moving": servo.moving,
        "reads": servo.reads,
        "lost": servo.lost,
        "damaged": servo.damaged,
        "retries": servo.retries,
        "level": verdict.level.word,
        "code": verdict.code or None,
        "what": verdict.what or None,
        "remedy": verdict.remedy or None,
    }


def flat(document: Document) -> dict[str, str]:
    """Give a document as a row: by column its text; empty where nothing is known.

    Columns of a servo begin with its name and a full stop: ``elbow.position_deg``.
    """
    return dict(_cells(document, ""))


def _cells(document: Document, prefix: str) -> Iterator[tuple[str, str]]:
    for name, value in document.items():
        if name == "servos" and isinstance(value, Mapping):
            yield from _cells(value, "")
        elif isinstance(value, Mapping):
            yield from _cells(value, f"{prefix}{name}.")
        else:
            yield prefix + name, text_of(value)


def text_of(value: Value) -> str:
    """Give a value as text: "" for nothing, 1 and 0 for yes and no."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, list):
        return "; ".join(value)
    return str(value)


def rounded(value: float, digits: int) -> float | int | None:
    """Round a number, to a whole one with no digits; None: it is not known."""
    if isnan(value):
        return None
    number = round(float(value), digits)
    return int(number) if digits == 0 else number + 0.0  # no -0.0
