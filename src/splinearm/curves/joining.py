"""Curves joined end to end."""

import numpy as np

from splinearm.errors import CurveError

from . import deviation, knot
from .bspline import BSpline

_ROUNDING = 1e-14


def join(first: BSpline, second: BSpline, continuity: int = 0, tolerance: float = 1e-9) -> BSpline:
    """Give one clamped curve of two, the second one moved to begin at the first one's end.

    Args:
        first: The curve whose domain is kept.
        second: The curve that goes on, of as many coordinates.
        continuity: How many derivatives by the parameter do not jump where they meet. The knot
            there is left as many times fewer, if the curve then moves by no more than the
            tolerance.
        tolerance: By how much the ends may be apart, of the larger control points; derivatives,
            of the larger one of both.

    Raises:
        CurveError: If the curves do not meet like this.
        ValueError: If coordinates differ, or continuity or tolerance are negative.
    """
    if first.dim != second.dim:
        raise ValueError(f"dim: want as many coordinates, got {first.dim} and {second.dim}")
    if continuity < 0 or not tolerance >= 0.0:
        raise ValueError(f"want no less than 0, got {continuity=} and {tolerance=}")
    _check_meeting(first, second, continuity, tolerance)
    degree = max(first.degree, second.degree, 1)
    rational = first.is_rational or second.is_rational
    before = first.elevated(degree - first.degree).clamped()
    behind = second.elevated(degree - second.degree).clamped()
    rows, more = (c.homogeneous if rational else c.points for c in (before, behind))
    if rational:
        more = more * (rows[-1, -1] / more[0, -1])
    meeting = before.domain[1]
    shifted = behind.knots[degree + 1 :] - behind.domain[0] + meeting
    knots = np.concatenate((before.knots[:-1], shifted))
    rows = np.concatenate((rows[:-1], 0.5 * (rows[-1:] + more[:1]), more[1:]))
    size = float(np.abs(np.vstack((first.points, second.points))).max())
    for _ in range(min(continuity, degree)):
        fewer, points, change = knot.remove(knots, rows, degree, meeting)
        error = deviation.bound(rows, rows + change, rational=rational)
        if error > tolerance * size:
            break
        knots, rows = fewer, points
    if rational:
        return BSpline.from_homogeneous(knots, rows, degree)
    return BSpline(knots, rows, degree)


def _check_meeting(first: BSpline, second: BSpline, continuity: int, tolerance: float) -> None:
    """Refuse curves that are apart or whose derivatives jump where they meet."""
    end = first.jet(first.domain[1], continuity)
    start = second.jet(second.domain[0], continuity)
    size = float(np.abs(np.vstack((first.points, second.points))).max())
    width = min(np.diff(first.breaks)[-1], np.diff(second.breaks)[0])
    for order in range(continuity + 1):
        jump = float(np.linalg.norm(start[order] - end[order]))
        larger = max(np.linalg.norm(start[order]), np.linalg.norm(end[order]))
        # a derivative that vanishes on both sides is known to rounding of the points only
        rounding = _ROUNDING * size * (max(first.degree, second.degree) / width) ** order
        if jump > (tolerance * size if order == 0 else tolerance * larger + rounding):
            what = "they are apart" if order == 0 else f"derivative {order} jumps"
            raise CurveError(f"{what} by {jump:.3g} where they meet", "joined curves")
