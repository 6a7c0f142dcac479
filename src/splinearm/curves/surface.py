"""B-spline surfaces of any degrees: polynomial or rational; clamped, unclamped or closed."""

import functools
import operator
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal, Self

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError

from . import rational
from .bspline import BSpline

Along = Literal["u", "v"]
"""One of the two directions of a surface."""


@dataclass(frozen=True, slots=True, eq=False)
class BSplineSurface:
    """A B-spline surface over a rectangle of parameters and nowhere else; with weights a NURBS.

    In each direction knots, degree and domain are those of a ``BSpline``. At a knot where the
    surface is not smooth, values come from the right, at the end of the domain from the left.
    """

    knots_u: FloatArray
    """Knots of the first direction, shape (m + degree_u + 1,), never falling."""
    knots_v: FloatArray
    """Knots of the second direction, shape (n + degree_v + 1,), never falling."""
    points: FloatArray
    """Control points, shape (m, n, dim): the first axis along u."""
    degree_u: int
    """Degree of the first direction, a whole number of at least 0."""
    degree_v: int
    """Degree of the second direction, a whole number of at least 0."""
    weights: FloatArray | None = None
    """Weights of the control points, shape (m, n), each above 0; None: it is polynomial."""
    _rows: FloatArray = field(init=False, repr=False)
    _table: FloatArray = field(init=False, repr=False)
    """The rows with zeros behind, as kernels want them."""

    def __post_init__(self) -> None:
        points = frozen_array(self.points, (None, None, None), "points")
        degrees = operator.index(self.degree_u), operator.index(self.degree_v)
        weights = self.weights
        if weights is not None:
            weights = frozen_array(weights, points.shape[:2], "weights")
            if not (weights > 0.0).all():
                raise ValueError(f"weights: want each above 0, got {weights.tolist()}")
        for axis, name in ((0, "u"), (1, "v")):
            knots = getattr(self, f"knots_{name}")
            probe = np.zeros((points.shape[axis], 1))
            try:
                checked = BSpline(knots, probe, degrees[axis])
            except ValueError as error:
                raise ValueError(f"along {name}: {error}") from None
            object.__setattr__(self, f"knots_{name}", checked.knots)
        if points.shape[2] == 0:
            raise ValueError(f"points: want at least one coordinate, got shape {points.shape}")
        rows = points
        if weights is not None:
            rows = np.concatenate((points * weights[..., None], weights[..., None]), axis=2)
            rows.flags.writeable = False
        table = np.zeros((*rows.shape[:2], -(-rows.shape[2] // 4) * 4))
        table[..., : rows.shape[2]] = rows
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "weights", weights)
        object.__setattr__(self, "_rows", rows)
        object.__setattr__(self, "_table", table)

    @classmethod
    def from_homogeneous(
        cls, knots: tuple[ArrayInput, ArrayInput], rows: ArrayInput, degrees: tuple[int, int]
    ) -> Self:
        """Give the rational surface of homogeneous control points.

        Args:
            knots: Those along u and those along v.
            rows: Points times weight, then the weight, shape (m, n, dim + 1).
            degrees: Along u and along v.

        Raises:
            ValueError: If the numbers do not fit, or a weight is not above 0.
        """
        array = frozen_array(rows, (None, None, None), "rows")
        if not (array[..., -1] > 0.0).all():
            raise ValueError(f"rows: want each weight above 0, got {array[..., -1].tolist()}")
        first, second = (np.asarray(k, dtype=np.float64) for k in knots)
        points = array[..., :-1] / array[..., -1:]
        return cls(first, second, points, *degrees, array[..., -1])

    @property
    def domain(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """First and last u, first and last v."""
        p, q = self.degree_u, self.degree_v
        return (
            (float(self.knots_u[p]), float(self.knots_u[-p - 1])),
            (float(self.knots_v[q]), float(self.knots_v[-q - 1])),
        )

    @property
    def dim(self) -> int:
        """Number of coordinates."""
        return int(self.points.shape[2])

    @property
    def is_rational(self) -> bool:
        """Whether the surface has weights."""
        return self.weights is not None

    @property
    def homogeneous(self) -> FloatArray:
        """Control points times weight, then the weight, shape (m, n, dim + 1)."""
        if self.weights is not None:
            return self._rows
        return np.concatenate((self.points, np.ones((*self.points.shape[:2], 1))), axis=2)

    @property
    def breaks(self) -> tuple[FloatArray, FloatArray]:
        """The different knots of the domain along u and along v: the edges of its patches."""
        return tuple(  # type: ignore[return-value] # they are two
            np.unique(knots[degree : knots.size - degree])
            for knots, degree in ((self.knots_u, self.degree_u), (self.knots_v, self.degree_v))
        )

    def at(self, u: ArrayInput, v: ArrayInput, du: int = 0, dv: int = 0) -> FloatArray:
        """Give points of the surface, or of a partial derivative, shape (..., dim).

        Args:
            u: First parameters, shape (...), or one that goes with all v.
            v: Second parameters, shape (...), or one that goes with all u.
            du: How often it is differentiated by u.
            dv: How often it is differentiated by v.

        Raises:
            CurveError: If a place lies outside the domain or is not a number.
            ValueError: If du or dv is negative, or shapes do not fit.
        """
        return self._jets(u, v, du, dv)[..., du, dv, :]

    def jet(self, u: ArrayInput, v: ArrayInput, order: int) -> FloatArray:
        """Give points and partial derivatives, shape (..., order + 1, order + 1, dim).

        Entry (i, j) is differentiated i times by u and j times by v.

        Args:
            u: First parameters, shape (...), or one that goes with all v.
            v: Second parameters, shape (...), or one that goes with all u.
            order: How often at most in each direction.

        Raises:
            CurveError: If a place lies outside the domain or is not a number.
            ValueError: If the order is negative, or shapes do not fit.
        """
        return self._jets(u, v, order, order)

    def grid(self, us: ArrayInput, vs: ArrayInput, order: int = 0) -> FloatArray:
        """Give what ``jet`` gives for each u with each v, sooner.

        Args:
            us: First parameters, shape (k,).
            vs: Second parameters, shape (l,).
            order: How often at most it is differentiated in each direction.

        Returns:
            Shape (k, l, order + 1, order + 1, dim).

        Raises:
            CurveError: If a place lies outside the domain or is not a number.
            ValueError: If the order is negative, or an array has another number of axes.
        """
        rows, columns = (np.asarray(x, dtype=np.float64, order="C") for x in (us, vs))
        if order < 0 or rows.ndim != 1 or columns.ndim != 1:
            raise ValueError(
                f"grid: want an order of at least 0 and two rows of parameters, got {order} and "
                f"shapes {rows.shape} and {columns.shape}"
            )
        self._check_inside(rows, columns)
        out = np.empty((rows.size * columns.size, order + 1, order + 1, self.dim))
        _kernels()[1](self.knots_u, self.knots_v, self._table, rows, columns, self._column, out)
        return out.reshape(rows.size, columns.size, order + 1, order + 1, self.dim)

    def along_u(self, v: float) -> BSpline:
        """Give the curve of all u at one v.

        Raises:
            CurveError: If that lies outside the domain.
        """
        return self.swapped().along_v(v)

    def along_v(self, u: float) -> BSpline:
        """Give the curve of all v at one u.

        Raises:
            CurveError: If that lies outside the domain.
        """
        flat = BSpline(self.knots_u, self._rows.reshape(len(self._rows), -1), self.degree_u)
        rows = flat.at(float(u)).reshape(self._rows.shape[1:])
        if self.weights is not None:
            rational.check_weights(rows)
            return BSpline.from_homogeneous(self.knots_v, rows, self.degree_v)
        return BSpline(self.knots_v, rows, self.degree_v)

    def swapped(self) -> "BSplineSurface":
        """Give the same surface with u and v exchanged; its normals point to the other side."""
        return BSplineSurface(
            self.knots_v,
            self.knots_u,
            self.points.swapaxes(0, 1),
            self.degree_v,
            self.degree_u,
            None if self.weights is None else self.weights.T,
        )

    def changed(self, along: Along, change: Callable[[BSpline], BSpline]) -> "BSplineSurface":
        """Give the surface after a change of curves that is made to its rows in one direction.

        Args:
            along: The direction.
            change: What gives another curve from a polynomial one of many coordinates, linear in
                its control points: ``BSpline.unclamped`` and the like.

        Raises:
            CurveError: If the change refuses, or a weight would not be above 0.
            ValueError: If there is no such direction.
        """
        if _axis(along) == 1:
            return self.swapped().changed("u", change).swapped()
        m, n, columns = self._rows.shape
        curve = change(BSpline(self.knots_u, self._rows.reshape(m, n * columns), self.degree_u))
        rows = curve.points.reshape(-1, n, columns)
        if self.weights is None:
            return BSplineSurface(curve.knots, self.knots_v, rows, curve.degree, self.degree_v)
        rational.check_weights(rows.reshape(-1, columns))
        degrees = (curve.degree, self.degree_v)
        return BSplineSurface.from_homogeneous((curve.knots, self.knots_v), rows, degrees)

    def with_knots(self, us: ArrayInput = (), vs: ArrayInput = ()) -> "BSplineSurface":
        """Give the same surface with more knots inside its domain.

        Args:
            us: The knots to insert along u, shape (k,); one named twice is inserted twice.
            vs: Those along v, shape (l,).

        Raises:
            CurveError: If one lies outside the domain.
            ValueError: If one would be there more often than the degree.
        """
        finer = self
        for along, values in (("u", us), ("v", vs)):
            new = frozen_array(values, (None,), f"{along}s")
            if new.size:
                finer = finer.changed(along, operator.methodcaller("with_knots", new))  # type: ignore[arg-type] # u or v
        return finer

    def elevated(self, times_u: int = 0, times_v: int = 0) -> "BSplineSurface":
        """Give the same surface with higher degrees.

        Raises:
            ValueError: If a number is negative.
        """
        raised = self.changed("u", lambda curve: curve.elevated(times_u)) if times_u else self
        return raised.changed("v", lambda curve: curve.elevated(times_v)) if times_v else raised

    def clamped(self) -> "BSplineSurface":
        """Give the same surface with end knots that are there degree + 1 times, both ways."""
        return self.changed("u", BSpline.clamped).changed("v", BSpline.clamped)

    def part(
        self, u: tuple[float, float] | None = None, v: tuple[float, float] | None = None
    ) -> "BSplineSurface":
        """Give the piece between two u and two v, clamped where it was cut; parameters stay.

        Args:
            u: Where it starts and ends along u; None: as it was.
            v: Where it starts and ends along v; None: as it was.

        Raises:
            CurveError: If one lies outside the domain.
            ValueError: If they do not rise.
        """
        cut = self if u is None else self.changed("u", lambda curve: curve.part(*u))
        return cut if v is None else cut.changed("v", lambda curve: curve.part(*v))

    def split(self, along: Along, at: float) -> "tuple[BSplineSurface, BSplineSurface]":
        """Give the pieces before and after a parameter of one direction inside its domain.

        Raises:
            CurveError: If it does not lie strictly inside.
        """
        start, end = self.domain[_axis(along)]
        if not start < at < end:
            raise CurveError(f"can be split between {start} and {end} only, not at {at}", "surface")
        if along == "u":
            return self.part(u=(start, at)), self.part(u=(at, end))
        return self.part(v=(start, at)), self.part(v=(at, end))

    def reversed(self, along: Along) -> "BSplineSurface":
        """Give the surface run through backwards in one direction, over the same domain."""
        return self.changed(along, BSpline.reversed)

    def over(self, u: tuple[float, float], v: tuple[float, float]) -> "BSplineSurface":
        """Give the surface over another domain.

        Raises:
            ValueError: If a start and an end do not rise or are not finite.
        """
        moved = self.changed("u", lambda curve: curve.over(*u))
        return moved.changed("v", lambda curve: curve.over(*v))

    def mapped(self, matrix: ArrayInput) -> "BSplineSurface":
        """Give the surface under an affine or projective map.

        Args:
            matrix: Homogeneous matrix on column vectors, shape (dim + 1, dim + 1). Unless its last
                row is (0 ... 0, w) the surface becomes rational.

        Raises:
            CurveError: If the map sends a place between the control points to infinity.
            ValueError: If the matrix has another shape.
        """
        map_ = frozen_array(matrix, (self.dim + 1, self.dim + 1), "matrix")
        knots, degrees = (self.knots_u, self.knots_v), (self.degree_u, self.degree_v)
        if map_[-1, :-1].any() or map_[-1, -1] == 0.0:
            shape = self.points.shape[:2]
            mapped = rational.map_rows(self.homogeneous.reshape(-1, self.dim + 1), map_)
            return BSplineSurface.from_homogeneous(knots, mapped.reshape(*shape, -1), degrees)
        map_ = map_ / map_[-1, -1]
        points = self.points @ map_[:-1, :-1].T + map_[:-1, -1]
        return BSplineSurface(*knots, points, *degrees, self.weights)

    def bezier(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give the Bezier patches.

        Returns:
            The k + 1 edges along u, the l + 1 along v, and control points of shape
            (k, l, degree_u + 1, degree_v + 1, dim), of a rational surface homogeneous.
        """
        m, n, columns = self._rows.shape
        p, q = self.degree_u, self.degree_v
        ends_u, strips = BSpline(self.knots_u, self._rows.reshape(m, -1), p).bezier()
        k = len(strips)
        turned = strips.reshape(k, p + 1, n, columns).transpose(2, 0, 1, 3).reshape(n, -1)
        ends_v, pieces = BSpline(self.knots_v, turned, q).bezier()
        patches = pieces.reshape(-1, q + 1, k, p + 1, columns).transpose(2, 0, 3, 1, 4)
        return ends_u, ends_v, np.ascontiguousarray(patches)

    def _jets(self, u: ArrayInput, v: ArrayInput, du: int, dv: int) -> FloatArray:
        if du < 0 or dv < 0:
            raise ValueError(f"derivatives: want 0 or more, got {du} by u and {dv} by v")
        us, vs = np.asarray(u, dtype=np.float64), np.asarray(v, dtype=np.float64)
        self._check_inside(us, vs)
        if us.shape != vs.shape:
            us, vs = np.broadcast_arrays(us, vs)
        out = np.empty((us.size, du + 1, dv + 1, self.dim))
        flat = (np.ascontiguousarray(x).ravel() for x in (us, vs))
        _kernels()[0](self.knots_u, self.knots_v, self._table, *flat, self._column, out)
        return out.reshape(*us.shape, du + 1, dv + 1, self.dim)

    @property
    def _column(self) -> float:
        """Which column of the table is the weight; 0: none."""
        return float(self.dim) if self.weights is not None else 0.0

    def _check_inside(self, u: FloatArray, v: FloatArray) -> None:
        for name, values, (start, end) in zip("uv", (u, v), self.domain, strict=True):
            outside = ~((values >= start) & (values <= end))
            if outside.any():
                where = float(values.ravel()[int(np.argmax(outside.ravel()))])
                raise CurveError(
                    f"defined from {name} = {start} to {end}, not at {where}", "surface"
                )


def _axis(along: Along) -> int:
    """Give the axis of points that belongs to a direction."""
    if along not in ("u", "v"):
        raise ValueError(f"along: want u or v, got {along!r}")
    return "uv".index(along)


@functools.cache
def _kernels() -> tuple[Callable[..., Any], ...]:
    """Give the kernels for places and for grids, compiled for their arguments."""
    from splinearm.compiled import entry, inputs, numbers, outputs

    from . import surface_kernel

    arguments = (*inputs(1, 1, 3, 1, 1), *numbers(), *outputs(4))
    return entry(surface_kernel.jets, *arguments), entry(surface_kernel.grid, *arguments)
