"""Where curves meet lines, planes, each other and themselves; none is missed."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import CurveError

from . import cell, contact
from .bernstein import EPS, Bounded
from .bspline import BSpline
from .feature import Places
from .projection import Projection
from .root import BoolArray, find_roots

_SHARE = 1e-9
"""Tolerance that is taken if none is given, of the size of the curves."""

_MOST_SAMPLES = 64


class Meetings(NamedTuple):
    """Where two curves meet, or a curve meets itself, in the order of u."""

    u: FloatArray
    """Parameters on the first curve, shape (k,)."""
    v: FloatArray
    """Parameters on the second; of one curve with itself the later one, shape (k,)."""
    points: FloatArray
    """The places on the first curve, shape (k, dim)."""
    gaps: FloatArray
    """Distances from there to the second curve, at most the tolerance, shape (k,)."""
    touching: BoolArray
    """Whether both run side by side there, and touch or cross twice within the tolerance."""
    stretches: FloatArray
    """Pieces on which they are the same: u from and to, then v, which may fall, shape (j, 4)."""


def meet_plane(curve: BSpline, point: ArrayInput, normal: ArrayInput) -> Places:
    """Give where a curve meets the plane through a point at right angles to a normal.

    In the plane of two coordinates that is a line. What touches to rounding counts; pieces in the
    plane are stretches. A closed curve has its seam at its start.

    Args:
        curve: The curve.
        point: A point of the plane, shape (dim,).
        normal: Its normal, of any length above 0, shape (dim,).

    Raises:
        ValueError: If the normal is 0 or shapes do not fit.
    """
    base = frozen_array(point, (curve.dim,), "point")
    across = frozen_array(normal, (curve.dim,), "normal")
    size = float(np.linalg.norm(across))
    if not size > 0.0:
        raise ValueError(f"normal: want a direction, got {across.tolist()}")
    ends, rows = _homogeneous_pieces(curve)
    height = (rows[..., :-1] - rows[..., -1:] * base) @ (across / size)
    terms = (np.abs(rows[..., :-1]) + rows[..., -1:] * np.abs(base)) @ (np.abs(across) / size)
    error = (curve.dim + 4 * curve.degree + 4) * EPS * terms.max(axis=1)
    roots = find_roots(Bounded(np.ascontiguousarray(height), error))
    width = np.diff(ends)
    at = ends[roots.piece] + roots.t * width[roots.piece]
    at = np.where(roots.t == 1.0, ends[roots.piece + 1], at)
    slack = (roots.high - roots.low + 4.0 * EPS) * width[roots.piece]
    stretches = np.stack((ends[roots.everywhere], ends[roots.everywhere + 1]), axis=1)
    return Places(_single(at, slack, stretches, curve), _joined(stretches))


def meet_line(curve: BSpline, point: ArrayInput, direction: ArrayInput) -> Places:
    """Give where a plane curve meets the line through a point in a direction, as ``meet_plane``.

    Raises:
        ValueError: If the curve has not two coordinates, the direction is 0 or shapes do not fit.
    """
    if curve.dim != 2:
        raise ValueError(f"curve: want one in the plane, got {curve.dim} coordinates")
    along = frozen_array(direction, (2,), "direction")
    if not along.any():
        raise ValueError(f"direction: want one, got {along.tolist()}")
    return meet_plane(curve, point, np.array([-along[1], along[0]]))


def meet_curves(first: BSpline, second: BSpline, tolerance: float | None = None) -> Meetings:
    """Give where two curves meet, in the plane or in space.

    Pairs of pieces are halved, and left out only where their hulls are apart: no crossing is
    missed. Of a curve that runs over the same places several times not every stretch is told.
    Curves that run side by side within the tolerance touch, once for each such run;
    where they are the same all along it is a stretch.

    Args:
        first: A curve.
        second: One of as many coordinates.
        tolerance: How far places that count as one may be apart; None: 1e-9 of the larger of both.

    Raises:
        CurveError: If the curves run side by side so long that the tolerance is too small, or one
            is a single place.
        ValueError: If they have different numbers of coordinates, or the tolerance is not above 0.
    """
    if first.dim != second.dim:
        raise ValueError(f"dim: want the same for both, got {first.dim} and {second.dim}")
    reach = _tolerance(tolerance, first, second)
    same = _finer(first, second, _same_stretches(first, second, reach))
    a, u = _cut_pieces(first, same[:, :2])
    b, v = _cut_pieces(second, same[:, 2:])
    pairs = cell.pair_up(a, b, u, v, reach)
    pairs = pairs.take(~_matched(pairs, same) | ~_narrow(pairs))
    found = contact.sort_out(first, second, cell.meet(pairs, reach), reach)
    found = contact.once(first, second, found, reach, itself=False)
    return _meetings(first, second, found, same)


def meet_itself(curve: BSpline, tolerance: float | None = None) -> Meetings:
    """Give where a curve meets itself, each place once with u below v.

    Where it goes on from one piece to the next, and the seam of a closed curve, do not count.

    Args:
        curve: A curve.
        tolerance: How far places that count as one may be apart; None: 1e-9 of its size.

    Raises:
        CurveError: If it runs along itself so long that the tolerance is too small, or is a single
            place.
        ValueError: If the tolerance is not above 0.
    """
    reach = _tolerance(tolerance, curve)
    ends, rows = _homogeneous_pieces(curve)
    pieces, u = cell.monotone(rows, np.stack((ends[:-1], ends[1:]), axis=1))
    pairs = cell.pair_up(pieces, pieces, u, u, reach)
    pairs = pairs.take(pairs.u[:, 0] < pairs.v[:, 0])
    start, end = curve.at(np.array(curve.domain))
    closed = bool(np.linalg.norm(end - start) <= reach)
    seam = curve.domain if closed else (np.inf, np.inf)
    candidates = contact.without_corners(curve, cell.meet(pairs, reach, seam), reach, closed=closed)
    found = contact.sort_out(curve, curve, candidates, reach, itself=True)
    found = contact.once(curve, curve, found, reach, itself=True)
    return _meetings(curve, curve, found, np.empty((0, 4)))


def _tolerance(tolerance: float | None, *curves: BSpline) -> float:
    sizes = [float(np.ptp(curve.points, axis=0).max()) for curve in curves]
    if tolerance is not None and not tolerance > 0.0:
        raise ValueError(f"tolerance: want it above 0, got {tolerance}")
    reach = _SHARE * max(sizes) if tolerance is None else tolerance
    if min(sizes) <= reach:
        raise CurveError(
            f"all of it is one place within {reach:.3g}: ask for the nearest place", "meeting"
        )
    return reach


def _homogeneous_pieces(curve: BSpline) -> tuple[FloatArray, FloatArray]:
    ends, rows = curve.bezier()
    if not curve.is_rational:
        rows = np.concatenate((rows, np.ones((*rows.shape[:2], 1))), axis=2)
    if curve.degree == 0:
        rows = np.repeat(rows, 2, axis=1)
    return ends, rows


def _single(at: FloatArray, slack: FloatArray, stretches: FloatArray, curve: BSpline) -> FloatArray:
    """Give each place once: those where pieces meet are roots of both, ends of stretches none."""
    start, end = curve.domain
    rounding = 1e-13 * (end - start)
    order = np.argsort(at, kind="stable")
    kept: list[float] = []
    room = 0.0
    for value, more in zip(at[order], slack[order], strict=True):
        inside = (stretches[:, 0] - more - rounding <= value) & (
            value <= stretches[:, 1] + more + rounding
        )
        if inside.any():
            continue
        if kept and value - kept[-1] <= max(room, more) + rounding:
            room = max(room, more)
            continue
        kept.append(float(value))
        room = more
    around = len(kept) > 1 and kept[0] - start <= rounding and end - kept[-1] <= rounding
    if around and curve.is_closed():
        kept.pop()
    return np.array(kept)


def _joined(stretches: FloatArray) -> FloatArray:
    """Give stretches of which those that follow one another are one."""
    if len(stretches) < 2:
        return stretches
    new = np.append(True, stretches[1:, 0] > stretches[:-1, 1])
    last = np.append(new[1:], True)
    return np.stack((stretches[new, 0], stretches[last, 1]), axis=1)


def _same_stretches(first: BSpline, second: BSpline, reach: float) -> FloatArray:
    """Give pieces, none with a break inside, on which the curves are the same, (j, 4)."""
    on_second, on_first = Projection(second), Projection(first)
    ends_u, ends_v = first.breaks, second.breaks
    down, up = on_second.nearest(first.at(ends_u)), on_first.nearest(second.at(ends_v))
    # where one of them ends, at its pieces' ends, or at the other's
    pairs = np.concatenate(
        (
            np.stack((ends_u, down.u), axis=1)[down.distance <= reach],
            np.stack((up.u, ends_v), axis=1)[up.distance <= reach],
        )
    )
    if second.is_closed():
        # at the seam of the other curve its parameter is both its first and its last
        low, high = second.domain
        seams = pairs[(pairs[:, 1] == low) | (pairs[:, 1] == high)]
        flipped = np.stack((seams[:, 0], low + high - seams[:, 1]), axis=1)
        pairs = np.concatenate((pairs, flipped))
    if first.is_closed():
        low, high = first.domain
        seams = pairs[(pairs[:, 0] == low) | (pairs[:, 0] == high)]
        flipped = np.stack((low + high - seams[:, 0], seams[:, 1]), axis=1)
        pairs = np.concatenate((pairs, flipped))
    # two irreducible curves of degrees p and q that share more than p q places are the same
    # (Bezout): so many between two common places tell
    count = min(first.degree * second.degree + 1, _MOST_SAMPLES)
    shares = np.arange(1, count + 1) / (count + 1)
    at = np.unique(pairs[:, 0])
    keep = np.append(True, np.diff(at) > 1e-12 * (ends_u[-1] - ends_u[0]))
    at = at[keep] if at.size else at
    shortest = 10.0 * np.sqrt(reach * max(np.ptp(c.points, axis=0).max() for c in (first, second)))
    same: list[tuple[float, float, float, float]] = []
    for low, high in pairwise(at):
        places = first.at(low + (high - low) * shares)
        middle = on_second.nearest(places)
        # what is shorter may be two curves that touch
        if (middle.distance > reach).any() or np.ptp(places, axis=0).max() <= shortest:
            continue
        near = 1e-12 * (ends_u[-1] - ends_u[0])
        low_v = _next_to(pairs[np.abs(pairs[:, 0] - low) <= near, 1], middle.u[0])
        high_v = _next_to(pairs[np.abs(pairs[:, 0] - high) <= near, 1], middle.u[-1])
        if low_v != high_v:
            same.append((float(low), float(high), low_v, high_v))
    return np.array(same).reshape(-1, 4)


def _next_to(values: FloatArray, wanted: float) -> float:
    return float(values[int(np.argmin(np.abs(values - wanted)))])


def _finer(first: BSpline, second: BSpline, same: FloatArray) -> FloatArray:
    """Give stretches cut so that the curves turn little on each, where one place tells v from u."""
    finer: list[FloatArray] = []
    for row in same:
        part = first.part(row[0], row[1])
        ends, rows = _homogeneous_pieces(part)
        _, u = cell.monotone(rows, np.stack((ends[:-1], ends[1:]), axis=1))
        inner = u[1:, 0]
        v = Projection(second.part(*sorted(row[2:]))).nearest(first.at(inner)).u
        chain = np.concatenate((row[2:3], v, row[3:]))
        steps = np.diff(chain)
        if (steps > 0.0).all() or (steps < 0.0).all():
            cuts = np.concatenate((row[:1], inner, row[1:2]))
            finer.append(np.stack((cuts[:-1], cuts[1:], chain[:-1], chain[1:]), axis=1))
        else:
            finer.append(row[None])
    return np.concatenate(finer) if finer else same


def _cut_pieces(curve: BSpline, ends: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give the pieces of a curve, cut at some parameters too, and their ends."""
    start, stop = curve.domain
    width = 1e-12 * (stop - start)
    inner = np.unique(ends)
    new = [x for x in inner if np.abs(curve.breaks - x).min() > width]
    # a knot inserted as often as it may be does not change the curve
    cut = curve.with_knots(np.array(new)) if new else curve
    edges, rows = _homogeneous_pieces(cut)
    return rows, np.stack((edges[:-1], edges[1:]), axis=1)


def _matched(pairs: cell.Pairs, same: FloatArray) -> BoolArray:
    """Tell which pairs lie on the same stretch."""
    matched = np.zeros(len(pairs.u), dtype=np.bool)
    u, v = pairs.u.mean(axis=1), pairs.v.mean(axis=1)
    for low, high, start, end in same:
        inside = (low < u) & (u < high) & (min(start, end) < v) & (v < max(start, end))
        matched |= inside
    return matched


def _narrow(pairs: cell.Pairs) -> BoolArray:
    return cell.turns_little(pairs.a) & cell.turns_little(pairs.b)


def _chained(same: FloatArray, second: BSpline) -> FloatArray:
    """Give stretches of which those that follow one another on both curves are one."""
    room = _SHARE * (second.domain[1] - second.domain[0])
    chains: list[list[float]] = []
    for low, high, start, end in same.tolist():
        if chains and chains[-1][1] == low and abs(chains[-1][3] - start) <= room:
            chains[-1][1], chains[-1][3] = high, end
        else:
            chains.append([low, high, start, end])
    return np.array(chains).reshape(-1, 4)


def _meetings(
    first: BSpline, second: BSpline, found: contact.Contacts, same: FloatArray
) -> Meetings:
    ends = found.stretches[:, [0, 2, 1, 3]].reshape(-1, 2)
    known = contact.on_stretches(first, second, ends, same).reshape(-1, 2).all(axis=1)
    more = found.stretches[~known]
    kept = ~contact.on_stretches(first, second, found.places, np.concatenate((same, more)))
    places, touching = found.places[kept], found.touching[kept]
    order = np.lexsort((places[:, 1], places[:, 0]))
    u, v = places[order].T
    points = first.at(u)
    gaps = np.linalg.norm(second.at(v) - points, axis=1)
    stretches = np.concatenate((_chained(same, second), more))
    stretches = stretches[np.argsort(stretches[:, 0], kind="stable")]
    return Meetings(u, v, points, gaps, touching[order], stretches)
