"""The check of offsets of splines by code that did not make them: bounds, not samples."""

from collections.abc import Sequence

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import GougeError, OffsetError

from .piece import Piece
from .spline_source import Source, pieces_as_segments

_CUBIC = 3
"""Degree of the curves along which it is looked."""


def check_band(source: Source, pieces: Sequence[Piece], distance: float, tolerance: float) -> None:
    """Raise unless all of an offset is proven to lie between a distance and that and a tolerance.

    Args:
        source: What was offset.
        pieces: The result.
        distance: How near it may be to any of the source, m.
        tolerance: How much farther from the nearest of it, m.

    Raises:
        GougeError: If it is nearer than the distance.
        OffsetError: If it is not proven not to be, or not to be farther than the tolerance allows.
    """
    from .spline_check_kernel import first_farther

    check_clear(source, pieces, distance, "this is a fault of the offset: report it")
    far = (distance + tolerance) / source.unit
    for R in pieces_as_segments(pieces, source.origin, source.unit):
        i, t = first_farther(R, source.segments, far, _degrees(R, source.segments))
        if i >= 0:
            raise OffsetError(distance, "it is too far from the curve", _place(source, R, i, t))


def check_clear(source: Source, pieces: Sequence[Piece], distance: float, remedy: str = "") -> None:
    """Raise unless ways are proven to keep a distance from all of a source.

    Args:
        source: From what they keep away.
        pieces: The ways.
        distance: How near they may be to any of the source, m.
        remedy: What would help if they are nearer.

    Raises:
        GougeError: If one is nearer.
        OffsetError: If it is not proven that none is.
    """
    from .spline_check_kernel import first_nearer

    S = source.segments
    for R in pieces_as_segments(pieces, source.origin, source.unit):
        i, _, t, _, _ = first_nearer(R, S, distance / source.unit, _degrees(R, S))
        if i < 0:
            continue
        places = [_place(source, R, i, t) for t in (t, *np.linspace(-1.0, 1.0, 65).tolist())]
        away = [_distance(source, x, y) for x, y in places]
        nearest = int(np.argmin(away))
        depth = distance - away[nearest]
        if depth > 0.0:
            raise GougeError(places[nearest], depth, remedy)
        raise OffsetError(distance, "it cannot be proven not to gouge", places[0])


def check_complete(
    source: Source, pieces: Sequence[Piece], distance: float, tolerance: float
) -> None:
    """Raise if beside the source there is a place of the offset that the result does not have.

    Raises:
        OffsetError: If one of the places looked at is missing.
    """
    from .spline_check_kernel import first_missing

    groups = pieces_as_segments(pieces, source.origin, source.unit)
    n = max((R.shape[1] for R in groups), default=1)
    R = (
        np.concatenate([np.pad(R, ((0, 0), (0, n - R.shape[1]), (0, 0))) for R in groups])
        if (groups)
        else np.zeros((0, 1, 3))
    )
    d, more = distance / source.unit, tolerance / source.unit
    k, x, y = first_missing(R, source.segments, d, more)
    if k >= 0:
        x, y = source.placed(np.array([x, y])).tolist()
        raise OffsetError(distance, "a part of it is missing", (x, y))


def _degrees(R: FloatArray, S: FloatArray) -> tuple[int, int]:
    """Give the degrees of G along a cubic, and along a number."""
    m, n = R.shape[1] - 1, S.shape[1] - 1
    M = m if R[:, 1:, 2].any() else 0
    N = n if S[:, 1:, 2].any() else 0
    along = max(m + N * _CUBIC, M + n * _CUBIC)
    return 2 * along, 2 * max(1, m, M)


def _place(source: Source, R: FloatArray, i: int, t: float) -> tuple[float, float]:
    from .spline_jet_kernel import jet

    x, y = source.placed(np.array(jet(R, i, t)[:2])).tolist()
    return x, y


def _distance(source: Source, x: float, y: float) -> float:
    from .spline_jet_kernel import nearest_place

    px, py = ((np.array([x, y]) - source.origin) / source.unit).tolist()
    S = source.segments
    return source.unit * min(
        nearest_place(S, float(k), k + 1.0, px, py, 32)[1] for k in range(len(S))
    )
