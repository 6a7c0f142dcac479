"""Ways of the joints without time."""

from dataclasses import dataclass, field

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves import basis
from splinearm.curves.basis import IndexArray
from splinearm.curves.bspline import BSpline
from splinearm.curves.sampler import Sampler
from splinearm.errors import CurveError

_ROUNDING = 1e-13
"""Moves below this share of the joints' positions are rounding."""

_SMOOTH = 1e-6
"""A jump of the direction above this share of it is a corner."""


@dataclass(frozen=True, slots=True, eq=False)
class JointPath:
    """A smooth way of the joints by a parameter s, quick to sample.

    Its direction never jumps: joints could not follow around a corner without stopping.
    """

    curve: BSpline
    """Joint positions, rad or m."""
    breaks: FloatArray = field(init=False)
    """Ends of the polynomial pieces, shape (k + 1,)."""
    coefficients: FloatArray = field(init=False, repr=False)
    """Of powers of s - breaks[i] on piece i, shape (k, degree + 1, n)."""
    _sampler: Sampler = field(init=False, repr=False)

    def __post_init__(self) -> None:
        breaks, coefficients = basis.taylor_pieces(
            self.curve.knots, self.curve.points, self.curve.degree
        )
        _check_smooth(breaks, coefficients)
        object.__setattr__(self, "breaks", breaks)
        object.__setattr__(self, "coefficients", coefficients)
        object.__setattr__(self, "_sampler", self.curve.sampler())

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.curve.dim

    @property
    def domain(self) -> tuple[float, float]:
        """First and last s."""
        return self.curve.domain

    @property
    def is_still(self) -> bool:
        """Whether the joints stay where they are, but for rounding."""
        h = np.diff(self.breaks)[:, None]
        moves = np.abs(self.coefficients[:, 1:]) * h[:, None] ** np.arange(
            1, self.curve.degree + 1
        ).reshape(-1, 1)
        return not (moves > _ROUNDING * np.abs(self.curve.points).max(initial=0.0)).any()

    @property
    def is_straight(self) -> bool:
        """Whether the joints keep their ratio all the way, at an even rate by s."""
        return len(self.breaks) == 2 and not self.coefficients[0, 2:].any()

    def at(self, s: float) -> FloatArray:
        """Give q, its first and its second derivative by s, as rows, shape (3, n).

        Nothing is checked: what rounding has carried beyond the domain is its end.
        """
        rows = np.empty((3, self.curve.dim))
        start, end = self._sampler.domain
        self._sampler.into(min(max(s, start), end), rows)
        return rows

    def pieces_of(self, s: FloatArray) -> IndexArray:
        """Give the piece that each s lies in, shape (m,)."""
        return np.searchsorted(self.breaks[1:-1], s, side="right")

    def sample(
        self, s: FloatArray, pieces: IndexArray | None = None
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give q, its first and its second derivative by s at many s, each of shape (m, n).

        Args:
            s: Where, shape (m,).
            pieces: The piece to which each s belongs; by default the one that it lies in.
        """
        rows = self._rows(s, pieces, 2)
        return rows[:, 0], rows[:, 1], rows[:, 2]

    def third(self, s: FloatArray, pieces: IndexArray | None = None) -> FloatArray:
        """Give the third derivative of q by s at many s, shape (m, n); arguments as above."""
        return self._rows(s, pieces, 3)[:, 3]

    def _rows(self, s: FloatArray, pieces: IndexArray | None, order: int) -> FloatArray:
        return self._sampler.sample_pieces(
            s, self.pieces_of(s) if pieces is None else pieces, order
        )

    def mirrored(self, first: float, last: float) -> "JointPath":
        """Give the same places by the parameter first + last - s, so that the way is backwards."""
        curve = self.curve
        knots = first + (last - curve.knots[::-1])
        return JointPath(BSpline(knots, curve.points[::-1], curve.degree))


def _check_smooth(breaks: FloatArray, coefficients: FloatArray) -> None:
    """Refuse a way with a gap or a corner between its pieces."""
    degree = coefficients.shape[1] - 1
    inner = np.diff(breaks)[:-1, None, None]
    # value and slope, each in rad, at the end of every piece but the last
    j = np.arange(degree + 1)[:, None]
    terms = coefficients[:-1] * inner**j
    ends = np.sum(terms, axis=1), np.sum(terms * j, axis=1)
    starts = coefficients[1:, 0], (coefficients[1:, 1] if degree else ends[1] * 0.0) * inner[:, 0]
    size = np.abs(coefficients[:, 0]).max()
    steepest = np.abs(coefficients[:, 1]).max() if degree else 0.0
    gap = np.abs(starts[0] - ends[0]) > _ROUNDING * size
    corner = np.abs(starts[1] - ends[1]) > _SMOOTH * steepest * inner[:, 0] + _ROUNDING * size
    broken = (gap | corner).any(axis=1)
    if broken.any():
        raise CurveError(
            "the joints' direction jumps; smooth the corner or stop at it",
            f"s = {breaks[1 + int(np.argmax(broken))]:.6g}",
        )
