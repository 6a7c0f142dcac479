"""Curves by their arc length: exactly, or as a B-spline within a tolerance."""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import CurveError

from .arc_length import ArcLength
from .bspline import BSpline
from .feature import cusps
from .hermite import Jet, quintic_pieces, quintic_spline

_STILL = 1e-14
_SMOOTH = 1e-9
"""Directions and curvatures that differ by less where pieces meet are the same."""

_MOST_PIECES = 50_000
_ROUNDING = 1e-14
_MOST_ROUNDS = 30
_INSIDE = (1.0 - np.cos(np.pi * (np.arange(9) + 0.5) / 9)) / 2.0
"""Shares of a piece at which its error is looked at."""


@dataclass(frozen=True, slots=True, eq=False)
class NaturalCurve:
    """A curve whose parameter is its arc length s, from 0 to ``length``: its speed is 1."""

    curve: BSpline
    """The curve in its own parameter, of degree 1 or more."""
    closed: bool = False
    """Whether it ends where it starts and s may be anything, turn after turn."""
    _arc: ArcLength = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_arc", ArcLength(self.curve, self.closed))

    @property
    def arc_length(self) -> ArcLength:
        """The map between s and the curve's own parameter."""
        return self._arc

    @property
    def length(self) -> float:
        """The length of the curve."""
        return self._arc.length

    @property
    def domain(self) -> tuple[float, float]:
        """First and last s."""
        return 0.0, self._arc.length

    @property
    def dim(self) -> int:
        """Number of coordinates."""
        return self.curve.dim

    @property
    def breaks(self) -> FloatArray:
        """Lengths at which the pieces of the curve begin and end."""
        return self._arc.s(self.curve.breaks)

    def at(self, s: ArrayInput, derivative: int = 0) -> FloatArray:
        """Give points, or derivatives by s up to the third, shape (..., dim).

        The first is the unit tangent, the second points to the centre of curvature and is as long
        as the curvature.

        Args:
            s: Lengths from 0 to the whole, of a closed curve any, shape (...).
            derivative: Which derivative, 0 to 3.

        Raises:
            CurveError: If a length lies outside or is not a number, or a derivative is wanted
                where the curve stands still.
            ValueError: If the derivative is not one of 0 to 3.
        """
        return self.jet(s, derivative)[..., derivative, :]

    def jet(self, s: ArrayInput, order: int) -> FloatArray:
        """Give points and derivatives by s at once, shape (..., order + 1, dim), order up to 3.

        Raises:
            CurveError: As ``at``.
            ValueError: If the order is not one of 0 to 3.
        """
        if order not in (0, 1, 2, 3):
            raise ValueError(f"order: want 0 to 3, got {order}")
        lengths = np.asarray(s, dtype=np.float64)
        if self.closed:
            lengths = lengths - np.floor(lengths / self.length) * self.length
        u = self._arc.u(np.minimum(lengths, self.length) if self.closed else lengths)
        # the end of a turn of a closed curve is again its start
        u = np.minimum(u, self.curve.domain[1])
        return _by_length(self.curve, self.curve.jet(u, order), u)

    def to_bspline(self, tolerance: float) -> BSpline:
        """Give a quintic B-spline that is nowhere farther than a tolerance from the curve at s.

        Its parameter is the arc length within the tolerance. It is C2 where direction and
        curvature of the curve do not jump.

        Args:
            tolerance: How far points at the same s may be apart, m.

        Raises:
            CurveError: If the curve stands still somewhere, or the tolerance is below what
                rounding allows.
            ValueError: If the tolerance is not above 0.
        """
        if not tolerance > 0.0:
            raise ValueError(f"tolerance: want it above 0, got {tolerance}")
        rounding = _ROUNDING * float(np.abs(self.curve.points).max())
        if tolerance < rounding:
            raise CurveError(
                f"cannot be met within {tolerance}: rounding alone is {rounding}", "arc length"
            )
        halts = cusps(self.curve)
        if len(halts.u) or len(halts.stretches):
            where = float([*halts.u, *halts.stretches.ravel()][0])
            raise CurveError(f"it stands still at u = {where}: no direction there", "arc length")
        runs = [self._nodes(part, tolerance) for part in _smooth_parts(self.curve)]
        joined = [runs[0]]
        for run in runs[1:]:
            if _fit_together(joined[-1], run):
                s, jet = joined[-1]
                joined[-1] = (
                    np.append(s, run[0][1:]),
                    _jet(*(np.vstack((a, b[1:])) for a, b in zip(jet, run[1], strict=True))),
                )
            else:
                joined.append(run)
        return _chained([quintic_spline(*run) for run in joined])

    def _nodes(self, part: BSpline, tolerance: float) -> tuple[FloatArray, Jet]:
        """Give nodes between which quintics are near enough, and the curve's jets there."""
        start, end = part.domain
        s = self._arc.s(part.breaks)
        s = s[np.append(True, np.diff(s) > 0.0)]
        for _ in range(_MOST_ROUNDS):
            jet = self._part_jet(part, s, 2)
            h = np.diff(s)
            coefficients = quintic_pieces(
                h, *(_jet(*(x[side] for x in jet)) for side in (slice(-1), slice(1, None)))
            )
            places = s[:-1, None] + h[:, None] * _INSIDE
            wanted = self._part_jet(part, places.ravel(), 0)[0].reshape(*places.shape, -1)
            x = (h[:, None] * _INSIDE)[..., None]
            have = np.zeros_like(wanted)
            for k in range(5, -1, -1):
                have = have * x + coefficients[:, None, k]
            off = np.linalg.norm(have - wanted, axis=-1).max(axis=1)
            # the error falls with the sixth power of the step
            counts = np.ceil((off / (0.7 * tolerance)) ** (1.0 / 6.0)).astype(np.intp)
            if counts.max() <= 1:
                return s, jet
            if counts.sum() > _MOST_PIECES:
                break
            steps = [
                np.linspace(a, b, max(1, count) + 1)[:-1]
                for a, b, count in zip(s[:-1], s[1:], counts, strict=True)
            ]
            s = np.concatenate((*steps, s[-1:]))
        raise CurveError(
            f"cannot be met within {tolerance} from u = {start} to {end}: it nearly stands still "
            "there, or rounding is in the way",
            "arc length",
        )

    def _part_jet(self, part: BSpline, s: FloatArray, order: int) -> Jet:
        u = np.clip(self._arc.u(s), *part.domain)
        jet = np.moveaxis(_by_length(part, part.jet(u, order), u), -2, 0)
        return _jet(*jet) if order == 2 else (jet[0], jet[0], jet[0])


def _jet(value: FloatArray, slope: FloatArray, bend: FloatArray) -> Jet:
    return value, slope, bend


def _by_length(curve: BSpline, jet: FloatArray, u: FloatArray) -> FloatArray:
    """Give derivatives by s from those by u, shape (..., order + 1, dim)."""
    order = jet.shape[-2] - 1
    if order == 0:
        return jet
    by_u = np.moveaxis(jet, -2, 0)
    speed = np.linalg.norm(by_u[1], axis=-1)
    start, end = curve.domain
    still = speed <= _STILL * np.abs(curve.points - curve.points[0]).max() / (end - start)
    if still.any():
        where = float(np.ravel(u)[int(np.argmax(np.ravel(still)))])
        raise CurveError(f"it stands still at u = {where}: no direction there", "arc length")
    # the chain rule, with du/ds = 1 / |C'|
    out = by_u.copy()
    first = 1.0 / speed
    out[1] *= first[..., None]
    if order < 2:
        return np.moveaxis(out, 0, -2)
    along = np.sum(by_u[1] * by_u[2], axis=-1)
    second = -along * first**4
    out[2] = by_u[2] * first[..., None] ** 2 + by_u[1] * second[..., None]
    if order > 2:
        more = np.sum(by_u[2] * by_u[2] + by_u[1] * by_u[3], axis=-1)
        third = 4.0 * along**2 * first**7 - more * first**5
        out[3] = by_u[3] * first[..., None] ** 3 + by_u[1] * third[..., None]
        out[3] += 3.0 * by_u[2] * (first * second)[..., None]
    return np.moveaxis(out, 0, -2)


def _smooth_parts(curve: BSpline) -> list[BSpline]:
    """Give the parts of a curve within which its second derivative is continuous."""
    start, end = curve.domain
    inner, counts = np.unique(curve.knots, return_counts=True)
    rough = inner[(counts > curve.degree - 2) & (inner > start) & (inner < end)]
    ends = np.concatenate(([start], rough, [end]))
    if len(ends) == 2:
        return [curve]
    return [curve.part(float(a), float(b)) for a, b in pairwise(ends)]


def _fit_together(first: tuple[FloatArray, Jet], second: tuple[FloatArray, Jet]) -> bool:
    """Tell whether two runs meet in direction and curvature."""
    turn, bend = (
        float(np.abs(a[-1] - b[0]).max()) for a, b in zip(first[1][1:], second[1][1:], strict=True)
    )
    size = float(max(np.abs(run[1][2]).max() for run in (first, second)))
    return turn <= _SMOOTH and bend <= _SMOOTH * size


def _chained(runs: list[BSpline]) -> BSpline:
    """Give one curve of clamped quintics that follow one another."""
    if len(runs) == 1:
        return runs[0]
    knots = [runs[0].knots[:-1], *(run.knots[6:-1] for run in runs[1:]), runs[-1].knots[-1:]]
    points = [runs[0].points, *(run.points[1:] for run in runs[1:])]
    return BSpline(np.concatenate(knots), np.vstack(points), 5)
