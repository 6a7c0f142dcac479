"""What is wrong in a recording: samples at which no arm could have been, and encoder noise."""

from typing import NamedTuple, TypeAlias

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.basis import IndexArray
from splinearm.curves.bspline import BSpline
from splinearm.curves.smoothing import smooth

Flags: TypeAlias = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
"""Whether something is so, sample by sample."""

_AROUND = 5
"""So many samples before and behind say where one should be."""

_WIDELY = 25
"""So many before and behind say how far off they usually are."""

_REPEATS = 8
"""So often is looked for more of them."""

_LONGEST = 2
"""Of more samples in a row than that none is wrong: the arm was there."""

_TIMES = 6.0
"""Farther off than so many times the usual scatter is wrong ..."""

_LEAST = 0.25
"""... if it is also farther off than this share of the joints' tolerance."""

_ROUNDS = 3
"""So often the curve is made anew without what was found wrong."""

_GAUSS = 1.4826
"""Standard deviation of Gauss' distribution, of its median of absolute values."""


class Clean(NamedTuple):
    """A recording without its noise."""

    curve: BSpline
    """The joints by time: as near to the samples as their noise allows, and as little bent."""
    wrong: IndexArray
    """The samples that are wrong and were left out, shape (w,)."""


def clean(t: FloatArray, q: FloatArray, tolerance: FloatArray) -> Clean:
    """Give a recording without noise and without samples that are wrong.

    How much is noise is found by generalised cross validation. A sample is wrong if it is far off
    where its neighbours say, and no more than two in a row are.

    Args:
        t: When, rising, shape (k,), s.
        q: Joint positions, shape (k, n), rad or m; at least eight.
        tolerance: How near a motion shall be to them, shape (n,), rad or m.
    """
    wrong = _alone(_jumps(t, q, _LEAST * tolerance))
    for _ in range(_ROUNDS):
        kept = np.flatnonzero(~wrong)
        curve = smooth(q[kept], parameters=t[kept])
        gap = curve.at(t) - q
        scatter = _GAUSS * np.median(np.abs(gap[kept]), axis=0)
        more = _alone(np.abs(gap) > np.maximum(_TIMES * scatter, _LEAST * tolerance)) & ~wrong
        if not more.any():
            break
        wrong |= more
    kept = np.flatnonzero(~wrong)
    curve = smooth(q[kept], parameters=t[kept])
    return Clean(curve, np.flatnonzero(wrong))


def _jumps(t: FloatArray, q: FloatArray, least: FloatArray) -> Flags:
    """Tell which samples of which joints are far from a parabola through those around them.

    The worst of a neighbourhood first: it is left out before its neighbours are judged.
    """
    around, widely = (_around(len(t), reach) for reach in (_AROUND, _WIDELY))
    x = (t[around] - t[:, None]) / (t[around[:, -1]] - t[around[:, 0]])[:, None]
    rows = x[:, None, :, None] ** np.arange(3)
    values = np.moveaxis(q[around], 2, 1)[..., None]
    others = (around != np.arange(len(t))[:, None])[:, None, :]
    far: Flags = np.zeros(q.shape, dtype=np.bool_)
    for _ in range(_REPEATS):
        weights = others & ~np.moveaxis(far[around], 2, 1)
        weighted = np.swapaxes(rows * weights[..., None], 2, 3)
        shape = np.linalg.solve(weighted @ rows + 1e-12 * np.eye(3), weighted @ values)
        off = np.abs(q - shape[:, :, 0, 0])
        near = np.moveaxis(off[around], 2, 1)
        usual = _GAUSS * np.median(off[widely], axis=1)
        worst = off >= np.where(weights, near, 0.0).max(axis=2)
        more = worst & (off > np.maximum(_TIMES * usual, least)) & ~far
        if not more.any():
            break
        far |= more
    return far


def _around(count: int, reach: int) -> IndexArray:
    """Give for each of so many samples those around it, at the ends those nearest to them."""
    width = min(2 * reach + 1, count)
    first = np.clip(np.arange(count) - width // 2, 0, count - width)
    window: IndexArray = first[:, None] + np.arange(width)
    return window


def _alone(far: Flags) -> Flags:
    """Give the samples at which a joint is far off, and no more than a few in a row of it.

    The first and the last are never among them: nothing beyond says where they should be.
    """
    alone = np.zeros(len(far), dtype=np.bool_)
    for joint in far.T:
        edges = np.flatnonzero(np.diff(np.concatenate(([0], joint.astype(np.int8), [0]))))
        for begin, end in edges.reshape(-1, 2):
            if end - begin <= _LONGEST:
                alone[begin:end] = True
    alone[[0, -1]] = False
    return alone
