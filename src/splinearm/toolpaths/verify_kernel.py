"""Distances between the ways of a tool and a part, by formulas that made neither, compiled.

A piece here is a row ``ax ay bx by k tx ty turn``: where it begins and ends, its curvature (above 0
to the left), the unit tangent where it begins, and how far it turns, a quarter at most. Of a piece
that is a point the tangent is 0. Places on arcs are made from the angle and the chord,
``a + 2 sin(v / 2) / k`` along the tangent turned by ``v / 2``, so that no centre far away costs
digits; and of two pieces the least distance is at an end of either, or where both have one normal,
which lies along ``k1 k2 (a1 - a2) + k2 n1 - k1 n2``, a way from centre to centre that stays finite.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel

RUN = 8
ANGLES = 32


@fast_kernel
def _gap(Q: FloatArray, i: int, x: float, y: float) -> float:
    """Give how far a point is from a piece."""
    k, tx, ty = Q[i, 4], Q[i, 5], Q[i, 6]
    px, py = x - Q[i, 0], y - Q[i, 1]
    qx, qy = x - Q[i, 2], y - Q[i, 3]
    co, si = math.cos(Q[i, 7]), math.sin(Q[i, 7])
    ux, uy = co * tx - si * ty, si * tx + co * ty
    # within the wedge of both normals it is nearest to the inside of the piece
    if px * tx + py * ty > 0.0 and qx * ux + qy * uy < 0.0:
        left = px * -ty + py * tx
        if k == 0.0:
            inside: float = abs(left)
            return inside
        # |p - c| - r from its squares, which leaves out the radius
        power = k * (px * px + py * py) - 2.0 * left
        far = math.sqrt((k * px + ty) ** 2 + (k * py - tx) ** 2)
        away: float = abs(power / (1.0 + far))
        return away
    end: float = math.sqrt(min(px * px + py * py, qx * qx + qy * qy))
    return end


@fast_kernel
def _foot(Q: FloatArray, i: int, x: float, y: float) -> tuple[float, float]:
    """Give the place of a piece that is nearest to a point."""
    k, tx, ty = Q[i, 4], Q[i, 5], Q[i, 6]
    px, py = x - Q[i, 0], y - Q[i, 1]
    qx, qy = x - Q[i, 2], y - Q[i, 3]
    co, si = math.cos(Q[i, 7]), math.sin(Q[i, 7])
    ux, uy = co * tx - si * ty, si * tx + co * ty
    if px * tx + py * ty > 0.0 and qx * ux + qy * uy < 0.0:
        vx, vy = k * px + ty, k * py - tx
        far = math.sqrt(vx * vx + vy * vy)
        if far > 0.0:
            off = (k * (px * px + py * py) + 2.0 * (px * ty - py * tx)) / (1.0 + far)
            return x - off * vx / far, y - off * vy / far
    if px * px + py * py <= qx * qx + qy * qy:
        return Q[i, 0], Q[i, 1]
    return Q[i, 2], Q[i, 3]


@fast_kernel
def _at(Q: FloatArray, i: int, angle: float) -> tuple[float, float]:
    """Give the place on an arc behind a turn from its start."""
    grown = 2.0 * math.sin(0.5 * angle) / Q[i, 4]
    co, si = math.cos(0.5 * angle), math.sin(0.5 * angle)
    tx, ty = Q[i, 5], Q[i, 6]
    return Q[i, 0] + grown * (co * tx - si * ty), Q[i, 1] + grown * (si * tx + co * ty)


@fast_kernel
def _least(W: FloatArray, w: int, Q: FloatArray, i: int, best: float) -> tuple[float, float, float]:
    """Give the least distance of two pieces if it is below a bound, and a place of it."""
    bx, by = 0.0, 0.0
    for end in range(2):
        far = _gap(Q, i, W[w, 2 * end], W[w, 2 * end + 1])
        if far < best:
            best, bx, by = far, W[w, 2 * end], W[w, 2 * end + 1]
        far = _gap(W, w, Q[i, 2 * end], Q[i, 2 * end + 1])
        if far < best:
            best, bx, by = far, Q[i, 2 * end], Q[i, 2 * end + 1]
    A, a, B, b = W, w, Q, i
    if abs(W[w, 4]) < abs(Q[i, 4]):
        A, a, B, b = Q, i, W, w
    k, m = A[a, 4], B[b, 4]
    if k == 0.0:
        return best, bx, by
    nx = k * m * (A[a, 0] - B[b, 0]) - m * A[a, 6] + k * B[b, 6]
    ny = k * m * (A[a, 1] - B[b, 1]) + m * A[a, 5] - k * B[b, 5]
    if nx == 0.0 and ny == 0.0:
        return best, bx, by
    tx, ty, turn = A[a, 5], A[a, 6], A[a, 7]
    for side in (-1.0, 1.0):
        # the tangent there is at right angles to the way between both centres
        ex, ey = -side * ny, side * nx
        angle = math.atan2(tx * ey - ty * ex, tx * ex + ty * ey)
        if 0.0 < angle < turn or turn < angle < 0.0:
            x, y = _at(A, a, angle)
            far = _gap(B, b, x, y)
            if far < best:
                best, bx, by = far, x, y
    return best, bx, by


@fast_kernel
def boxes(Q: FloatArray, size: int) -> FloatArray:
    """Give boxes about runs of so many pieces: least x and y, largest x and y."""
    count = (Q.shape[0] + size - 1) // size
    B = np.empty((count, 4))
    for b in range(count):
        B[b, 0], B[b, 1], B[b, 2], B[b, 3] = math.inf, math.inf, -math.inf, -math.inf
        for i in range(b * size, min(Q.shape[0], b * size + size)):
            # an arc up to a quarter turn is as high over its chord as a fifth of it
            h = 0.2072 * math.hypot(Q[i, 2] - Q[i, 0], Q[i, 3] - Q[i, 1])
            h = 0.0 if Q[i, 4] == 0.0 else h
            B[b, 0] = min(B[b, 0], Q[i, 0] - h, Q[i, 2] - h)
            B[b, 1] = min(B[b, 1], Q[i, 1] - h, Q[i, 3] - h)
            B[b, 2] = max(B[b, 2], Q[i, 0] + h, Q[i, 2] + h)
            B[b, 3] = max(B[b, 3], Q[i, 1] + h, Q[i, 3] + h)
    return B


@fast_kernel
def _between(B: FloatArray, b: int, C: FloatArray, c: int) -> float:
    """Give the square of how far two boxes are apart."""
    dx = max(B[b, 0] - C[c, 2], 0.0, C[c, 0] - B[b, 2])
    dy = max(B[b, 1] - C[c, 3], 0.0, C[c, 1] - B[b, 3])
    apart: float = dx * dx + dy * dy
    return apart


@fast_kernel
def clearances(W: FloatArray, reaches: FloatArray, Q: FloatArray, found: FloatArray) -> None:
    """Write how near ways come to a part, and to which place of it, if nearer than their reaches.

    Args:
        W: Pieces of the ways.
        reaches: How near each may come, shape (m,).
        Q: Pieces of the part.
        found: The least distance and its place, shape (m, 3); infinite if not below the reach.
    """
    fine, single, coarse = boxes(Q, RUN), boxes(W, 1), boxes(Q, RUN * RUN)
    n = Q.shape[0]
    for w in range(W.shape[0]):
        best, bx, by = reaches[w], 0.0, 0.0
        hit = False
        for c in range(coarse.shape[0]):
            if _between(coarse, c, single, w) >= best * best:
                continue
            for f in range(c * RUN, min(fine.shape[0], c * RUN + RUN)):
                if _between(fine, f, single, w) >= best * best:
                    continue
                for i in range(f * RUN, min(n, f * RUN + RUN)):
                    near, x, y = _least(W, w, Q, i, best)
                    if near < best:
                        best, hit = near, True
                        bx, by = _foot(Q, i, x, y)
        found[w, 0], found[w, 1], found[w, 2] = best if hit else math.inf, bx, by


@fast_kernel
def gaps(Q: FloatArray, points: FloatArray, enough: float, found: FloatArray) -> None:
    """Write how far points are from the nearest piece; ``enough``: near enough to look no more."""
    fine, coarse = boxes(Q, RUN), boxes(Q, RUN * RUN)
    n = Q.shape[0]
    spot = np.empty((1, 4))
    start = 0
    for p in range(points.shape[0]):
        x, y = points[p, 0], points[p, 1]
        spot[0, 0], spot[0, 1], spot[0, 2], spot[0, 3] = x, y, x, y
        best, begin = math.inf, start
        # neighbours in the list are neighbours in the plane: begin where the last one ended
        for j in range(coarse.shape[0]):
            c = (begin + j) % coarse.shape[0]
            if best <= enough:
                break
            if _between(coarse, c, spot, 0) >= best * best:
                continue
            for f in range(c * RUN, min(fine.shape[0], c * RUN + RUN)):
                if _between(fine, f, spot, 0) < best * best:
                    for i in range(f * RUN, min(n, f * RUN + RUN)):
                        far = _gap(Q, i, x, y)
                        if far < best:
                            best, start = far, c
        found[p] = best


@fast_kernel
def insides(Q: FloatArray, points: FloatArray, found: FloatArray) -> None:
    """Write 1 for points that closed pieces go around an odd number of times, else 0."""
    for p in range(points.shape[0]):
        x, y = points[p, 0], points[p, 1]
        odd = False
        for i in range(Q.shape[0]):
            ax, ay, bx, by = Q[i, 0], Q[i, 1], Q[i, 2], Q[i, 3]
            if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
                odd = not odd
            k = Q[i, 4]
            if k != 0.0:
                # between the chord and the arc it is once more inside or outside
                px, py = x - ax, y - ay
                side = (bx - ax) * py - (by - ay) * px
                left = px * -Q[i, 6] + py * Q[i, 5]
                if side * k < 0.0 and k * (k * (px * px + py * py) - 2.0 * left) < 0.0:
                    odd = not odd
        found[p] = 1.0 if odd else 0.0


@fast_kernel
def frees(
    E: FloatArray, starts: FloatArray, outside: FloatArray, points: FloatArray, found: FloatArray
) -> None:
    """Write 1 for points that are free, else 0.

    Args:
        E: Pieces of several closed outlines.
        starts: The first piece of each outline, and how many pieces there are.
        outside: 1 for outlines of which the outside is free, 0 for those of which the inside is.
        points: The points.
        found: What was found, shape (m,).
    """
    spot, odd = np.empty((1, 2)), np.empty(1)
    for p in range(points.shape[0]):
        spot[0, 0], spot[0, 1] = points[p, 0], points[p, 1]
        found[p] = 0.0
        for z in range(outside.shape[0]):
            insides(E[int(starts[z]) : int(starts[z + 1])], spot, odd)
            if odd[0] != outside[z]:
                found[p] = 1.0
                break


@fast_kernel
def rooms(
    Q: FloatArray,
    E: FloatArray,
    starts: FloatArray,
    outside: FloatArray,
    points: FloatArray,
    radius: float,
    found: FloatArray,
) -> None:
    """Write how much room a disc has that covers a point: the clearance of its best free centre.

    Centres are sought on circles of one and of half a radius about each point, and the best one
    is bettered by halving the angle. What is found is there; more might be.

    Args:
        Q: Pieces of the edge of what is free.
        E: What is free: see `frees`.
        starts: See `frees`.
        outside: See `frees`.
        points: The points.
        radius: Radius of the disc.
        found: The clearances, shape (m,).
    """
    spot, far = np.empty((1, 2)), np.empty(1)
    for p in range(points.shape[0]):
        best, at, out, step = 0.0, 0.0, 0.0, math.pi / ANGLES
        k = 0
        better = False
        while best < radius:
            # first the place itself and two circles about it, then beside the best of them
            reach, angle = 0.0, 0.0
            if 0 < k <= 2 * ANGLES:
                reach = radius if k > ANGLES else 0.5 * radius
                angle = 2.0 * math.pi * k / ANGLES
            elif k > 2 * ANGLES:
                if k % 2 == 1:
                    if k > 2 * ANGLES + 1 and not better:
                        step *= 0.5
                    better = False
                if step < 1e-6 or out == 0.0:
                    break
                reach, angle = out, at + (step if k % 2 else -step)
            k += 1
            spot[0, 0] = points[p, 0] + reach * math.cos(angle)
            spot[0, 1] = points[p, 1] + reach * math.sin(angle)
            gaps(Q, spot, best, far)
            room = far[0]
            if room > best:
                frees(E, starts, outside, spot, far)
                if far[0] == 1.0:
                    best, at, out, better = room, angle, reach, True
        found[p] = best
