"""Motions as plain values that JSON can hold, and back, without losing a bit.

A document says the joints and their limits, and the motion as it is: the B-spline of each
section and the nodes of its time law. All numbers are SI: rad, of sliding joints m, and s.
"""

from collections.abc import Mapping, Sequence
from math import inf
from typing import Any, cast

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline
from splinearm.errors import SplinearmError
from splinearm.joints import JointKind, JointLimits

from . import law_document
from .joint_path import JointPath
from .law_document import array_of, value_of
from .section import Section
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
    told = value_of(document, "format", "document")
    if told != FORMAT:
        raise ValueError(f"format: want {FORMAT!r}, got {told!r}")
    limits = _limits(value_of(document, "joints", "document"))
    q_start = array_of(document, "q_start", "document", (limits.n,))
    sections = value_of(document, "sections", "document")
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
    return {
        "path": {
            "degree": curve.degree,
            "knots": curve.knots.tolist(),
            "points": curve.points.tolist(),
        },
        "law": law_document.to_document(section.law),
        "dwell_s": section.dwell,
    }


def _limits(joints: object) -> JointLimits:
    names = value_of(joints, "names", "joints")
    kinds = value_of(joints, "kinds", "joints")
    values: dict[str, FloatArray | None] = {}
    for name, none in zip(_LIMITS, (-inf, inf, None, None, None, None), strict=True):
        given = value_of(joints, name, "joints")
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
    path, law = value_of(part, "path", where), value_of(part, "law", where)
    dwell = value_of(part, "dwell_s", where)
    if not isinstance(dwell, int | float) or not 0.0 <= dwell < inf:
        raise ValueError(f"{where}.dwell_s: want a time of at least 0, got {dwell!r}")
    try:
        curve = BSpline(
            value_of(path, "knots", f"{where}.path"),
            value_of(path, "points", f"{where}.path"),
            value_of(path, "degree", f"{where}.path"),
        )
        joints = JointPath(curve)
    except (SplinearmError, TypeError, ValueError) as error:
        raise ValueError(f"{where}.path: {error}") from error
    return Section(joints, law_document.from_document(law, joints, f"{where}.law"), float(dwell))


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
