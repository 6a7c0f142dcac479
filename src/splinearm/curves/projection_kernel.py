"""The nearest place of a curve, certified, by branch and bound on its Bezier pieces.

On a piece the squared distance is N / V with N = |A - w p|^2 and V = w^2, both polynomials in
Bernstein form. Where N - d V has no coefficient below 0 no place is nearer than the root of d.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

_DEEPEST = 50
_EQUAL = 1.0 + 1e-14


@kernel
def _square_at(rows: FloatArray, t: float, local: FloatArray) -> float:
    """Give |A / w|^2 at t by de Casteljau."""
    count, columns = rows.shape
    for i in range(count):
        for c in range(columns):
            local[i, c] = rows[i, c]
    for d in range(count - 1, 0, -1):
        for i in range(d):
            for c in range(columns):
                local[i, c] = (1.0 - t) * local[i, c] + t * local[i + 1, c]
    total = 0.0
    for c in range(columns - 1):
        total += local[0, c] * local[0, c]
    w: float = local[0, columns - 1]
    return total / (w * w)


@kernel
def _slope_root(g: FloatArray, local: FloatArray) -> float:
    """Give where a convex polynomial of Bernstein coefficients g is least on [0, 1]."""
    n = g.shape[0] - 1
    if g[1] >= g[0]:
        return 0.0
    if g[n] <= g[n - 1]:
        return 1.0
    low, high = 0.0, 1.0
    t: float = (g[0] - g[1]) / ((g[0] - g[1]) + (g[n] - g[n - 1]))
    for _ in range(80):
        for i in range(n):
            local[i] = g[i + 1] - g[i]
        for d in range(n - 1, 1, -1):
            for i in range(d):
                local[i] = (1.0 - t) * local[i] + t * local[i + 1]
        bend = (n - 1.0) * (local[1] - local[0]) if n > 1 else 0.0
        slope = (1.0 - t) * local[0] + t * local[1] if n > 1 else local[0]
        if slope > 0.0:
            high = t
        else:
            low = t
        following: float = t - slope / bend if bend > 0.0 else 0.5 * (low + high)
        if not low <= following <= high:
            following = 0.5 * (low + high)
        if abs(following - t) <= 1e-16:
            return following
        t = following
    return t


@kernel
def _bounds(rows: FloatArray, factors: FloatArray, best: float, g: FloatArray) -> float:
    """Write the coefficients of N - best V; give the largest of N."""
    count, columns = rows.shape
    largest = 0.0
    for k in range(2 * count - 1):
        n, v = 0.0, 0.0
        for i in range(max(0, k - count + 1), min(k, count - 1) + 1):
            product = 0.0
            for c in range(columns - 1):
                product += rows[i, c] * rows[k - i, c]
            n += factors[i, k - i] * product
            v += factors[i, k - i] * rows[i, columns - 1] * rows[k - i, columns - 1]
        largest = max(largest, abs(n))
        g[k] = n - best * v
    return largest


@kernel
def _search(
    stack: FloatArray, factors: FloatArray, size: float, best: float, found: FloatArray
) -> float:
    """Look for a place of the piece stack[0] that is nearer to the origin than the root of best.

    Writes its parameter into found[0] and gives its squared distance, or best if there is none.
    """
    count, columns = stack.shape[1:]
    degree = count - 1
    g, local = np.empty(2 * degree + 1), np.empty((count, columns))
    line, start, level = np.empty(2 * degree + 1), np.zeros(len(stack)), np.zeros(len(stack))
    top = 0
    while top >= 0:
        rows, width = stack[top], 0.5 ** level[top]
        largest = _bounds(rows, factors, best, g)
        lowest, highest, convex = g[0], g[0], True
        for k in range(1, 2 * degree + 1):
            lowest, highest = min(lowest, g[k]), max(highest, g[k])
            if k < 2 * degree and g[k + 1] - 2.0 * g[k] + g[k - 1] < 0.0:
                convex = False
        hidden = 3.6e-15 * (largest + math.sqrt(largest) * size)
        if lowest >= 0.0 or (highest <= hidden and -lowest <= hidden):
            top -= 1
            continue
        # the smallest ratio of two functions: Dinkelbach, On nonlinear fractional programming,
        # Management Science 13 (1967) 492
        t = _slope_root(g, line) if convex else 0.5
        square = _square_at(rows, t, local)
        better = square < best
        again = better and square < best * (1.0 - 1e-15)
        if better:
            best = square
            found[0] = start[top] + t * width
        if convex:
            if not again:
                top -= 1
            continue
        if level[top] >= _DEEPEST or top + 1 >= len(stack):
            top -= 1
            continue
        # halves: the second takes this place, the first is looked at next
        for i in range(count):
            for c in range(columns):
                local[i, c] = rows[i, c]
        for d in range(degree + 1):
            for c in range(columns):
                stack[top + 1, d, c] = local[0, c]
            for i in range(degree - d):
                for c in range(columns):
                    local[i, c] = 0.5 * (local[i, c] + local[i + 1, c])
        for i in range(count):
            for c in range(columns):
                rows[i, c] = local[i, c]
        level[top] += 1
        level[top + 1] = level[top]
        start[top + 1] = start[top]
        start[top] += 0.5 * width
        top += 1
    return best


@kernel
def _polish(rows: FloatArray, t: float, jet: FloatArray, local: FloatArray) -> float:
    """Give t after steps of Newton towards where the way to the origin is square to the curve."""
    count, columns = rows.shape
    degree = count - 1
    for _ in range(3):
        for order in range(3):
            for i in range(count):
                for c in range(columns):
                    local[i, c] = rows[i, c]
            for d in range(degree, 0, -1):
                for i in range(d):
                    for c in range(columns):
                        if d > degree - order:
                            local[i, c] = d * (local[i + 1, c] - local[i, c])
                        else:
                            local[i, c] = (1.0 - t) * local[i, c] + t * local[i + 1, c]
            for c in range(columns):
                jet[order, c] = local[0, c] if order <= degree else 0.0
        # f = E . (E' w - E w'), with the same sign as the slope of the distance
        w, w1, w2 = jet[0, columns - 1], jet[1, columns - 1], jet[2, columns - 1]
        f, df = 0.0, 0.0
        for c in range(columns - 1):
            e, e1, e2 = jet[0, c], jet[1, c], jet[2, c]
            across = e1 * w - e * w1
            f += e * across
            df += e1 * across + e * (e2 * w - e * w2)
        if not df > 0.0:
            break
        following = t - f / df
        if not (0.0 <= following <= 1.0 and abs(following - t) < 1e-5):
            break
        t = following
    return t


@kernel
def nearest_into(
    pieces: FloatArray,
    ends: FloatArray,
    boxes: FloatArray,
    points: FloatArray,
    factors: FloatArray,
    out: FloatArray,
) -> None:
    """Write parameter, distance and place of what is nearest to each point.

    Args:
        pieces: Homogeneous Bezier points, shape (k, degree + 1, dim + 1).
        ends: Ends of the pieces, shape (k + 1,).
        boxes: Least and largest coordinates of their points, shape (k, 2, dim).
        points: The points, shape (m, dim).
        factors: What coefficients count in a product, shape (degree + 1, degree + 1).
        out: Shape (m, 2 + dim).
    """
    k, count, columns = pieces.shape
    dim = columns - 1
    stack = np.empty((_DEEPEST + 2, count, columns))
    away, found = np.empty(k), np.zeros(1)
    moved, jet, local = (
        np.empty((count, columns)),
        np.empty((3, columns)),
        np.empty((count, columns)),
    )
    for m in range(len(points)):
        best, piece, at, first, size = np.inf, 0, 0.0, 0, 0.0
        for i in range(k):
            total = 0.0
            for c in range(dim):
                gap = max(boxes[i, 0, c] - points[m, c], points[m, c] - boxes[i, 1, c], 0.0)
                total += gap * gap
            away[i] = total
            if total < away[first]:
                first = i
            for e in range(2):
                total, row = 0.0, e * (count - 1)
                for c in range(dim):
                    gap = pieces[i, row, c] / pieces[i, row, dim] - points[m, c]
                    total += gap * gap
                if total < best:
                    best, piece, at = total, i, float(e)
        for c in range(dim):
            size = max(size, abs(points[m, c]))
        for turn in range(-1, k):
            i = first if turn < 0 else turn
            if away[i] >= best or turn == first:
                continue
            largest = size
            for r in range(count):
                w = pieces[i, r, dim]
                for c in range(dim):
                    largest = max(largest, abs(pieces[i, r, c] / w))
                    stack[0, r, c] = pieces[i, r, c] - w * points[m, c]
                stack[0, r, dim] = w
            nearer = _search(stack, factors, largest, best, found)
            if nearer < best:
                best, piece, at = nearer, i, found[0]
        # rounding hides on which side of an end the nearest place is: the slope tells, there and
        # on the piece that begins or ends there
        i, t = piece, at
        for turn in range(2):
            for r in range(count):
                for c in range(dim):
                    moved[r, c] = pieces[i, r, c] - pieces[i, r, dim] * points[m, c]
                moved[r, dim] = pieces[i, r, dim]
            t = _polish(moved, t, jet, local)
            if turn == 0 or (0.0 < t < 1.0 and _square_at(moved, t, local) <= best * _EQUAL):
                piece, at = i, t
            if 0.0 < t < 1.0 or turn == 1:
                break
            i = (piece - 1) % k if t <= 0.0 else (piece + 1) % k
            t = 1.0 - t
        for r in range(count):
            for c in range(dim):
                moved[r, c] = pieces[piece, r, c] - pieces[piece, r, dim] * points[m, c]
            moved[r, dim] = pieces[piece, r, dim]
        width = ends[piece + 1] - ends[piece]
        out[m, 0] = ends[piece + 1] if at >= 1.0 else ends[piece] + at * width
        out[m, 1] = math.sqrt(_square_at(moved, at, local))
        for c in range(dim):
            out[m, 2 + c] = points[m, c] + local[0, c] / local[0, dim]
