"""What curves are proven to be as far from others as they should, and as near, compiled.

Curves are segments as in ``spline_jet_kernel``; what is proven is so by ``spline_bound_kernel``.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel

from .spline_bound_kernel import (
    BEYOND,
    along,
    coefficients,
    discs_of,
    feet,
    foot_of,
    is_beyond,
    nodes_of,
    part_of,
    sizes,
    tail,
)
from .spline_jet_kernel import jet, nearest_place

_BOXES = 400_000
"""So many boxes of parts that are not far apart are looked at and no more."""
_LARGE = 0.1
"""Boxes of larger parts, of curves of about 1, are halved without a closer look."""
_LOOKS = 32
"""Places of a segment from which the nearest is sought, where few did not do."""
_PROBES = 6
"""Places beside a segment at which it is looked whether the offset is there."""


@fast_kernel
def _kept(
    c: FloatArray,
    r: FloatArray,
    d: float,
    degrees: tuple[int, int],
    nodes: tuple[FloatArray, FloatArray],
    room: tuple[FloatArray, FloatArray],
) -> int:
    """Say whether it is proven along the feet that a box keeps the distance: 0, or what to halve.

    That is 1 for t, where the feet are not well followed, and 2 for what is longer.
    """
    f, g = room
    u = foot_of(c, r, 0.0, 0.0, d)
    inside = abs(u) <= BEYOND
    at = u if inside else math.copysign(1.0, u)
    reach = 1.0 + abs(at)
    value, _, bend, third = coefficients(c, r, 0.0, at, d)
    rest = tail(c, r, d, reach + 0.25)
    # what is not so in the middle need not be looked for elsewhere
    if value <= 0.0 or (inside and bend <= abs(third) * reach + rest):
        return 2
    if inside and feet(c, r, d, f) <= BEYOND:
        along(c, r, f, d, degrees[0], nodes[0], g)
        reach = 1.0 + abs(f[0]) + abs(f[1]) + abs(f[2]) + abs(f[3])
        bent = g[2, 0] - max(-g[3, 0], g[3, 1]) * reach - tail(c, r, d, reach)
        slope = max(-g[1, 0], g[1, 1])
        if bent > 0.0 and 4.0 * g[0, 0] * bent >= slope * slope:
            return 0
        return 1 if bent > 0.0 else 2
    if abs(u) <= 1.0:
        return 1 if inside else 2
    # all of it is nearest to one end of the part, or nearly so
    side = math.copysign(1.0, u)
    f[0], f[1], f[2], f[3] = side, 0.0, 0.0, 0.0
    along(c, r, f, d, degrees[1], nodes[1], g)
    bent = g[2, 0] - 2.0 * max(-g[3, 0], g[3, 1]) - rest
    # towards the other end G changes by this times the way, or more
    rise = -g[1, 1] if side > 0.0 else g[1, 0]
    if rise >= 0.0:
        return 0 if g[0, 0] >= 0.0 and rise >= -2.0 * bent else 2
    return 0 if bent > 0.0 and 4.0 * g[0, 0] * bent >= rise * rise else 2


@fast_kernel
def first_nearer(
    R: FloatArray, S: FloatArray, d: float, degrees: tuple[int, int]
) -> tuple[int, int, float, float, int]:
    """Give the first place of curves that is not proven to be as far as d from others; or -1.

    Args:
        R: Segments of the curves.
        S: Segments of the others.
        d: The distance.
        degrees: Of G along a cubic, and along a number u.

    Returns:
        Segments of both and t and u there, and how many boxes it took.
    """
    nodes = nodes_of(degrees[0]), nodes_of(degrees[1])
    c, r = np.empty((R.shape[1], 3)), np.empty((S.shape[1], 3))
    stack, work = np.empty((512, 4)), (np.empty(4), np.empty((4, 2)))
    ours, theirs = discs_of(R), discs_of(S)
    boxes = 0
    for i in range(R.shape[0]):
        for k in range(S.shape[0]):
            if is_beyond(theirs, k, ours[i, 0], ours[i, 1], d + ours[i, 2]):
                continue
            top = 1
            stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3] = -1.0, 1.0, -1.0, 1.0
            while top:
                top -= 1
                boxes += 1
                t0, t1, u0, u1 = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
                part_of(R, i, t0, t1, c)
                part_of(S, k, u0, u1, r)
                # seen from the middle of the first
                x, y = c[0, 0] / c[0, 2], c[0, 1] / c[0, 2]
                for j in range(c.shape[0]):
                    c[j, 0] -= x * c[j, 2]
                    c[j, 1] -= y * c[j, 2]
                for j in range(r.shape[0]):
                    r[j, 0] -= x * r[j, 2]
                    r[j, 1] -= y * r[j, 2]
                cp, cw = sizes(c)
                rp, rw = sizes(r)
                W, w = c[0, 2], r[0, 2]
                away = math.sqrt(r[0, 0] * r[0, 0] + r[0, 1] * r[0, 1])
                room = cp * (w + rw) + rp * (W + cw) + away * cw
                if away * W - room >= d * (w + rw) * (W + cw):
                    continue
                halve = _kept(c, r, d, degrees, nodes, work) if cp + rp < _LARGE else 2
                if halve == 0:
                    continue
                if top + 2 > stack.shape[0] or boxes > _BOXES or max(cp, rp) < 1e-13:
                    return i, k, 0.5 * (t0 + t1), 0.5 * (u0 + u1), boxes
                for part in range(2):
                    a = stack[top]
                    a[0], a[1], a[2], a[3] = t0, t1, u0, u1
                    if halve == 1 or cp * w > rp * W:
                        a[1 - part] = 0.5 * (t0 + t1)
                    else:
                        a[3 - part] = 0.5 * (u0 + u1)
                    top += 1
    return -1, -1, 0.0, 0.0, boxes


@fast_kernel
def first_farther(
    R: FloatArray, S: FloatArray, d: float, degrees: tuple[int, int]
) -> tuple[int, float]:
    """Give the first place of curves that is not proven to be as near as d to others; or -1.

    Args:
        R: Segments of the curves.
        S: Segments of the others.
        d: The distance.
        degrees: Of G along a cubic, and along a number u.

    Returns:
        The segment, and t there.
    """
    nodes = nodes_of(degrees[0])
    c, r, f = np.empty((R.shape[1], 3)), np.empty((S.shape[1], 3)), np.empty(4)
    stack, discs = np.empty((128, 2)), discs_of(S)
    k = 0
    for i in range(R.shape[0]):
        top = 1
        stack[0, 0], stack[0, 1] = -1.0, 1.0
        while top:
            top -= 1
            t0, t1 = stack[top, 0], stack[top, 1]
            part_of(R, i, t0, t1, c)
            x, y = c[0, 0] / c[0, 2], c[0, 1] / c[0, 2]
            U, away = nearest_place(S, k, k + 1.0, x, y, 4)
            if away > d:
                U, away, k = _nearest(S, discs, (U, away, k), x, y)
            if away > d:
                return i, 0.5 * (t0 + t1)
            part_of(S, k, -1.0, 1.0, r)
            if _reached(c, r, 2.0 * (U - k) - 1.0, d, degrees[0], nodes, f):
                continue
            # what is nearest was sought in few places
            U, away, k = _nearest(S, discs, (U, away, k), x, y)
            part_of(S, k, -1.0, 1.0, r)
            if _reached(c, r, 2.0 * (U - k) - 1.0, d, degrees[0], nodes, f):
                continue
            if t1 - t0 < 1e-9:
                return i, 0.5 * (t0 + t1)
            middle = 0.5 * (t0 + t1)
            stack[top, 0], stack[top, 1] = t0, middle
            stack[top + 1, 0], stack[top + 1, 1] = middle, t1
            top += 2
    return -1, 0.0


@fast_kernel
def _nearest(
    S: FloatArray, discs: FloatArray, known: tuple[float, float, int], x: float, y: float
) -> tuple[float, float, int]:
    """Give the place of all segments that is nearest to a point, how far it is, and the segment.

    Args:
        S: Segments.
        discs: In which they lie.
        known: The same of a place that is known already.
        x: The point's
        y: coordinates.
    """
    U, away, k = known
    for j in range(S.shape[0]):
        if not is_beyond(discs, j, x, y, away):
            V, near = nearest_place(S, j, j + 1.0, x, y, _LOOKS)
            if near < away:
                U, away, k = V, near, j
    return U, away, k


@fast_kernel
def _reached(
    c: FloatArray, r: FloatArray, u: float, d: float, degree: int, nodes: FloatArray, f: FloatArray
) -> bool:
    """Say whether it is proven that a part is within a distance of a segment, about u."""
    g = np.empty((4, 2))
    if abs(u) < 1.0 - 1e-12 and feet(c, r, d, f) < 3.0:
        reach = max(1.0, _farthest(f) * (1.0 + 1e-15))
        for k in range(4):
            f[k] /= reach
        along(c, r, f, d, degree, nodes, g)
        if g[0, 1] <= 0.0:
            return True
    f[0], f[1], f[2], f[3] = u, 0.0, 0.0, 0.0
    along(c, r, f, d, degree, nodes, g)
    return bool(g[0, 1] <= 0.0)


@fast_kernel
def _farthest(f: FloatArray) -> float:
    """Give how far from 0 a cubic goes between -1 and 1."""
    most = float(max(abs(f[0] + f[1] + f[2] + f[3]), abs(f[0] - f[1] + f[2] - f[3])))
    a, b, q = 3.0 * f[3], f[2], f[1]
    root = b * b - a * q
    if root > 0.0:
        for sign in (-1.0, 1.0):
            over = b + sign * math.sqrt(root)
            if over != 0.0:
                t = -q / over
                if abs(t) < 1.0:
                    most = max(most, abs(((f[3] * t + f[2]) * t + f[1]) * t + f[0]))
    return most


@fast_kernel
def first_missing(
    R: FloatArray, S: FloatArray, d: float, tolerance: float
) -> tuple[int, float, float]:
    """Give the first segment beside which the offset to the left is not among curves, and where.

    Args:
        R: Segments of the curves.
        S: Segments of what was offset.
        d: How far they are from it.
        tolerance: And how much farther they may be.
    """
    D = d + tolerance
    ours, theirs = discs_of(R), discs_of(S)
    for k in range(S.shape[0]):
        for look in range(_PROBES):
            s = -1.0 + (2.0 * look + 1.0) / _PROBES
            x, y, dx, dy, _, _ = jet(S, k, s)
            v = math.sqrt(dx * dx + dy * dy)
            x, y = x - D * dy / v, y + D * dx / v
            free = True
            for looks in (4, _LOOKS):
                for j in range(S.shape[0]):
                    if is_beyond(theirs, j, x, y, D):
                        continue
                    _, away = nearest_place(S, j, j + 1.0, x, y, looks)
                    free = free and away >= D * (1.0 - 1e-12)
                    if not free:
                        break
            if not free:
                continue
            there = False
            for i in range(R.shape[0]):
                if is_beyond(ours, i, x, y, 2.0 * tolerance):
                    continue
                _, away = nearest_place(R, i, i + 1.0, x, y, 4)
                if away <= 2.0 * tolerance:
                    there = True
                    break
            if not there:
                return k, x, y
    return -1, 0.0, 0.0
