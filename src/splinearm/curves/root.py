"""All roots of polynomials in Bernstein form, none missed, by subdivision.

An interval is left out only where the coefficients prove, beyond all rounding, that there is no
root. What remains is either one root between certain signs, or so small that rounding hides it.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray

from .basis import IndexArray
from .bernstein import EPS, Bounded

BoolArray = npt.NDArray[np.bool]
"""An array of truths."""

_SMALLEST = 2.0**-44
_STEPS = 60


class Roots(NamedTuple):
    """Roots of polynomials on [0, 1], in order."""

    piece: IndexArray
    """Which polynomial, shape (k,)."""
    low: FloatArray
    """Where the root or what rounding makes of it begins, shape (k,)."""
    high: FloatArray
    """Where it ends, shape (k,)."""
    everywhere: IndexArray
    """Polynomials that are 0 on all of [0, 1], as far as rounding tells, shape (j,)."""

    @property
    def t(self) -> FloatArray:
        """The middle of each, or the end of [0, 1] that it holds, shape (k,)."""
        middle = np.where(self.high >= 1.0, 1.0, 0.5 * (self.low + self.high))
        return np.where(self.low <= 0.0, 0.0, middle)


def find_roots(*functions: Bounded) -> Roots:
    """Give where all functions of a piece are 0 together; each has the same number of pieces."""
    degree = max(f.c.shape[1] for f in functions) - 1
    zero = Bounded(np.zeros((len(functions[0].c), degree + 1)), np.zeros(len(functions[0].c)))
    raised = [f + zero for f in functions]
    # axes: piece, function, coefficient
    c = np.stack([f.c for f in raised], axis=1)
    error = np.stack([f.error for f in raised], axis=1)
    everywhere = (np.abs(c) <= error[:, :, None]).all(axis=(1, 2))
    piece = np.flatnonzero(~everywhere)
    c, error = c[piece], error[piece]
    low, high = np.zeros(len(piece)), np.ones(len(piece))
    found: list[tuple[IndexArray, FloatArray, FloatArray]] = []
    while len(piece):
        bound = error[:, :, None]
        clear = np.stack(((c > bound).all(axis=2), (c < -bound).all(axis=2)))
        alive = ~clear.any(axis=(0, 2))
        hidden = (np.abs(c) <= bound).all(axis=(1, 2)) | (high - low <= _SMALLEST)
        ready = alive & hidden
        found.append((piece[ready], low[ready], high[ready]))
        single = alive & ~hidden
        if len(functions) == 1:
            single &= _has_one_root(c[:, 0], error[:, 0])
            t = _solve(c[single, 0])
            at = low[single] + t * (high[single] - low[single])
            found.append((piece[single], at, at))
            alive &= ~single
        rest = alive & ~hidden
        left, right = _halve(c[rest])
        size = degree * EPS * np.abs(c[rest]).max(axis=2)
        middle = 0.5 * (low[rest] + high[rest])
        c, error = np.concatenate((left, right)), np.tile(error[rest] + size, (2, 1))
        piece, ends = np.tile(piece[rest], 2), (low[rest], high[rest])
        low, high = np.concatenate((ends[0], middle)), np.concatenate((middle, ends[1]))
    parts = [np.concatenate(x) for x in zip(*found, strict=True)] if found else [np.empty(0)] * 3
    return _merged(parts[0].astype(np.intp), parts[1], parts[2], np.flatnonzero(everywhere))


def _has_one_root(c: FloatArray, error: FloatArray) -> BoolArray:
    """Tell where Descartes' rule proves exactly one root."""
    sign = np.where(np.abs(c) > error[:, None], np.sign(c), 0.0)
    sure = sign[:, 0] * sign[:, -1] < 0.0
    # the signs turn once if none is that of the start after one that is that of the end; one
    # uncertain sign between both makes no difference, two might
    same = sign == sign[:, :1]
    other = sign == sign[:, -1:]
    before = np.cumprod(same, axis=1).sum(axis=1)
    behind = np.cumprod(other[:, ::-1], axis=1).sum(axis=1)
    one: BoolArray = sure & (before + behind >= c.shape[1] - 1)
    return one


def _solve(c: FloatArray) -> FloatArray:
    """Give the root of each polynomial between ends of opposite sign: Newton, kept in brackets."""
    low, high = np.zeros(len(c)), np.ones(len(c))
    rising = c[:, -1] > 0.0
    t = np.clip(c[:, 0] / np.where(c[:, 0] == c[:, -1], 1.0, c[:, 0] - c[:, -1]), 0.0, 1.0)
    for _ in range(_STEPS):
        value, slope = _value_and_slope(c, t)
        above = (value > 0.0) == rising
        high, low = np.where(above, t, high), np.where(above, low, t)
        with np.errstate(divide="ignore", invalid="ignore"):
            following = t - value / slope
        middle = 0.5 * (low + high)
        inside = (following >= low) & (following <= high)
        following = np.where(value == 0.0, t, np.where(inside, following, middle))
        moved = np.abs(following - t).max(initial=0.0)
        t = following
        if moved <= EPS:
            break
    return t


def _value_and_slope(c: FloatArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    share, degree = t[:, None], c.shape[1] - 1
    for _ in range(degree - 1):
        c = c[:, :-1] * (1.0 - share) + c[:, 1:] * share
    return c[:, 0] * (1.0 - t) + c[:, -1] * t, degree * (c[:, -1] - c[:, 0])


def _halve(c: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give the coefficients, on the last axis, of both halves of [0, 1]."""
    left, right = np.empty_like(c), np.empty_like(c)
    degree = c.shape[-1] - 1
    for i in range(degree + 1):
        left[..., i], right[..., degree - i] = c[..., 0], c[..., -1]
        c = 0.5 * (c[..., :-1] + c[..., 1:])
    return left, right


def _merged(piece: IndexArray, low: FloatArray, high: FloatArray, everywhere: IndexArray) -> Roots:
    """Put what belongs together into one: intervals that touch, or nearly so beside their width."""
    order = np.lexsort((low, piece))
    piece, low, high = piece[order], low[order], high[order]
    starts: list[int] = []
    ends: list[float] = []
    for i in range(len(piece)):
        if starts and piece[i] == piece[starts[-1]]:
            width = max(ends[-1] - low[starts[-1]], high[i] - low[i])
            if width > 0.0 and low[i] - ends[-1] <= width:
                ends[-1] = max(ends[-1], float(high[i]))
                continue
        starts.append(i)
        ends.append(float(high[i]))
    return Roots(piece[starts], low[starts], np.array(ends), everywhere)
