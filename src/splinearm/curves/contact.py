"""What pairs of pieces that meet amount to: crossings, touches, stretches, each once."""

from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray

from .basis import IndexArray
from .bspline import BSpline
from .cell import Candidates
from .projection import Projection
from .root import BoolArray

_FLAT = 0.25
"""Gaps along a stretch differ by less than this share of the tolerance."""

_SAMPLES = 33
_LEAST = 1e-9
"""Share of a domain that is looked at around a place at least."""

_MOST_SAME = 1e-4
"""Places farther apart than this share of the domain are never one."""

_NEIGHBOURS = 50.0
"""What of one curve does not leave so many tolerances around a place is the place itself."""

_WIDE = 0.2
"""A loop as wide as this share of its length is one."""

_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


class Contacts(NamedTuple):
    """Where two curves meet."""

    places: FloatArray
    """Parameters of both, shape (k, 2)."""
    touching: BoolArray
    """Whether they touch, or else cross, shape (k,)."""
    stretches: FloatArray
    """Pieces on which they are the same: u from and to, then v, shape (j, 4)."""


def sort_out(
    first: BSpline,
    second: BSpline,
    candidates: Candidates,
    tolerance: float,
    *,
    itself: bool = False,
) -> Contacts:
    """Give each meeting once.

    Args:
        first: A curve.
        second: Another, or the same.
        candidates: What is left of pairs of their pieces.
        tolerance: How far places that count as one may be apart.
        itself: Whether both are the same curve, of which one piece does not meet itself.
    """
    count = len(candidates.places)
    pad = _pads(first, second, candidates.places, tolerance)
    at = candidates.places
    boxes = np.concatenate(
        (np.stack((at[:, 0], at[:, 0], at[:, 1], at[:, 1]), axis=1) + pad, candidates.cells)
    )
    places: list[FloatArray] = []
    touching: list[bool] = []
    stretches: list[FloatArray] = []
    for group in _groups(boxes):
        cells, own = group[group >= count], group[group < count]
        if cells.size:
            box = boxes[cells]
            run = _Run((first, second), box, tolerance, itself=itself)
            if not own.size and run.gap > tolerance:
                continue
            if run.flat:
                stretches.append(run.stretch())
                continue
            if not own.size:
                places.append(run.touch())
                touching.append(True)
                continue
        for some in _groups(boxes[own]):
            which = own[some]
            gaps = np.linalg.norm(first.at(at[which, 0]) - second.at(at[which, 1]), axis=1)
            places.append(at[which[int(np.argmin(gaps))]])
            touching.append(False)
    return Contacts(
        np.array(places).reshape(-1, 2),
        np.array(touching, dtype=np.bool),
        np.array(stretches).reshape(-1, 4),
    )


def without_corners(
    curve: BSpline, candidates: Candidates, tolerance: float, *, closed: bool
) -> Candidates:
    """Give what is not merely the neighbourhood of a corner or a cusp of one curve."""
    start, end = curve.domain

    def around(u: float, v: float) -> bool:
        """Tell whether the way over the seam is no longer than rounding."""
        way = np.concatenate((np.linspace(v, end, _SAMPLES), np.linspace(start, u, _SAMPLES)))
        away = np.linalg.norm(curve.at(way) - curve.at(u), axis=1)
        return closed and bool(away.max() <= _NEIGHBOURS * tolerance)

    def apart(box: FloatArray) -> bool:
        near, far = _extremes(curve, box, tolerance)
        return not (_turns_back(curve, *far, tolerance) or around(*near))

    places = [place for place in candidates.places if apart(place[[0, 0, 1, 1]])]
    cells = [box for box in candidates.cells if apart(box)]
    return Candidates(np.array(places).reshape(-1, 2), np.array(cells).reshape(-1, 4))


def _extremes(
    curve: BSpline, box: FloatArray, tolerance: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Give parameters of two pieces where they are near: those closest together, and farthest."""
    u, v = (np.unique(np.linspace(low, high, 9)) for low, high in (box[:2], box[2:]))
    apart = np.linalg.norm(curve.at(u)[:, None] - curve.at(v), axis=2)
    i, j = np.nonzero(apart <= apart.min() + tolerance)
    way = v[j] - u[i]
    first, last = int(np.argmin(way)), int(np.argmax(way))
    return (float(u[i[first]]), float(v[j[first]])), (float(u[i[last]]), float(v[j[last]]))


def _turns_back(curve: BSpline, u: float, v: float, tolerance: float) -> bool:
    """Tell whether a curve, from u to v, does nothing but go to a corner or cusp and back."""
    ways = np.union1d(
        np.linspace(u, v, 8 * _SAMPLES), curve.breaks[(curve.breaks > u) & (curve.breaks < v)]
    )
    places = curve.at(ways)
    away = np.linalg.norm(places - places[0], axis=1)
    far, turn = float(away.max()), int(np.argmax(away))
    if far <= _NEIGHBOURS * tolerance:
        return True
    # a curve that goes back all along its way is more than a corner
    size = float(np.ptp(curve.points, axis=0).max())
    if turn in (0, len(ways) - 1) or far > 10.0 * np.sqrt(tolerance * size):
        return False
    there, back = places[: turn + 1 : 8], places[turn:]
    width = np.linalg.norm(there[:, None] - back, axis=2).min(axis=1).max()
    if width > _WIDE * far:
        return False
    edge = float(ways[turn])
    if not (curve.breaks == edge).any():
        edge = _farthest(curve, places[0], float(ways[turn - 1]), float(ways[turn + 1]))
    legs = [(u, edge), (edge, v)]
    tip = curve.at(edge)
    if np.linalg.norm(places[0] - tip) > np.linalg.norm(places[-1] - tip):
        legs.reverse()
    near = Projection(curve.part(*legs[1])).nearest(curve.at(np.linspace(*legs[0], _SAMPLES)))
    return bool(near.distance.max() <= 4.0 * tolerance)


def _farthest(curve: BSpline, place: FloatArray, low: float, high: float) -> float:
    """Give the parameter between two at which a curve is farthest from a place."""
    for _ in range(60):
        inner = np.array([high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)])
        first, second = np.linalg.norm(curve.at(inner) - place, axis=1)
        low, high = (low, float(inner[1])) if first >= second else (float(inner[0]), high)
    return 0.5 * (low + high)


def once(
    first: BSpline, second: BSpline, found: Contacts, tolerance: float, *, itself: bool
) -> Contacts:
    """Give places at the seam of a closed curve at its start, and each place once."""
    places = found.places.copy()
    for i, curve in enumerate((first, second)):
        start, end = curve.domain
        if curve.is_closed():
            places[end - places[:, i] <= 1e-9 * (end - start), i] = start
    if itself:
        places.sort(axis=1)
    pads = _pads(first, second, places, tolerance)
    boxes = np.stack((places[:, 0], places[:, 0], places[:, 1], places[:, 1]), axis=1) + pads
    gaps = np.linalg.norm(first.at(places[:, 0]) - second.at(places[:, 1]), axis=1)
    # a crossing says more than a touch at the same place
    kept = [
        group[int(np.lexsort((gaps[group], found.touching[group]))[0])] for group in _groups(boxes)
    ]
    chosen = np.array(kept, dtype=np.intp)
    return Contacts(places[chosen], found.touching[chosen], found.stretches)


def on_stretches(
    first: BSpline, second: BSpline, places: FloatArray, stretches: FloatArray
) -> BoolArray:
    """Tell which places lie on stretches, or where these end."""
    inside = np.zeros(len(places), dtype=np.bool)
    # the seam of a closed curve is at both ends of its parameters
    for i, curve in enumerate((first, second)):
        if curve.is_closed() and len(places):
            mirrored = places.copy()
            ends = np.isin(places[:, i], curve.domain)
            mirrored[ends, i] = sum(curve.domain) - places[ends, i]
            inside |= _on(first, second, mirrored, stretches)
    return inside | _on(first, second, places, stretches)


def _on(first: BSpline, second: BSpline, places: FloatArray, stretches: FloatArray) -> BoolArray:
    inside = np.zeros(len(places), dtype=np.bool)
    room_u, room_v = (_MOST_SAME * (c.domain[1] - c.domain[0]) for c in (first, second))
    for low, high, start, end in stretches:
        u, v = places.T
        near_u = (u >= low - room_u) & (u <= high + room_u)
        near_v = (v >= min(start, end) - room_v) & (v <= max(start, end) + room_v)
        # beyond the ends of one only what is next to the same end of the other
        near_v &= (u > low) | (np.abs(v - start) <= room_v)
        near_v &= (u < high) | (np.abs(v - end) <= room_v)
        inside |= near_u & near_v
    return inside


class _Run:
    """A stretch of the first curve along which the second one is near."""

    def __init__(
        self,
        curves: tuple[BSpline, BSpline],
        boxes: FloatArray,
        tolerance: float,
        *,
        itself: bool,
    ) -> None:
        self.first, self.second = curves
        self.tolerance = tolerance
        self.low, self.high = float(boxes[:, 0].min()), float(boxes[:, 1].max())
        low, high = float(boxes[:, 2].min()), float(boxes[:, 3].max())
        self.domain, (start, end) = self.first.domain, self.second.domain
        more = max(high - low, _LEAST * (end - start))
        if itself:
            # each half of the curve knows the other one only
            start = 0.5 * (self.high + low)
            self.domain = self.domain[0], start
        self.near = Projection(self.second.part(max(start, low - more), min(end, high + more)))
        evenly = np.linspace(self.low, self.high, _SAMPLES)
        places = self.first.at(evenly)
        moves = float(np.ptp(places, axis=0).max()) > _NEIGHBOURS * tolerance
        inner = self.near.nearest(places).distance[4:-4]
        even = inner.max() <= tolerance and np.ptp(inner) <= _FLAT * tolerance
        self.flat = moves and bool(even)
        """Whether the gap is the same nearly all along."""
        self.u = np.unique(np.concatenate((evenly, boxes[:, :2].ravel())))
        self.gaps = self.near.nearest(self.first.at(self.u)).distance
        self.gap = float(self.gaps.min())

    def _gap(self, u: float) -> float:
        return float(self.near.nearest(self.first.at(u)).distance)

    def touch(self) -> FloatArray:
        """Give the parameters of both where they are nearest."""
        best = int(np.argmin(self.gaps))
        low, high = self.u[max(best - 1, 0)], self.u[min(best + 1, len(self.u) - 1)]
        inner = [high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)]
        found = [self._gap(u) for u in inner]
        for _ in range(60):
            if found[0] <= found[1]:
                high, inner[1], found[1] = inner[1], inner[0], found[0]
                inner[0] = high - _GOLDEN * (high - low)
                found[0] = self._gap(inner[0])
            else:
                low, inner[0], found[0] = inner[0], inner[1], found[1]
                inner[1] = low + _GOLDEN * (high - low)
                found[1] = self._gap(inner[1])
        tries = [float(self.u[best]), 0.5 * (low + high), *self.domain]
        inside = [u for u in tries if self.low <= u <= self.high]
        u = min(inside, key=self._gap)
        return self._parallel(u, float(self.near.nearest(self.first.at(u)).u))

    def _parallel(self, u: float, v: float) -> FloatArray:
        """Give the place nearby where both have one direction, if there is one, else this."""
        place = np.array([u, v])
        if self.first.dim != 2:
            return place
        at, limits = place.copy(), np.array([(self.low, self.high), self.near.curve.domain]).T
        for _ in range(8):
            p, da, dda = self.first.jet(at[0], 2)
            q, db, ddb = self.second.jet(at[1], 2)
            gap = q - p
            wanted = np.array([da[0] * db[1] - da[1] * db[0], gap @ da])
            slope = np.array(
                [
                    [dda[0] * db[1] - dda[1] * db[0], da[0] * ddb[1] - da[1] * ddb[0]],
                    [gap @ dda - da @ da, db @ da],
                ]
            )
            try:
                at = np.clip(at - np.linalg.solve(slope, wanted), *limits)
            except np.linalg.LinAlgError:
                return place
        apart = float(np.linalg.norm(self.first.at(at[0]) - self.second.at(at[1])))
        return at if apart <= self.gap + 1e-3 * self.tolerance else place

    def stretch(self) -> FloatArray:
        """Give where the stretch begins and ends on both curves."""
        more, domain = 0.2 * (self.high - self.low), self.domain
        ends = []
        for end, inside, outside in (
            (domain[0], self.low + more, self.low - more),
            (domain[1], self.high - more, self.high + more),
        ):
            beyond = max(domain[0], min(domain[1], outside))
            if self._gap(beyond) <= self.tolerance:
                ends.append(beyond if beyond != end else end)
                continue
            near, far = inside, beyond
            for _ in range(50):
                middle = 0.5 * (near + far)
                if self._gap(middle) <= self.tolerance:
                    near = middle
                else:
                    far = middle
            ends.append(near)
        v = self.near.nearest(self.first.at(np.array(ends))).u
        return np.array([ends[0], ends[1], v[0], v[1]])


def _pads(first: BSpline, second: BSpline, places: FloatArray, tolerance: float) -> FloatArray:
    """Give by how much boxes around places reach beyond them, shape (k, 4)."""
    if not len(places):
        return np.empty((0, 4))
    slopes = [c.at(places[:, i], 1) for i, c in enumerate((first, second))]
    speed = [np.maximum(np.linalg.norm(x, axis=1), 1e-300) for x in slopes]
    cosine = (slopes[0] * slopes[1]).sum(axis=1) / (speed[0] * speed[1])
    sine = np.sqrt(np.maximum(1.0 - cosine**2, 1e-16))
    room = []
    for curve, v in zip((first, second), speed, strict=True):
        most = _MOST_SAME * (curve.domain[1] - curve.domain[0])
        room.append(np.minimum(4.0 * tolerance / (v * sine), most))
    return np.stack((-room[0], room[0], -room[1], room[1]), axis=1)


def _groups(boxes: FloatArray) -> list[IndexArray]:
    """Give the numbers of boxes that touch one another, directly or through others."""
    owner = list(range(len(boxes)))

    def root(i: int) -> int:
        while owner[i] != i:
            owner[i] = owner[owner[i]]
            i = owner[i]
        return i

    active: list[int] = []
    for i in np.argsort(boxes[:, 0], kind="stable").tolist():
        low, _, start, end = boxes[i]
        active = [j for j in active if boxes[j, 1] >= low]
        for j in active:
            if boxes[j, 2] <= end and start <= boxes[j, 3]:
                owner[root(j)] = root(i)
        active.append(i)
    roots = np.array([root(i) for i in range(len(boxes))], dtype=np.intp)
    return [np.flatnonzero(roots == r) for r in np.unique(roots)]
