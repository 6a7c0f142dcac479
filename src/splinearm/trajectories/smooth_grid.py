"""Where the nodes of a smooth time law lie, and about how fast it will be there.

All of it in shares of the way, which goes from 0 to 1.
"""

from typing import Literal, NamedTuple, Protocol

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.basis import IndexArray
from splinearm.errors import CurveError

from .constraint import SpeedCap
from .joint_path import JointPath
from .smooth_placed import Placed

_LOOKS = 256
"""In so many places, even along the way, the limits are looked at at least ..."""

_HALVES = 0.5 ** np.arange(8, 28)
"""... and here, seen from both ends."""

_BY_TIME = 0.6
"""Share of the nodes that lie at even times; the others lie at even places."""

_RATIO = 1.4
"""Near a rest each node is at most so many times as far from it as the one before."""

_NATURAL = 40
"""From this node on nodes at even times lie near enough to each other, seen from a rest."""

_LAUNCH_WAY, _LAUNCH_TIME = 0.5, 0.08
"""A launch takes up at most so much of the way on which the jerk binds, and of the whole time."""

_FIRST = 0.3, 1e-4
"""Shares of the first cell at even times: of it where there is no launch, least of a launch."""

_APART = 1.05
"""A node is left out if it is not so many times as far from a rest as the end of the launch."""

_FOLLOWS = 0.98
"""Above this share of the profile of even jerk it is the jerk that binds."""

_PER_PIECE = 2
"""At least so many cells lie between two places where the path is not smooth."""

FARTHEST = 1e2
"""The way is nowhere passed at more than so many times its mean speed."""


_JUMP = 1e-6
"""A jump of the second derivative above this share of its largest is one."""

_ROUNDING = 1e-11
"""... and above this share of the positions themselves."""


class Shape(Protocol):
    """A way of joints by shares of it."""

    @property
    def breaks(self) -> FloatArray:
        """Ends of the polynomial pieces, shape (k + 1,)."""
        ...

    @property
    def coefficients(self) -> FloatArray:
        """Of powers of the share behind the begin of a piece, shape (k, degree + 1, n)."""
        ...

    @property
    def n(self) -> int:
        """Number of joints."""
        ...

    def pieces_of(self, s: FloatArray) -> IndexArray:
        """Give the piece that each share lies in, shape (m,)."""
        ...

    def slopes(
        self, s: FloatArray, side: Literal["left", "right"] = "right"
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give the first three derivatives of q, each of shape (m, n)."""
        ...


class Way(NamedTuple):
    """What is to be timed, from share 0 to share 1 of it, and within what limits."""

    path: Shape
    """The way of the joints."""
    limits: FloatArray
    """Highest velocity, acceleration and jerk of the joints, shape (3, n), or (3, n + 1) where the
    last column says the same of the share itself (infinity: no limit)."""
    cap: SpeedCap | None
    """How fast the tool may be."""
    placed: Placed | None = None
    """Torques and what else the tool may do."""

    def slopes(self, share: FloatArray, *, from_end: bool = False) -> tuple[FloatArray, ...]:
        """Give the first three derivatives of q by the share of the way, each of shape (k, n).

        Args:
            share: Where, shape (k,).
            from_end: Whether places between two pieces belong to the one before.
        """
        first, second, third = self.path.slopes(share, "left" if from_end else "right")
        if self.limits.shape[1] > self.path.n:
            itself = np.ones((len(share), 1))
            first = np.hstack((first, itself))
            second, third = np.hstack((second, 0.0 * itself)), np.hstack((third, 0.0 * itself))
        return first, second, third

    def speed_cap(self, share: FloatArray) -> FloatArray:
        """Give the highest square of the speed, by the share of the way, that the tool allows."""
        if self.cap is None:
            return np.full(share.shape, np.inf)
        with np.errstate(divide="ignore"):
            cap: FloatArray = (self.cap.at(share) / self.cap.rate(share)) ** 2
        return cap

    def corners(self) -> FloatArray:
        """Give the shares where the path, or how fast the tool may be, changes at once."""
        fixed = self.path.breaks
        if self.cap is not None:
            fixed = np.union1d(fixed, self.cap.edges)
        shares = fixed[(fixed > 1e-12) & (fixed < 1.0 - 1e-12)]
        apart: FloatArray = shares[np.diff(shares, prepend=0.0) > 1e-12]
        return apart


class Estimate(NamedTuple):
    """About how fast the way can be passed."""

    share: FloatArray
    """Places, from 0 to 1, shape (k,)."""
    x: FloatArray
    """Square of the speed there, by the share of the way, 1/s2, shape (k,)."""
    t: FloatArray
    """When they are passed, s, shape (k,); 0 everywhere if nothing moves on the way."""
    launches: tuple[float, float]
    """How far from a rest at the two ends jerk is what binds."""


def check_bend(path: JointPath, start: float, end: float) -> None:
    """Refuse a way on which the joints' acceleration would have to jump.

    Raises:
        CurveError: If the second derivative jumps between start and end.
    """
    breaks, coefficients = path.breaks, path.coefficients
    j = np.arange(coefficients.shape[1])
    if len(breaks) == 2:
        return
    h = np.diff(breaks)[:-1, None, None]
    powers = np.where(j < 2, 0.0, j * (j - 1.0))[:, None] * h ** np.maximum(j - 2, 0)[:, None]
    before = (coefficients[:-1] * powers).sum(axis=1)
    after = 2.0 * coefficients[1:, 2] if j.size > 2 else np.zeros_like(before)
    largest = np.maximum(np.abs(before), np.abs(after)).max(axis=0)
    shortest = np.minimum(h[:, 0], np.diff(breaks)[1:, None])
    rounding = _ROUNDING * np.abs(coefficients[:, 0]).max() / shortest**2
    inside = (breaks[1:-1] > start) & (breaks[1:-1] < end)
    jumps = (np.abs(after - before) > _JUMP * largest + rounding).any(axis=1) & inside
    if jumps.any():
        place = breaks[1 + int(np.argmax(jumps))]
        raise CurveError(
            "the second derivative of the joints' way jumps, which no jerk can follow; smooth the "
            "way or stop there",
            f"s = {place:.6g}",
        )


def estimate(way: Way, speeds: tuple[float, float]) -> Estimate:
    """Give a guess of the profile: within half the acceleration, with jerk felt at rests only.

    Args:
        way: What is to be timed.
        speeds: ds/dt, by the share of the way, at its two ends.
    """
    even = np.linspace(0.0, 1.0, _LOOKS + 1)
    share = np.unique(np.concatenate((even, _HALVES, 1.0 - _HALVES, way.corners())))
    velocity, acceleration, jerk = way.limits
    first, second, third = (np.abs(slope) for slope in way.slopes(share))
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        x = np.fmin((velocity / first).min(axis=1) ** 2, 0.5 * (acceleration / second).min(axis=1))
        x = np.fmin(x, (0.5 * jerk / third).min(axis=1) ** (2.0 / 3.0))
        x = np.fmin(x, way.speed_cap(share))
        push = 0.5 * (acceleration / first).min(axis=1)
        if way.placed is not None:
            most, hardest = _placed_most(way.placed, share)
            x, push = np.fmin(x, most), np.fmin(push, hardest)
        curves = []
        for speed, far in zip(speeds, (share, 1.0 - share), strict=True):
            y = launch_jerk(first, second, third, far, jerk) ** (2.0 / 3.0)
            curve = np.where(far > 0.0, y * (6.0 * far) ** (4.0 / 3.0) / 4.0, 0.0)
            curves.append(curve)
            x = np.fmin(x, curve) if speed == 0.0 else np.where(far == 0.0, speed**2, x)
    # as hard as joints may accelerate, from every place to every other
    highest = float(x[np.isfinite(x)].max(initial=0.0))
    if highest == 0.0:
        return Estimate(share, x, np.zeros_like(share), (1.0, 1.0))
    push = np.minimum(push, 1e12 * highest)
    gain = (push[1:] + push[:-1]) * np.diff(share)
    x = _reached(_reached(x, gain)[::-1], gain[::-1])[::-1]
    x = np.minimum(x, (FARTHEST / _times(share, x)[-1]) ** 2)
    left = share[int(np.argmax(x < _FOLLOWS * curves[0]))]
    right = 1.0 - share[len(x) - 1 - int(np.argmax((x < _FOLLOWS * curves[1])[::-1]))]
    return Estimate(share, x, _times(share, x), (float(left), float(right)))


def _placed_most(placed: Placed, share: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give x and d2s/dt2 that take half of what torques and the tool may at places, (k,)."""
    rows = placed.rows(np.append(share, 1.0), np.zeros(1))
    room = 0.5 * np.maximum(rows.room - rows.drag, 1e-6)
    ahead, bend, across = np.moveaxis(rows.cones, -1, 0)
    x = np.fmin(
        (room / np.maximum(rows.bend, 0.0)).min(axis=2, initial=np.inf),
        ((0.5 * room / np.maximum(rows.root, 0.0)) ** 2).min(axis=2, initial=np.inf),
    )
    x = np.fmin(x, (0.5 / np.hypot(bend, across)).min(axis=2, initial=np.inf))
    x = np.fmin(x, 1.0 / rows.square)
    hardest = np.fmin(
        (room / np.abs(rows.push)).min(axis=2, initial=np.inf),
        (0.5 / ahead).min(axis=2, initial=np.inf),
    )
    return x[:, 0], hardest[:, 0]


def _reached(x: FloatArray, gain: FloatArray) -> FloatArray:
    """Give the highest x that can be reached from all places before."""
    reached = x.tolist()
    for i, more in enumerate(gain.tolist()):
        reached[i + 1] = min(reached[i + 1], reached[i] + more)
    return np.array(reached)


def _times(share: FloatArray, x: FloatArray) -> FloatArray:
    """Give when places are passed if x is linear between them."""
    speed = np.sqrt(x)
    return np.concatenate(([0.0], np.cumsum(2.0 * np.diff(share) / (speed[1:] + speed[:-1]))))


def launch_jerk(
    first: FloatArray, second: FloatArray, third: FloatArray, way: FloatArray, jerk: FloatArray
) -> FloatArray:
    """Give the highest d3s/dt3 with which joints may start from rest and come that far.

    Args:
        first: Derivatives of q by s along the way, shape (k, n).
        second: The second ones.
        third: The third ones.
        way: How far they lie from the rest, shape (k,).
        jerk: Highest jerk of the joints, shape (n,).
    """
    # with s = j t^3 / 6: q''' s'^3 + 3 q'' s' s'' + q' s''' = j (9/2 q''' s^2 + 9 q'' s + q')
    way = way[:, None]
    felt = np.abs(4.5 * third * way * way + 9.0 * second * way + first)
    highest: FloatArray = (jerk / felt).min(axis=1)
    return highest


def nodes(
    way: Way, guess: Estimate, cells: int, firsts: tuple[float | None, float | None]
) -> FloatArray:
    """Give nodes from 0 to 1, the closer the longer the way takes, shape (m + 1,).

    Next to an end they lie in geometric steps. At a rest the outermost cell is as long as its jerk
    may be expected to be even.

    Args:
        way: What is to be timed.
        guess: About how fast.
        cells: About how many cells there shall be.
        firsts: The longest that the outermost cells may be at ends that are no rests; None: a rest.
    """
    fixed = way.corners()
    count = cells * (_BY_TIME * guess.t / guess.t[-1] + (1.0 - _BY_TIME) * guess.share)
    at = np.interp(np.concatenate(([0.0], fixed, [1.0])), guess.share, count)
    parts = np.maximum(np.ceil(np.diff(at) - 1e-9).astype(np.intp), _PER_PIECE)
    cell = np.repeat(np.arange(len(parts)), parts)
    within = np.arange(len(cell)) - np.repeat(np.cumsum(parts) - parts, parts)
    found = np.interp(at[cell] + within / parts[cell] * np.diff(at)[cell], count, guess.share)
    found[np.cumsum(parts)[:-1]] = fixed
    placed: FloatArray = np.append(found, 1.0)
    times = np.array([_LAUNCH_TIME, 1.0 - _LAUNCH_TIME]) * guess.t[-1]
    early, late = np.interp(times, guess.t, guess.share)
    smooth = np.append(fixed, 1.0)[0], 1.0 - np.append(0.0, fixed)[-1]
    for k, far in enumerate((early, 1.0 - late)):
        longest = min(float(far), 0.5 * float(smooth[k]), _LAUNCH_WAY * guess.launches[k])
        placed = 1.0 - _graded(placed, firsts[k], longest)[::-1]
    return placed


def _graded(found: FloatArray, first: float | None, launch: float) -> FloatArray:
    """Give nodes from 0 to 1 with more of them near 0, or with a launch there."""
    if first is None:
        natural = float(found[min(_NATURAL, len(found) - 1)])
        first = max(min(launch, natural), _FIRST[1] * float(found[1]))
    else:
        first = min(_FIRST[0] * float(found[1]), first)
    steps = [0.0, first]
    for i in range(1, len(found)):
        last, node = steps[-1], float(found[i])
        if node < _APART * last:
            continue
        more = int(np.ceil(np.log(node / last) / np.log(_RATIO) - 1e-9))
        if more <= 1:
            return np.concatenate((steps, found[i:]))
        steps += [last * (node / last) ** (k / more) for k in range(1, more)] + [node]
    return np.array(steps)
