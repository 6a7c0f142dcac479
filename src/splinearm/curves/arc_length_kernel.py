"""Arc length as polynomials on cells, and their inverse: the numbers of the map.

A cell is a part of a Bezier piece on which both the length by the parameter and the parameter by
the length are polynomials to rounding. Both are kept by powers of x in [-1, 1].
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel, kernel

NODES = 20
"""Numbers of a polynomial of a cell."""

_NEWTON = 8
_CLOSE = 1e-8
"""How near Newton's last step has to be, of a cell."""

_LOCAL = 1e-12
_WHOLE = 1e-13
"""How large the last three of a cell's numbers may be, of the cell and of the whole curve: what is
left out is smaller than they by orders of magnitude."""

_SPECK = 1e-16
"""What is lost in rounding: smaller cells are taken for even, smaller errors for none."""

_DEEPEST = 100


@fast_kernel
def speeds(V: FloatArray, W: FloatArray, t: FloatArray, out: FloatArray, work: FloatArray) -> None:
    """Put |V(t)| / W(t)^2 at each t in (0, 1) into out.

    Args:
        V: Bernstein coefficients times their binomials, shape (m + 1, dim).
        W: The same of the weight, shape (p + 1,); one of them means 1.
        t: Parameters, shape (n,).
        out: Out, shape (n,).
        work: Room for numbers in between, shape (3, n).
    """
    # nested multiplication by t / (1 - t): Farin, Curves and Surfaces for CAGD, 5th ed. 2002,
    # sec. 4.9; all t side by side, as the processor likes it
    n, m, dim, p = t.shape[0], V.shape[0] - 1, V.shape[1], W.shape[0] - 1
    ratio, value, scale = work[0], work[1], work[2]
    for j in range(n):
        ratio[j] = t[j] / (1.0 - t[j])
        out[j] = 0.0
        scale[j] = 1.0
    for d in range(dim):
        for j in range(n):
            value[j] = V[m, d]
        for i in range(m - 1, -1, -1):
            at = V[i, d]
            for j in range(n):
                value[j] = value[j] * ratio[j] + at
        for j in range(n):
            out[j] += value[j] * value[j]
    for _ in range(m):
        for j in range(n):
            scale[j] *= 1.0 - t[j]
    for j in range(n):
        out[j] = math.sqrt(out[j]) * scale[j]
    if p > 0:
        for j in range(n):
            value[j], scale[j] = W[p], 1.0
        for i in range(p - 1, -1, -1):
            for j in range(n):
                value[j] = value[j] * ratio[j] + W[i]
        for _ in range(p):
            for j in range(n):
                scale[j] *= 1.0 - t[j]
        for j in range(n):
            weight = value[j] * scale[j]
            out[j] /= weight * weight


@fast_kernel
def transform(M: FloatArray, x: FloatArray, out: FloatArray) -> None:
    """Put the product of x and M, whose rows belong to the entries of x, into out."""
    m = M.shape[1]
    for i in range(m):
        out[i] = 0.0
    for k in range(M.shape[0]):
        at = x[k]
        for i in range(m):
            out[i] += at * M[k, i]


@fast_kernel
def invert(S: FloatArray, top: float, nodes: FloatArray, x: FloatArray, work: FloatArray) -> bool:
    """Put the places where a polynomial is (1 + node) / 2 of its top into x; tell whether it went.

    Args:
        S: The powers of a polynomial that rises from 0 at -1 to its top at 1, shape (m,).
        top: Its top.
        nodes: Nodes in (-1, 1), shape (n,).
        x: Out, shape (n,).
        work: Room for numbers in between, shape (3, n).
    """
    n, m = nodes.shape[0], S.shape[0]
    value, slope = work[0], work[1]
    for j in range(n):
        x[j] = nodes[j]
    for _ in range(_NEWTON):
        for j in range(n):
            value[j], slope[j] = S[m - 1], 0.0
        for k in range(m - 2, -1, -1):
            at = S[k]
            for j in range(n):
                slope[j] = slope[j] * x[j] + value[j]
                value[j] = value[j] * x[j] + at
        worst = 0.0
        for j in range(n):
            step = (0.5 * (1.0 + nodes[j]) * top - value[j]) / slope[j]
            x[j] = min(max(x[j] + step, -1.0), 1.0)
            worst = max(worst, abs(step))
        # the next step would be of the order of the square of this one
        if worst < _CLOSE:
            return True
    return False


@kernel
def build(
    ends: FloatArray,
    V: FloatArray,
    W: FloatArray,
    nodes: FloatArray,
    M: FloatArray,
    I: FloatArray,
    P: FloatArray,
    edges: FloatArray,
    by_u: FloatArray,
    by_s: FloatArray,
) -> int:
    """Fill the cells of a curve; give their number, -1 where there is no room for them.

    Args:
        ends: Parameters where pieces begin and end, shape (k + 1,).
        V: Coefficients of their velocities times the square of the weight, by t in [0, 1],
            as ``speed`` takes them, shape (k, m + 1, dim).
        W: Those of their weights, shape (k, p + 1); a single 1 for polynomial pieces.
        nodes: Chebyshev's nodes, falling, shape (n,).
        M: Values at the nodes to Chebyshev coefficients, a row a node, shape (n, n).
        I: Those to powers of x of the integral from -1, shape (n, n + 1).
        P: Those to powers of x, shape (n, n).
        edges: Out: parameter and length where a cell begins, shape (room + 1, 2).
        by_u: Out: the length within the cell by x, shape (room, n + 1).
        by_s: Out: the parameter by x of the length, shape (room, n + 1).
    """
    n, k = nodes.shape[0], V.shape[0]
    y, c, t, work = np.empty(n), np.empty(n), np.empty(n), np.empty((3, n))
    stack = np.empty((_DEEPEST + 1, 2))
    total = 0.0
    for i in range(k):
        for j in range(n):
            t[j] = 0.5 + 0.5 * nodes[j]
        speeds(V[i], W[i], t, y, work)
        for j in range(n):
            total += y[j] / n
    if not 0.0 < total < math.inf:
        return 0
    count, length = 0, 0.0
    for i in range(k):
        h = ends[i + 1] - ends[i]
        stack[0, 0], stack[0, 1], depth = 0.0, 1.0, 1
        while depth:
            if count == edges.shape[0] - 1:
                return -1
            t0, t1 = stack[depth - 1, 0], stack[depth - 1, 1]
            middle, half = 0.5 * (t0 + t1), 0.5 * (t1 - t0)
            for j in range(n):
                t[j] = middle + half * nodes[j]
            speeds(V[i], W[i], t, y, work)
            transform(M, y, c)
            top = 2.0 * half * c[0]
            # a cell shorter than rounding is even
            last = top <= _SPECK * total or depth == _DEEPEST
            tail = half * (abs(c[n - 1]) + abs(c[n - 2]) + abs(c[n - 3]))
            fits = tail <= min(_LOCAL * top, _WHOLE * total) + _SPECK * total
            if fits and not last:
                transform(I, c, by_u[count])
                top = 0.0
                for j in range(n + 1):
                    by_u[count, j] *= half
                    top += by_u[count, j]
                fits = invert(by_u[count], top, nodes, y, work)
                transform(M, y, c)
                tail = (abs(c[n - 1]) + abs(c[n - 2]) + abs(c[n - 3])) * top
                fits = fits and tail <= min(_LOCAL * top, _WHOLE * total) + _SPECK * total
            if not fits and not last:
                stack[depth - 1, 0], stack[depth - 1, 1] = middle, t1
                stack[depth, 0], stack[depth, 1] = t0, middle
                depth += 1
                continue
            depth -= 1
            edges[count, 0], edges[count, 1] = ends[i] + t0 * h, length
            by_s[count, n] = 0.0
            if last:
                by_u[count], c[:] = 0.0, 0.0
                by_u[count, 0], by_u[count, 1], c[1] = 0.5 * top, 0.5 * top, 1.0
            transform(P, c, by_s[count, :n])
            by_s[count, 0] += 1.0
            for j in range(n):
                by_s[count, j] *= half * h
            length += top
            count += 1
    edges[count, 0], edges[count, 1] = ends[k], length
    return count


@fast_kernel
def look_up(
    x: FloatArray,
    edges: FloatArray,
    guide: FloatArray,
    table: FloatArray,
    slack: float,
    out: FloatArray,
) -> int:
    """Put what a table of cells says at each x into out; give the first x outside, else -1.

    Args:
        x: Where, shape (m,).
        edges: Where cells begin, x and y, the last where all end; rising, shape (k + 1, 2).
        guide: The cell at even steps of x, shape (g,).
        table: Powers of a cell's own x in [-1, 1], an odd number n, counted from the y of its
            edge, shape (k, n).
        slack: How far outside x may be and count as the end.
        out: Out, shape (m,).
    """
    k, n = table.shape
    first, last = edges[0, 0], edges[k, 0]
    low, high = edges[0, 1], edges[k, 1]
    per = guide.shape[0] / (last - first)
    for i in range(x.shape[0]):
        if not (first - slack <= x[i] <= last + slack):
            return i
        at = min(max(x[i], first), last)
        cell = int(guide[min(int((at - first) * per), guide.shape[0] - 1)])
        while cell + 1 < k and edges[cell + 1, 0] <= at:
            cell += 1
        # beyond it by rounding, or on cells without length at the end
        while cell > 0 and (edges[cell, 0] > at or edges[cell, 0] == edges[cell + 1, 0]):
            cell -= 1
        start = edges[cell, 0]
        if at == start:
            out[i] = edges[cell, 1]
            continue
        if at == last:
            out[i] = edges[cell + 1, 1]
            continue
        z = 2.0 * (at - start) / (edges[cell + 1, 0] - start) - 1.0
        row = table[cell]
        # two chains of z^2, which the processor runs side by side
        square = z * z
        even, odd = row[n - 1], row[n - 2]
        for j in range(n - 3, 1, -2):
            even = even * square + row[j]
            odd = odd * square + row[j - 1]
        value = edges[cell, 1] + (even * square + row[0] + odd * z)
        out[i] = min(max(value, low), high)
    return -1
