"""Arc length along a curve, and back from arc length to the curve's parameter."""

from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import CurveError

from .bernstein import binomials
from .bspline import BSpline
from .velocity import velocity_of

_ROOM = 24
"""Cells a piece that there is room for at first."""

_ROUNDING = 1e-14
"""A length beyond the ends by this share of the whole is one of the ends."""


class _Basis(NamedTuple):
    """What turns values at Chebyshev's nodes into polynomials."""

    nodes: FloatArray
    to_chebyshev: FloatArray
    to_integral: FloatArray
    to_powers: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class ArcLength:
    """The arc length of a curve as a map that is made once and asked often, both ways.

    Lengths are right to 1e-12 of the whole, and so is the place on the curve that belongs to a
    length. Where a curve is slow, as before a cusp, a place is known better than its parameter.
    """

    curve: BSpline
    """The curve, of degree 1 or more."""
    closed: bool = False
    """Whether the curve ends where it starts and is run through again and again."""
    _edges: FloatArray = field(init=False, repr=False)
    _turned: FloatArray = field(init=False, repr=False)
    _guides: tuple[FloatArray, FloatArray] = field(init=False, repr=False)
    _tables: tuple[FloatArray, FloatArray] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if self.curve.degree == 0:
            raise CurveError("a curve of degree 0 jumps and has no length", "arc length")
        if self.closed and not self.curve.is_closed():
            raise CurveError("it does not end where it starts: not closed", "arc length")
        edges, by_u, by_s = _cells(self.curve)
        turned = np.ascontiguousarray(edges[:, ::-1])
        guides = _guide(edges[:, 0]), _guide(edges[:, 1])
        for name, value in (
            ("_edges", edges),
            ("_turned", turned),
            ("_guides", guides),
            ("_tables", (by_u, by_s)),
        ):
            object.__setattr__(self, name, value)

    @property
    def length(self) -> float:
        """The length of the whole curve, of one turn of a closed one."""
        return float(self._edges[-1, 1])

    def s(self, u: ArrayInput) -> FloatArray:
        """Give the length from the start of the curve to parameters, shape (...).

        Args:
            u: Parameters in the domain, of a closed curve any, shape (...).

        Raises:
            CurveError: If a parameter lies outside the domain or is not a number.
        """
        return self._ask(u, self._edges, self._guides[0], self._tables[0], "parameter")

    def u(self, s: ArrayInput) -> FloatArray:
        """Give the parameters that lengths lead to, shape (...).

        Where the curve stands still it is the parameter at which it goes on; at the very end the
        one at which it stopped.

        Args:
            s: Lengths from the start of the curve from 0 to its length, of a closed curve any,
                shape (...). What lies beyond by rounding, 1e-14 of the whole, counts as the end.

        Raises:
            CurveError: If a length lies outside or is not a number.
        """
        return self._ask(s, self._turned, self._guides[1], self._tables[1], "length")

    def _ask(
        self, x: ArrayInput, edges: FloatArray, guide: FloatArray, table: FloatArray, what: str
    ) -> FloatArray:
        from .arc_length_kernel import look_up

        wanted = np.ascontiguousarray(x, dtype=np.float64)
        shape = np.shape(x)
        flat = wanted.ravel()
        turns = None
        if self.closed:
            first, last = edges[0, 0], edges[-1, 0]
            turns = np.floor((flat - first) / (last - first))
            # the end of a turn is the start of the next; rounding may lead just beyond
            flat = np.clip(flat - turns * (last - first), first, last)
        out = np.empty(flat.shape)
        slack = _ROUNDING * (edges[-1, 0] - edges[0, 0]) if what == "length" else 0.0
        wrong = look_up(flat, edges, guide, table, slack, out)
        if wrong >= 0:
            raise CurveError(
                f"{what}s go from {edges[0, 0]} to {edges[-1, 0]}, not to {flat[wrong]}",
                "arc length",
            )
        if turns is not None:
            out += turns * (edges[-1, 1] - edges[0, 1])
        return out.reshape(shape)


@cache
def _basis() -> _Basis:
    from .arc_length_kernel import NODES

    k = np.arange(NODES)
    angles = np.pi * (k + 0.5) / NODES
    to_chebyshev = np.cos(k[:, None] * angles) * 2.0 / NODES
    to_chebyshev[0] *= 0.5
    units = np.eye(NODES)
    to_integral, to_powers = np.zeros((NODES, NODES + 1)), np.zeros((NODES, NODES))
    for j, unit in enumerate(units):
        to_integral[j, : j + 2] = chebyshev.cheb2poly(chebyshev.chebint(unit[: j + 1], lbnd=-1))
        to_powers[j, : j + 1] = chebyshev.cheb2poly(unit[: j + 1])
    return _Basis(
        np.cos(angles),
        np.ascontiguousarray(to_chebyshev.T),
        to_integral,
        to_powers,
    )


def _cells(curve: BSpline) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give the edges of the cells (u, s) and their polynomials both ways."""
    from .arc_length_kernel import NODES, build

    velocity = velocity_of(curve)
    # so that V and W are near 1, in whatever unit
    size = np.abs(velocity.V).max()
    weight = velocity.W.max()
    if not size > 0.0:
        raise CurveError("all of it is one point: it has no length", "arc length")
    V = velocity.V / size * binomials(velocity.V.shape[1] - 1)[:, None]
    W = velocity.W / weight * binomials(velocity.W.shape[1] - 1)
    room = _ROOM * len(V)
    while True:
        edges = np.empty((room + 1, 2))
        by_u, by_s = np.empty((2, room, NODES + 1))
        count = build(velocity.ends, V, W, *_basis(), edges, by_u, by_s)
        if count >= 0:
            break
        room *= 4
    if count == 0:
        raise CurveError("its weights differ too much: its speed is no number", "arc length")
    edges, by_u, by_s = edges[: count + 1].copy(), by_u[:count].copy(), by_s[:count].copy()
    unit = size / weight**2
    edges[:, 1] *= unit
    by_u *= unit
    return edges, by_u, by_s


def _guide(edges: FloatArray) -> FloatArray:
    """Give the cells at even steps from the first to the last edge."""
    count = len(edges) - 1
    steps = 2 * count
    at = edges[0] + (edges[-1] - edges[0]) * np.arange(steps) / steps
    found = np.searchsorted(edges, at, side="right") - 1
    return np.asarray(np.clip(found, 0, count - 1), dtype=np.float64)
