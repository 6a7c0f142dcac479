"""Surfaces between four boundary curves."""

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import CurveError

from .bspline import BSpline
from .compatible import Sections, make_compatible
from .surface import BSplineSurface
from .surface_of_curves import surface_of

_MEET = 1e-9
"""Corners may be this share of the size of the curves apart."""


def coons(bottom: BSpline, top: BSpline, left: BSpline, right: BSpline) -> BSplineSurface:
    """Give the bilinearly blended patch between four boundary curves, exactly through each.

    Args:
        bottom: The curve at the first v, by u.
        top: The curve at the last v, by u.
        left: The curve at the first u, by v, from the start of the bottom to that of the top.
        right: The curve at the last u, by v, from the end of the bottom to that of the top.

    Raises:
        CurveError: If ends of curves do not meet in four corners, or, of rational curves, not with
            weights that can be made the same there.
        ValueError: If numbers of coordinates differ.
    """
    # Coons, Surfaces for computer-aided design of space forms, MIT 1967; on control points: Piegl
    # and Tiller, sec. 10.6
    curves = (bottom, top, left, right)
    if any(curve.degree == 0 for curve in curves):
        raise ValueError(f"degree: want at least 1 of each, got {[c.degree for c in curves]}")
    if len({curve.dim for curve in curves}) > 1:
        raise ValueError(f"dim: want as many coordinates of each, got {[c.dim for c in curves]}")
    _check_corners(*curves)
    by_u, by_v = make_compatible((bottom, top)), make_compatible((left, right))
    rational = by_u.is_rational or by_v.is_rational
    rows_u, rows_v = by_u.rows, by_v.rows
    if rational:
        rows_u, rows_v = _of_one_weight(_homogeneous(by_u), _homogeneous(by_v))
    # a share that grows evenly with the parameter has the means of knots as control points
    shares_u, shares_v = _even_shares(by_u), _even_shares(by_v)
    corners = rows_u[:, [0, -1]]
    rows = np.einsum("kn,kmc->mnc", shares_v, rows_u) + np.einsum("km,knc->mnc", shares_u, rows_v)
    rows -= np.einsum("km,ln,lkc->mnc", shares_u, shares_v, corners)
    # where curves meet but for rounding only, the patch keeps to the bottom and the top
    rows[:, 0], rows[:, -1] = rows_u
    return surface_of((by_u.knots, by_v.knots), rows, (by_u.degree, by_v.degree), rational=rational)


def _check_corners(bottom: BSpline, top: BSpline, left: BSpline, right: BSpline) -> None:
    """Refuse curves that do not meet in four corners."""
    size = max(float(np.ptp(curve.points, axis=0).max()) for curve in (bottom, top, left, right))
    sides = {"left": left, "right": right}
    for name, curve in (("bottom", bottom), ("top", top)):
        for end, (side, other) in enumerate(sides.items()):
            corner = curve.at(curve.domain[end])
            meeting = other.at(other.domain[1 if name == "top" else 0])
            gap = float(np.linalg.norm(corner - meeting))
            if not gap <= _MEET * size:
                raise CurveError(
                    f"the {name} and the {side} curve are {gap:.3g} apart where they should meet: "
                    f"at {corner.tolist()} and {meeting.tolist()}",
                    "Coons patch",
                )


def _homogeneous(sections: Sections) -> FloatArray:
    if sections.is_rational:
        return sections.rows
    return np.concatenate((sections.rows, np.ones((*sections.rows.shape[:2], 1))), axis=2)


def _of_one_weight(rows_u: FloatArray, rows_v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give the curves with weights, each times a number, that are the same at the corners."""
    ends_u, ends_v = rows_u[:, [0, -1], -1], rows_v[:, [0, -1], -1]
    left, right = ends_u[0] / ends_v[:, 0]
    top = left * ends_v[0, 1] / ends_u[1, 0]
    last, wanted = top * ends_u[1, 1], right * ends_v[1, 1]
    if not abs(last - wanted) <= _MEET * wanted:
        raise CurveError(
            f"no factors make the weights of both curves the same at each corner: at the last "
            f"they are {last:.6g} and {wanted:.6g}",
            "Coons patch",
        )
    return rows_u * np.array([1.0, top])[:, None, None], rows_v * np.array([left, right])[
        :, None, None
    ]


def _even_shares(sections: Sections) -> FloatArray:
    """Give control points of 1 - x and x, where x goes evenly from 0 to 1, shape (2, m)."""
    windows = np.lib.stride_tricks.sliding_window_view(sections.knots[1:-1], sections.degree)
    start, end = sections.knots[0], sections.knots[-1]
    x = (windows.mean(axis=1) - start) / (end - start)
    return np.stack((1.0 - x, x))
