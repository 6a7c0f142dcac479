"""Stretches of contours by the length along them."""

from math import atan2, cos, hypot, sin, tan

import numpy as np

from splinearm.arrays import FloatArray

from .contour import Contour

_CORNER = 1e-9
"""A place nearer to a corner than this share of its segment is the corner."""
_SAME = 1e-12
"""Share of a contour's length below which two places on it are one."""


def stretch(contour: Contour, begin: float, end: float) -> Contour:
    """Give the open contour from one place of another to a later one.

    Args:
        contour: An open or a closed contour.
        begin: How far along it the stretch begins, m; of a closed one any number.
        end: Where it ends, above ``begin``; of a closed one it may go around more than once.

    Raises:
        ValueError: If the stretch has no length or leaves an open contour.
    """
    lengths = contour.lengths
    whole = float(lengths.sum())
    tiny = _SAME * whole
    if not end - begin > tiny:
        raise ValueError(f"stretch: want an end behind its begin, got {begin} to {end} m")
    if not contour.closed and not (begin >= -tiny and end <= whole + tiny):
        raise ValueError(f"stretch: want it within 0 to {whole} m, got {begin} to {end} m")
    marks = np.concatenate(([0.0], np.cumsum(lengths)))
    starts, ends, bulges = contour.starts, contour.ends, contour.bulges
    corners: list[FloatArray] = []
    closing = starts[0]
    kept: list[float] = []
    at, last = begin, end
    turns = int(np.floor(begin / whole)) if contour.closed else 0
    i = _segment(marks, begin - turns * whole)
    while True:
        shift = turns * whole + marks[i]
        size = float(lengths[i])
        if size > tiny:
            first = min(1.0, max(0.0, (at - shift) / size))
            final = min(1.0, (last - shift) / size)
            if (final - first) * size > tiny:
                corners.append(place_at(starts[i], ends[i], bulges[i], first))
                kept.append(_part(bulges[i], final - first))
                closing = place_at(starts[i], ends[i], bulges[i], final)
        at = shift + size
        if at >= last - tiny:
            break
        i += 1
        if i == len(bulges):
            i, turns = 0, turns + 1
    return Contour.made(np.array([*corners, closing]), np.array(kept), closed=False)


def begun_at(contour: Contour, begin: float) -> Contour:
    """Give the closed contour begun elsewhere, as an open one that ends where it begins."""
    lengths = contour.lengths
    marks = np.concatenate(([0.0], np.cumsum(lengths)))
    begin %= marks[-1]
    i = _segment(marks, begin)
    return _begun(contour, i, (begin - float(marks[i])) / float(lengths[i]))


def begun_on(contour: Contour, segment: int, place: FloatArray) -> Contour:
    """Give the closed contour begun at a place of one of its segments, as an open one."""
    start, end = contour.vertices[segment], contour.vertices[(segment + 1) % len(contour.vertices)]
    return _begun(contour, segment, _share(start, end, float(contour.bulges[segment]), place))


def _begun(contour: Contour, i: int, share: float) -> Contour:
    vertices, bulges = contour.vertices, contour.bulges
    n = len(bulges)
    if share <= _CORNER or share >= 1.0 - _CORNER:
        first = i if share <= _CORNER else (i + 1) % n
        order = np.arange(first, first + n + 1) % n
        return Contour.made(vertices[order], bulges[order[:-1]], closed=False)
    bulge = float(bulges[i])
    place = place_at(vertices[i], vertices[(i + 1) % n], bulge, share)
    order = np.arange(i, i + n + 1) % n
    corners = np.empty((n + 2, 2))
    corners[0] = corners[-1] = place
    corners[1:-1] = vertices[order[1:]]
    kept = np.empty(n + 1)
    kept[0], kept[-1] = _part(bulge, 1.0 - share), _part(bulge, share)
    kept[1:-1] = bulges[order[1:-1]]
    return Contour.made(corners, kept, closed=False)


def opened(contour: Contour) -> Contour:
    """Give a closed contour as an open one that ends where it begins; an open one as it is."""
    if not contour.closed:
        return contour
    vertices = np.concatenate((contour.vertices, contour.vertices[:1]))
    return Contour.made(vertices, np.array(contour.bulges), closed=False)


def there_and_back(contour: Contour) -> Contour:
    """Give the closed contour along an open one and back."""
    vertices = np.concatenate((contour.vertices, contour.vertices[-2:0:-1]))
    return Contour.made(vertices, np.concatenate((contour.bulges, -contour.bulges[::-1])))


def amid_longest(contour: Contour) -> FloatArray:
    """Give the middle of a contour's longest line or arc, shape (2,): where it touches least."""
    i = int(contour.lengths.argmax())
    return place_at(contour.starts[i], contour.ends[i], float(contour.bulges[i]), 0.5)


def place_on(contour: Contour, along: float) -> tuple[FloatArray, FloatArray]:
    """Give a place on a contour and the direction there, shapes (2,), by how far along it is, m."""
    marks = np.concatenate(([0.0], np.cumsum(contour.lengths)))
    if contour.closed:
        along %= marks[-1]
    i = _segment(marks, along)
    size = marks[i + 1] - marks[i]
    share = min(1.0, max(0.0, (along - marks[i]) / size))
    start, end, bulge = contour.starts[i], contour.ends[i], float(contour.bulges[i])
    place = place_at(start, end, bulge, share)
    return place, direction_at(start, end, bulge, share)


def along_of(contour: Contour, segment: int, place: FloatArray) -> float:
    """Give how far along a contour a place on one of its segments is, m."""
    lengths = contour.lengths
    share = _share(
        contour.starts[segment], contour.ends[segment], float(contour.bulges[segment]), place
    )
    return float(lengths[:segment].sum() + share * lengths[segment])


def _share(start: FloatArray, end: FloatArray, bulge: float, place: FloatArray) -> float:
    """Give the share of a segment at one of its places."""
    a, b = hypot(*(place - start)), hypot(*(end - place))
    if a == 0.0 or bulge == 0.0:
        return a / (a + b) if a else 0.0
    # both parts of the half turn see chords that are as their sines
    half = 2.0 * atan2(bulge, 1.0)
    return atan2(a * sin(half), b + a * cos(half)) / half


def nearest_along(contour: Contour, place: FloatArray) -> float:
    """Give how far along a contour its place is that is nearest to another, m."""
    from .order_kernel import nearest_loop

    P, segment = contour.packed()
    found = np.empty(5)
    nearest_loop(P, np.array([0.0, len(P)]), np.ones(1), float(place[0]), float(place[1]), found)
    return along_of(contour, int(segment[int(found[2])]), found[3:5])


def place_at(start: FloatArray, end: FloatArray, bulge: float, share: float) -> FloatArray:
    """Give the place at a share of a segment, shape (2,)."""
    if share <= 0.0 or share >= 1.0:
        return start if share <= 0.0 else end
    half = 2.0 * atan2(bulge, 1.0)
    grown = share if half == 0.0 else sin(share * half) / sin(half)
    return start + grown * _turned(end - start, (share - 1.0) * half)


def direction_at(start: FloatArray, end: FloatArray, bulge: float, share: float) -> FloatArray:
    """Give the direction at a share of a segment, of length 1, shape (2,)."""
    half = 2.0 * atan2(bulge, 1.0)
    way = end - start
    return _turned(way / hypot(*way), (2.0 * share - 1.0) * half)


def _segment(marks: FloatArray, along: float) -> int:
    i = int(np.searchsorted(marks, along, side="right")) - 1
    return min(max(i, 0), len(marks) - 2)


def _part(bulge: float, share: float) -> float:
    return float(bulge) if share == 1.0 else tan(share * atan2(bulge, 1.0))


def _turned(way: FloatArray, angle: float) -> FloatArray:
    c, s = cos(angle), sin(angle)
    return np.array([c * way[0] - s * way[1], s * way[0] + c * way[1]])
