"""Motions as plain values that JSON can hold, and back, without losing a bit.

A document says the joints and their limits, and the motion as it is: the B-spline of each
section and the nodes of its time law. All numbers are SI: rad, of sliding joints m, and s.
"""

from collections.abc import Mapping, Sequence
from math import inf
from typing import Any, cast

import numpy as np

from splinearm.arrays import FloatArray, frozen_array
from splinearm.curves.bspline import BSpline
from splinearm.errors import SplinearmError
from splinearm.joints import JointKind, JointLimits

from .joint_path import JointPath
from .section import Law, Section
from .time_law import TimeLaw
from .trajectory import JointTrajectory

FORMAT = "splinearm-motion/1"
"""What a document says it is."""

_SAME = 1e-9
"""Sections follow each other if they are nearer than this, rad or m, and rad/s or m/s."""

Document = dict[str, Any]
"""Values that JSON can hold, by name."""


def to_document(trajectory: JointTrajectory, arm: str = "") -> Document:
    """Give a motion as values that JSON can hold.

    Args:
        trajectory: The motion.
        arm: Name of the arm that it is for.
    """
    limits = trajectory.limits
    return {
        "format": FORMAT,
        "units": "SI: rad, of sliding joints m; s",
        "arm": arm,
        "joints": {
            "names": list(limits.names),
            "kinds": [kind.value for kind in limits.kinds],
            **{name: _listed(getattr(limits, name)) for name in _LIMITS},
        },
        "q_start": trajectory.q_start.tolist(),
        "sections": [_section_document(section) for section in trajectory.sections],
    }


def from_document(document: Mapping[str, Any]) -> JointTrajectory:
    """Give the motion that a document holds.

    Raises:
        TypeError: With the place in the document where something is no list or has no names.
        ValueError: With the place, if something is missing, is not what it must be, or the
            sections do not follow each other.
    """
    told = _get(document, "format", "document")
    if told != FORMAT:
        raise ValueError(f"format: want {FORMAT!r}, got {told!r}")
    limits = _limits(_get(document, "joints", "document"))
    q_start = _array(document, "q_start", "document", (limits.n,))
    sections = _get(document, "sections", "document")
    if not isinstance(sections, Sequence) or isinstance(sections, str):
        raise TypeError(f"sections: want a list, got {sections!r}")
    parts = [_section(part, f"sections[{i}]") for i, part in enumerate(sections)]
    trajectory = JointTrajectory(tuple(parts), q_start, limits)
    _require_continuity(trajectory)
    return trajectory


_LIMITS = ("q_min", "q_max", "qd_max", "qdd_max", "qddd_max", "torque_max")


def _listed(values: FloatArray | None) -> list[float | None] | None:
    """Give numbers as JSON has them: null where there is no limit."""
    if values is None:
        return None
    return [value if np.isfinite(value) else None for value in values.tolist()]


def _section_document(section: Section) -> Document:
    curve = section.path.curve
    law = cast(TimeLaw, section.law)
    return {
        "path": {
            "degree": curve.degree,
            "knots": curve.knots.tolist(),
            "points": curve.points.tolist(),
        },
        "law": {"kind": "cells", "s": law.s.tolist(), "x": law.x.tolist()},
        "dwell_s": section.dwell,
    }


def _limits(joints: object) -> JointLimits:
    names = _get(joints, "names", "joints")
    kinds = _get(joints, "kinds", "joints")
    values: dict[str, FloatArray | None] = {}
    for name, none in zip(_LIMITS, (-inf, inf, None, None, None, None), strict=True):
        given = _get(joints, name, "joints")
        if given is not None and none is not None:
            given = [none if value is None else value for value in given]
        values[name] = given
    try:
        return JointLimits(
            names=tuple(str(name) for name in names),
            kinds=tuple(JointKind(kind) for kind in kinds),
            **cast("dict[str, Any]", values),
        )
    except (TypeError, ValueError) as error:
        raise ValueError(f"joints: {error}") from error


def _section(part: object, where: str) -> Section:
    path, law = _get(part, "path", where), _get(part, "law", where)
    dwell = _get(part, "dwell_s", where)
    if not isinstance(dwell, int | float) or not 0.0 <= dwell < inf:
        raise ValueError(f"{where}.dwell_s: want a time of at least 0, got {dwell!r}")
    try:
        curve = BSpline(
            _get(path, "knots", f"{where}.path"),
            _get(path, "points", f"{where}.path"),
            _get(path, "degree", f"{where}.path"),
        )
        joints = JointPath(curve)
    except (SplinearmError, TypeError, ValueError) as error:
        raise ValueError(f"{where}.path: {error}") from error
    return Section(joints, _law(law, joints, f"{where}.law"), float(dwell))


def _law(law: object, path: JointPath, where: str) -> Law:
    kind = _get(law, "kind", where)
    if kind != "cells":
        raise ValueError(f"{where}.kind: want 'cells', got {kind!r}")
    s = _array(law, "s", where, (None,))
    x = _array(law, "x", where, (len(s),))
    first, last = path.domain
    if len(s) == 0 or (np.diff(s) <= 0.0).any() or s[0] < first or s[-1] > last:
        raise ValueError(f"{where}.s: want rising nodes from {first} to {last}, got {s.tolist()}")
    if (x < 0.0).any() or (len(x) > 1 and (x[:-1] + x[1:] <= 0.0).any()):
        raise ValueError(f"{where}.x: want none below zero and no two neighbours zero")
    return TimeLaw(s, x)


def _require_continuity(trajectory: JointTrajectory) -> None:
    """Refuse sections that do not begin where and as fast as the motion has come."""
    q, qd = trajectory.q_start, None
    for i, section in enumerate(trajectory.sections):
        begins, begins_at, _ = section.at(0.0)
        gap = float(np.abs(begins - q).max())
        if gap > _SAME:
            raise ValueError(f"sections[{i}]: begins {gap:g} rad or m from where the motion is")
        if qd is not None and np.abs(begins_at - qd).max() > _SAME:
            raise ValueError(f"sections[{i}]: does not begin as fast as the motion comes")
        q, qd, _ = section.at(section.duration)


def _get(values: object, key: str, where: str) -> Any:  # noqa: ANN401 - whatever JSON holds
    if not isinstance(values, Mapping):
        raise TypeError(f"{where}: want names with values, got {values!r}")
    if key not in values:
        raise ValueError(f"{where}: {key} is missing")
    return values[key]


def _array(values: object, key: str, where: str, shape: tuple[int | None, ...]) -> FloatArray:
    return frozen_array(_get(values, key, where), shape, f"{where}.{key}")
