"""Curves sampled quickly: in a control loop, or at many parameters."""

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import CurveError

from . import basis


class Sampler:
    """Position and derivatives of one curve, from a polynomial for each of its pieces.

    Making one costs about as much as a few hundred samples; the first compiles its kernels.
    """

    __slots__ = ("_one", "domain", "table")

    def __init__(self, table: FloatArray) -> None:
        """Take what ``polynomial_table`` gives."""
        self.table = table
        """The polynomials, for other kernels: what module ``sampler_kernel`` describes."""
        self._one = _kernels()[0]
        self.domain = (float(self.table[0, 0]), float(self.table[-1, 0]))
        """First and last parameter."""

    def __reduce__(self) -> tuple[type["Sampler"], tuple[FloatArray]]:
        return Sampler, (self.table,)

    def into(self, u: float, out: FloatArray) -> None:
        """Write position, velocity, acceleration ... at one parameter into the rows of ``out``.

        Args:
            u: Parameter in the domain.
            out: Contiguous array of float64, shape (order + 1, dim); with three rows it is
                written soonest.

        Raises:
            CurveError: If the parameter lies outside the domain or is not a number.
            ValueError: If ``out`` has not that shape.
            TypeError: If ``out`` is no such array.
        """
        if self._one(self.table, u, out):
            self._refuse(u, out)

    def sample(self, us: ArrayInput, order: int = 2) -> FloatArray:
        """Give position and derivatives at many parameters, shape (..., order + 1, dim).

        Sorted parameters are quickest.

        Args:
            us: Parameters in the domain, shape (...).
            order: The highest derivative.

        Raises:
            CurveError: If a parameter lies outside the domain or is not a number.
            ValueError: If the order is negative.
        """
        if order < 0:
            raise ValueError(f"order: want 0 or more, got {order}")
        parameters = np.asarray(us, dtype=np.float64)
        flat = np.ascontiguousarray(parameters).ravel()
        out = np.empty((flat.size, order + 1, self.dim))
        wrong = _kernels()[1](self.table, flat, out)
        if wrong >= 0:
            self._refuse(float(flat[wrong]), out[0])
        return out.reshape(*parameters.shape, order + 1, self.dim)

    def sample_pieces(self, us: ArrayInput, pieces: ArrayInput, order: int = 2) -> FloatArray:
        """Give position and derivatives, each parameter on a given piece, (m, order + 1, dim).

        At a knot this chooses the side; beyond the ends of its piece a polynomial simply goes on.

        Args:
            us: Parameters, shape (m,).
            pieces: Pieces between different knots of the domain, counted from 0, shape (m,).
            order: The highest derivative.

        Raises:
            ValueError: If the order is negative, shapes differ, there is no such piece, or a
                parameter is not finite.
        """
        if order < 0:
            raise ValueError(f"order: want 0 or more, got {order}")
        parameters = np.ascontiguousarray(us, dtype=np.float64)
        chosen = np.ascontiguousarray(pieces, dtype=np.float64)
        if parameters.ndim != 1 or chosen.shape != parameters.shape:
            raise ValueError(
                f"pieces: want one for each parameter, got shapes {chosen.shape} and "
                f"{parameters.shape}"
            )
        if not np.isfinite(parameters).all():
            raise ValueError(f"us: want finite numbers, got {parameters.tolist()}")
        out = np.empty((parameters.size, order + 1, self.dim))
        wrong = _kernels()[2](self.table, chosen, parameters, out)
        if wrong >= 0:
            raise ValueError(f"pieces: want 0 to {len(self.table) - 2}, got {chosen[wrong]:g}")
        return out

    @property
    def dim(self) -> int:
        """Number of coordinates."""
        return int(self.table[-1, 3] - self.table[-1, 5])

    def _refuse(self, u: float, out: FloatArray) -> None:
        start, end = self.domain
        if not start <= u <= end:
            raise CurveError(f"defined from {start} to {end}, not at {u}", "B-spline")
        raise ValueError(f"out: want shape (order + 1, {self.dim}), got {out.shape}")


def polynomial_table(
    knots: FloatArray, rows: FloatArray, degree: int, *, rational: bool
) -> FloatArray:
    """Give the table of a curve that module ``sampler_kernel`` describes.

    Its polynomials are written around the middles of the pieces, where powers lose least.
    """
    from .sampler_kernel import FOOT, HEAD

    breaks = np.unique(knots[degree : knots.size - degree])
    k, columns = breaks.size - 1, rows.shape[1]
    middles = 0.5 * (breaks[:-1] + breaks[1:])
    table = np.zeros((k + 1, max(FOOT, HEAD + (degree + 1) * columns)))
    for j in range(degree + 1):
        at = HEAD + (degree - j) * columns
        values = basis.evaluate(knots, rows, degree, middles, j)
        table[:-1, at : at + columns] = values / math.factorial(j)
    table[:, 0] = breaks
    table[:-1, 1] = middles
    # the search for a share starts at the last piece that begins in a share before: shares are
    # found for parameters by the same monotone arithmetic, so rounding cannot mislead
    scale = k / (breaks[-1] - breaks[0])
    shares = np.clip((breaks[:-1] - breaks[0]) * scale, 0.0, k - 1.0).astype(np.intp)
    table[:, 2] = np.maximum(np.searchsorted(shares, np.arange(k + 1), side="left") - 1, 0)
    table[-1, 1] = scale
    table[-1, 3:FOOT] = columns, degree, rational
    return table


@functools.cache
def _kernels() -> tuple[Callable[..., Any], ...]:
    """Give the kernels for one parameter, for many and for pieces, compiled for their arguments."""
    from splinearm.compiled import entry, inputs, numbers, outputs

    from . import sampler_kernel

    return (
        entry(sampler_kernel.sample_one, *inputs(2), *numbers(), *outputs(2)),
        entry(sampler_kernel.sample_many, *inputs(2, 1), *outputs(3)),
        entry(sampler_kernel.sample_pieces, *inputs(2, 1, 1), *outputs(3)),
    )
