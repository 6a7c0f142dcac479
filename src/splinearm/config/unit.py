"""The units that keys of files wear, as multiples of SI: the only place where they are converted.

Numbers come as the decimals they are in the file and are rounded to float64 once, after the
conversion: ``65.66`` millimetres become exactly the float that is nearest to 0.06566.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Context, Decimal

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointKind

_ARITHMETIC = Context(prec=40, traps=[])
_PI = Decimal("3.14159265358979323846264338327950288419716939937")
_ONE = Decimal(1)


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit of measure, or none."""

    name: str
    """What a person calls it, plural; empty for plain numbers."""
    si: Decimal
    """How much of the SI unit one of it is."""

    def to_si(self, value: int | Decimal) -> float:
        """Give a value of this unit in SI; infinite or NaN if it is, or is too large."""
        return float(_ARITHMETIC.multiply(Decimal(value), self.si))

    def of_si(self, value: float) -> float:
        """Give a value in SI in this unit, for messages."""
        return value / float(self.si)

    def __str__(self) -> str:
        return f" in {self.name}" if self.name else ""


DEG = Unit("degrees", _ARITHMETIC.divide(_PI, Decimal(180)))
"""Degrees."""
MM = Unit("millimetres", Decimal("0.001"))
"""Millimetres."""
PLAIN = Unit("", _ONE)
"""Numbers that count nothing."""
_MIXED = Unit("degrees (turning joints) and millimetres (sliding joints)", Decimal("NaN"))

_UNITS: Mapping[str, Unit] = {
    "mm": MM,
    "mm_s": Unit("millimetres per second", MM.si),
    "mm_s2": Unit("millimetres per second squared", MM.si),
    "mm_s3": Unit("millimetres per second cubed", MM.si),
    "mm_min": Unit("millimetres per minute", _ARITHMETIC.divide(MM.si, Decimal(60))),
    "rpm": Unit(
        "turns per minute", _ARITHMETIC.divide(_ARITHMETIC.multiply(_PI, Decimal(2)), Decimal(60))
    ),
    "deg": DEG,
    "deg_s": Unit("degrees per second", DEG.si),
    "deg_s2": Unit("degrees per second squared", DEG.si),
    "deg_s3": Unit("degrees per second cubed", DEG.si),
    "deg_mm": _MIXED,
    "s": Unit("seconds", _ONE),
    "hz": Unit("hertz", _ONE),
    "percent": Unit("percent", Decimal("0.01")),
    "kg": Unit("kilograms", _ONE),
    "kg_m2": Unit("kilogram square metres", _ONE),
    "nm": Unit("newton metres", _ONE),
    "n": Unit("newtons", _ONE),
    "v": Unit("volts", _ONE),
    "a": Unit("amperes", _ONE),
    "degc": Unit("degrees Celsius", _ONE),
}
_FOREIGN = frozenset(
    {"m", "cm", "um", "in", "inch", "ft", "m_s", "m_s2", "cm_s", "m_min", "nmm", "g"}
    | {"rad", "rad_s", "rad_s2", "rad_s3", "rev", "turns", "ms", "us", "min", "khz"}
    | {"mv", "ma", "degf", "ticks", "ratio", "share"}
)
"""Units that people also write and that no key here takes: worth a better answer than "unknown"."""


def unit_of(key: str) -> Unit:
    """Give the unit that a key wears."""
    return _UNITS.get(_split(key)[1], PLAIN)


def stem_of(key: str) -> str:
    """Give a key without its unit."""
    return _split(key)[0]


def same_but_for_unit(given: str, wanted: str) -> bool:
    """Whether ``given`` is ``wanted``, which wears a unit, with another unit or none."""
    stem, suffix = _split(wanted)
    return suffix in _UNITS and given != wanted and stem_of(given) == stem


def positions_key(stem: str, kinds: Sequence[JointKind]) -> str:
    """Give the key under which the positions of such joints stand."""
    return f"{stem}_deg_mm" if JointKind.PRISMATIC in kinds else f"{stem}_deg"


def joint_units(kinds: Sequence[JointKind]) -> tuple[Unit, ...]:
    """Give the unit in which files have the position of each joint."""
    return tuple(DEG if kind is JointKind.REVOLUTE else MM for kind in kinds)


def from_file_units(values: FloatArray, kinds: Sequence[JointKind]) -> FloatArray:
    """Give joint positions, shape (..., n), rad or m, of degrees or millimetres."""
    return values * _per_unit(kinds)


def to_file_units(q: FloatArray, kinds: Sequence[JointKind]) -> FloatArray:
    """Give joint positions in degrees or millimetres, shape (..., n), of rad or m."""
    return q / _per_unit(kinds)


def _per_unit(kinds: Sequence[JointKind]) -> FloatArray:
    return np.array([float(unit.si) for unit in joint_units(kinds)])


def _split(key: str) -> tuple[str, str]:
    """Give the stem of a key and its unit, "" if it wears none."""
    parts = key.split("_")
    for i in range(1, len(parts)):
        suffix = "_".join(parts[i:])
        if suffix in _UNITS or suffix in _FOREIGN:
            return "_".join(parts[:i]), suffix
    return key, ""
