"""Surfaces through section curves."""

from collections.abc import Sequence

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError

from .bspline import BSpline
from .compatible import Sections, make_compatible
from .interpolation import Ends, interpolate
from .surface import BSplineSurface
from .surface_of_curves import surface_of


def lofted(
    sections: Sequence[BSpline],
    *,
    degree: int = 3,
    parameters: ArrayInput | None = None,
    ends: Ends = "free",
) -> BSplineSurface:
    """Give the surface that has curves as its sections, in their order (a skinned surface).

    u is the parameter of the first curve; places at the same share of all domains lie on one
    curve of the surface.

    Args:
        sections: The curves, at least two; closed: the first is not repeated.
        degree: Degree across them.
        parameters: The v of each section, rising, shape (k,), of a closed surface (k + 1,); None:
            from 0 to 1 by the mean distance of sections.
        ends: How it begins and ends across the sections: "free", "natural" or "closed".

    Raises:
        CurveError: If two neighbours are the same, no such surface is there, or a weight would not
            be above 0.
        ValueError: If numbers of coordinates, sections, parameters or the degree do not fit.
    """
    if len(sections) < 2:
        raise ValueError(f"sections: want at least 2, got {len(sections)}")
    common = make_compatible(sections)
    closed = ends == "closed"
    if parameters is None:
        v = _distances(common, closed=closed)
    else:
        v = frozen_array(parameters, (len(sections) + closed,), "parameters")
    flat = common.rows.reshape(len(sections), -1)
    # Piegl and Tiller, The NURBS Book, 2nd ed. 1997, sec. 10.3
    across = interpolate(flat, degree=degree, parameters=v, ends=ends)
    rows = across.points.reshape(len(across.points), *common.rows.shape[1:]).swapaxes(0, 1)
    return surface_of(
        (common.knots, across.knots),
        rows,
        (common.degree, across.degree),
        rational=common.is_rational,
    )


def _distances(sections: Sections, *, closed: bool) -> FloatArray:
    """Give the v of sections: the mean of what chords of control points say."""
    rows = sections.rows
    if sections.is_rational:
        rows = rows[..., :-1] / rows[..., -1:]
    if closed:
        rows = np.concatenate((rows, rows[:1]))
    chords = np.linalg.norm(np.diff(rows, axis=0), axis=2)
    if not (chords.max(axis=1) > 0.0).all():
        i = int(np.argmin(chords.max(axis=1)))
        raise CurveError(
            f"sections {i} and {(i + 1) % len(sections.rows)} are the same; take one out", "loft"
        )
    # points that stay where they are say nothing: Piegl and Tiller, eq. 10.8
    moving = chords[:, chords.sum(axis=0) > 0.0]
    steps = (moving / moving.sum(axis=0)).mean(axis=1)
    v = np.concatenate(([0.0], np.cumsum(steps)))
    v[-1] = 1.0
    return v
