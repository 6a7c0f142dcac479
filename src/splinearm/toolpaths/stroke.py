"""Ways of the tool one after the other as quintic pieces by their own length: all in one table.

Lines and their roundings are quintics, arcs and splines are so to a hundredth of a micrometre.
One table is looked at in one step, however many ways a program has.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil, pi

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.arc_length import ArcLength
from splinearm.curves.basis import IndexArray
from splinearm.curves.bspline import BSpline
from splinearm.curves.hermite import Jet, quintic_pieces

from .action import ArcFeed, Feed, Move, Rapid

_ARC_STEP = pi / 10.0
"""Largest turn of a piece of an arc: off by 1e-9 of the radius."""

_CLOSE = 1e-8
"""How far a piece may be off its spline, m."""

_MOST_PIECES = 4096

_BENT = 1e-6
"""Directions that differ by less, in rad, are one."""

_KINK = 1e-3
"""Curvatures that differ by less, in 1/m and as a share, are one."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Strokes:
    """Ways one after the other, each C2 in itself, by the length from the first one's start."""

    edges: FloatArray
    """Where each way begins, and the end of the last, shape (m + 1,), m."""
    owners: IndexArray
    """Which of the given moves each way is of, shape (m,)."""
    starts: FloatArray
    """Where each piece begins, shape (k,), m."""
    coefficients: FloatArray
    """Of powers of s - starts, shape (k, 6, 3)."""
    first: IndexArray
    """The first piece of each way, shape (m + 1,)."""

    @property
    def lengths(self) -> FloatArray:
        """How long each way is, shape (m,), m."""
        return np.diff(self.edges)

    def jets(self, s: FloatArray, way: IndexArray) -> Jet:
        """Give places and two derivatives at s on given ways, each of shape (k, 3)."""
        piece = np.searchsorted(self.starts, s, side="right") - 1
        piece = np.clip(piece, self.first[way], self.first[way + 1] - 1)
        x = (s - self.starts[piece])[:, None]
        c = self.coefficients[piece]
        value, slope, bend = c[:, 5], np.zeros_like(c[:, 5]), np.zeros_like(c[:, 5])
        for j in range(4, -1, -1):
            bend = bend * x + 2.0 * slope
            slope = slope * x + value
            value = value * x + c[:, j]
        return value, slope, bend

    def moved(self, T: FloatArray) -> "Strokes":
        """Give the same ways in another frame, by the pose of this one in it, shape (4, 4)."""
        turned = self.coefficients @ T[:3, :3].T
        turned[:, 0] += T[:3, 3]
        return replace(self, coefficients=turned)

    def inner(self, begin: float, end: float, way: int) -> FloatArray:
        """Give where the pieces of a way meet between two places, shape (k,), m."""
        starts = self.starts[self.first[way] + 1 : self.first[way + 1]]
        crumb = 1e-3 * (end - begin)
        return starts[(starts > begin + crumb) & (starts < end - crumb)]


def strokes_of(moves: Sequence[Move]) -> Strokes:
    """Give moves, each beginning where the one before it ends and none of length 0, as ways.

    A spline with a kink is several ways.
    """
    edges, owners, first = [0.0], list[int](), [0]
    starts, coefficients = list[FloatArray](), list[FloatArray]()
    count = 0
    for owner, move in enumerate(moves):
        for nodes, jet in _smooth_parts(move):
            starts.append(edges[-1] + nodes[:-1])
            first_ones, last_ones = _part(jet, slice(None, -1)), _part(jet, slice(1, None))
            coefficients.append(quintic_pieces(np.diff(nodes), first_ones, last_ones))
            count += len(nodes) - 1
            edges.append(edges[-1] + float(nodes[-1]))
            owners.append(owner)
            first.append(count)
    return Strokes(
        edges=np.array(edges),
        owners=np.array(owners, dtype=np.intp),
        starts=np.concatenate(starts),
        coefficients=np.concatenate(coefficients),
        first=np.array(first, dtype=np.intp),
    )


def bends(
    before: Jet, behind: Jet
) -> "tuple[FloatArray, np.ndarray[tuple[int], np.dtype[np.bool_]]]":
    """Give by how much directions differ where ways meet, and whether there is a corner, (k,)."""
    turn: FloatArray = np.linalg.norm(behind[1] - before[1], axis=1)
    curvature = np.maximum(*(np.linalg.norm(jet[2], axis=1) for jet in (before, behind)))
    kink = np.linalg.norm(behind[2] - before[2], axis=1) > _KINK * (1.0 + curvature)
    return turn, (turn > _BENT) | kink


def _smooth_parts(move: Move) -> list[tuple[FloatArray, Jet]]:
    """Give the C2 parts of a move: nodes by length, from 0, and the jets there."""
    if isinstance(move, Rapid | Feed):
        way = move.end - move.start
        length = float(np.linalg.norm(way))
        slope = np.tile(way / length, (2, 1))
        jet = np.array([move.start, move.end]), slope, np.zeros((2, 3))
        return [(np.array([0.0, length]), jet)]
    if isinstance(move, ArcFeed):
        return [_arc(move)]
    return _spline(move.curve)


def _arc(move: ArcFeed) -> tuple[FloatArray, Jet]:
    count = max(1, ceil(abs(move.turn) / _ARC_STEP))
    x = np.linspace(0.0, 1.0, count + 1)
    a, b = (move.axis + 1) % 3, (move.axis + 2) % 3
    p = move.at(x)
    arms = p[:, (a, b)] - move.centre[[a, b]]
    radius = np.linalg.norm(arms, axis=1, keepdims=True)
    out = arms / radius
    on = np.stack((-out[:, 1], out[:, 0]), axis=1)
    growth = (radius[-1] - radius[0]) * np.ones_like(radius)
    slope, bend = np.zeros((count + 1, 3)), np.zeros((count + 1, 3))
    slope[:, (a, b)] = growth * out + radius * move.turn * on
    slope[:, move.axis] = move.end[move.axis] - move.start[move.axis]
    bend[:, (a, b)] = 2.0 * growth * move.turn * on - radius * move.turn**2 * out
    length = move.length
    return length * x, (p, slope / length, bend / length**2)


def _spline(curve: BSpline) -> list[tuple[FloatArray, Jet]]:
    joined = list[tuple[FloatArray, Jet]]()
    for a, b in pairwise(curve.breaks):
        nodes, jet = _span(curve.part(a, b))
        if joined:
            known, before = joined[-1]
            kinks = bends(_part(before, slice(-1, None)), _part(jet, slice(1)))[1]
            if not kinks.any():
                p, slope, bend = (
                    np.concatenate((one, other[1:])) for one, other in zip(before, jet, strict=True)
                )
                joined[-1] = np.concatenate((known, known[-1] + nodes[1:])), (p, slope, bend)
                continue
        joined.append((nodes, jet))
    return joined


def _span(curve: BSpline) -> tuple[FloatArray, Jet]:
    """Give nodes of one span of a spline, close enough for the quintics between them."""
    lengths = ArcLength(curve)
    count = 1
    while True:
        s = np.linspace(0.0, lengths.length, 2 * count + 1)
        p, slope, bend = (curve.at(lengths.u(s), order) for order in (0, 1, 2))
        rate = np.linalg.norm(slope, axis=1, keepdims=True)
        slope = slope / rate
        bend = (bend - np.sum(bend * slope, axis=1, keepdims=True) * slope) / rate**2
        nodes, jet = s[::2], (p[::2], slope[::2], bend[::2])
        h = np.diff(nodes)
        pieces = quintic_pieces(h, _part(jet, slice(None, -1)), _part(jet, slice(1, None)))
        middle = np.einsum("kjn,kj->kn", pieces, (0.5 * h[:, None]) ** np.arange(6))
        if count >= _MOST_PIECES or np.abs(middle - p[1::2]).max() <= _CLOSE:
            return nodes, jet
        count *= 2


def _part(jet: Jet, some: slice) -> Jet:
    return jet[0][some], jet[1][some], jet[2][some]
