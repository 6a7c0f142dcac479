"""Time laws as plain values that JSON can hold, and back."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from splinearm.arrays import FloatArray, frozen_array

from .joint_path import JointPath
from .pace import Pace
from .paced_law import PacedLaw
from .polynomial_law import PolynomialLaw
from .section import Law
from .smooth_law import SmoothLaw
from .time_law import TimeLaw

_SLACK = 1e-9
"""By this share of a path may rounding carry a law beyond its ends."""


def to_document(law: Law) -> dict[str, Any]:
    """Give a law by the name of its kind and its numbers."""
    if isinstance(law, TimeLaw):
        return {"kind": "cells", "s": law.s.tolist(), "x": law.x.tolist()}
    if isinstance(law, SmoothLaw):
        return {"kind": "smooth", **{name: getattr(law, name).tolist() for name in _SMOOTH}}
    if isinstance(law, PolynomialLaw):
        coefficients = law.coefficients.tolist()
        return {"kind": "polynomial", "coefficients": coefficients, "duration": law.duration}
    if isinstance(law, PacedLaw):
        pace = {name: values.tolist() for name, values in law.pace._asdict().items()}
        return {"kind": "paced", "law": to_document(law.law), "pace": pace}
    raise TypeError(f"law: want one of this room's, got {type(law).__name__}")


def from_document(document: object, path: JointPath, where: str) -> Law:
    """Give the law that a document holds.

    Args:
        document: What ``to_document`` gave.
        path: The path that it runs along.
        where: What messages call its place.

    Raises:
        TypeError: If something has no names where it should.
        ValueError: If something is missing or makes no law on this path.
    """
    kind = value_of(document, "kind", where)
    if kind not in _READERS:
        raise ValueError(f"{where}.kind: want one of {', '.join(_READERS)}, got {kind!r}")
    law = _READERS[kind](document, path, where)
    first, last = path.domain
    s = law.sample(np.union1d(law.t, np.linspace(0.0, law.duration, 65)))[0]
    slack = _SLACK * (last - first)
    if not np.isfinite(s).all() or s.min() < first - slack or s.max() > last + slack:
        raise ValueError(f"{where}: leaves its path, which goes from {first} to {last}")
    if (np.diff(s) < -slack).any():
        raise ValueError(f"{where}: goes backwards")
    return law


def value_of(values: object, key: str, where: str) -> Any:  # noqa: ANN401 - whatever JSON holds
    """Give a value by its name.

    Raises:
        TypeError: If there are no names.
        ValueError: If it is missing.
    """
    if not isinstance(values, Mapping):
        raise TypeError(f"{where}: want names with values, got {values!r}")
    if key not in values:
        raise ValueError(f"{where}: {key} is missing")
    return values[key]


def array_of(values: object, key: str, where: str, shape: tuple[int | None, ...]) -> FloatArray:
    """Give an array by its name; errors as ``value_of`` and ``frozen_array``."""
    return frozen_array(value_of(values, key, where), shape, f"{where}.{key}")


_SMOOTH = ("s", "t", "speed", "acceleration", "jerks", "growth")


def _cells(document: object, path: JointPath, where: str) -> Law:
    s = array_of(document, "s", where, (None,))
    x = array_of(document, "x", where, (len(s),))
    if len(s) == 0 or (np.diff(s) <= 0.0).any():
        raise ValueError(f"{where}.s: want rising nodes, got {s.tolist()}")
    if (x < 0.0).any() or (len(x) > 1 and (x[:-1] + x[1:] <= 0.0).any()):
        raise ValueError(f"{where}.x: want none below zero and no two neighbours zero")
    return TimeLaw(s, x)


def _smooth(document: object, path: JointPath, where: str) -> Law:
    return SmoothLaw(**{name: array_of(document, name, where, (None,)) for name in _SMOOTH})


def _polynomial(document: object, path: JointPath, where: str) -> Law:
    duration = value_of(document, "duration", where)
    if isinstance(duration, bool) or not isinstance(duration, int | float):
        raise TypeError(f"{where}.duration: want a number, got {duration!r}")
    return PolynomialLaw(array_of(document, "coefficients", where, (None,)), float(duration))


def _paced(document: object, path: JointPath, where: str) -> Law:
    law = from_document(value_of(document, "law", where), path, f"{where}.law")
    told = value_of(document, "pace", where)
    t = array_of(told, "t", f"{where}.pace", (None,))
    rest = [array_of(told, n, f"{where}.pace", (len(t),)) for n in Pace._fields[1:]]
    if len(t) == 0 or t[0] != 0.0 or (np.diff(t) <= 0.0).any():
        raise ValueError(f"{where}.pace.t: want rising times from 0 on, got {t.tolist()}")
    return PacedLaw(law, Pace(t, *rest))


_READERS: dict[str, Callable[[object, JointPath, str], Law]] = {
    "cells": _cells,
    "smooth": _smooth,
    "polynomial": _polynomial,
    "paced": _paced,
}
