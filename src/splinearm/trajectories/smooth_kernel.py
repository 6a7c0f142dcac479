"""The quickest speed profile within acceleration and jerk limits, by an interior point method.

x(s), the square of ds/dt, is a quadratic B-spline with one cell between neighbouring nodes, so
that d2s/dt2 = x'/2 is continuous, and linear on each cell. On a cell of length h the three numbers
y = (x, h x'/2, h^2 x''/2) at its left end say everything; at a share z of it, x is y (1, 2z, z^2).
They depend on three neighbouring coefficients, so that Newton's matrix has two diagonals beside the
main one whatever is asked of cells, and a step takes linear time.

Asked is |g y| <= r of every row g. For accelerations r is a number. Jerks are sqrt(x) (g y), so
that r / sqrt(x) bounds g y: convex in x, so its tangent lies below it and is safe. It is drawn anew
at each of Newton's steps. Torques may ask for p y + w sqrt(x) <= r at a place within the cell: the
tangent of the root, which lies above it, is safe if w is above zero. Accelerations of the tool ask
for the squares of two such rows to be 1 together at most.
"""

from math import inf, sqrt

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .smooth_band_kernel import factor, hold, local_maps, states, substitute
from .smooth_slack_kernel import fill_constant, measure

_GAUSS = 0.5 / sqrt(3.0)

_STAY = 0.99
"""Share of the way to the nearest bound that a step may take."""

_LACK = 1e-9
"""So much of its bound a row may miss in the end."""

_RESIDUAL = 1e-4
"""By so much of the time may Newton's equations be missed in the end."""

_NEAR_GAP, _NEAR_LACK = 1e-3, 1e-5
"""Gap and lack that are still good enough where rounding lets them become no smaller."""

_MOST_STEPS = 100


@kernel
def begin_into(
    h: FloatArray,
    slaves: FloatArray,
    d: FloatArray,
    G: FloatArray,
    R: FloatArray,
    caps: FloatArray,
    T: FloatArray,
    S: FloatArray,
    maps: FloatArray,
    Y: FloatArray,
    V: FloatArray,
) -> None:
    """Write the maps, y of each cell, and what each row leaves of its bound."""
    local_maps(h, slaves[0], slaves[1], maps)
    states(maps, d, Y)
    measure(G, R, caps, T, S, Y, np.empty((V.shape[0], V.shape[1], 3)), V)


@kernel
def _time_terms(
    i: int, h: FloatArray, ends: FloatArray, Y: FloatArray, H: FloatArray, pull: FloatArray
) -> float:
    """Give the time of a cell, with the outer ones that of a launch or landing before or behind it.

    Its second derivatives by y are added to ``H`` (6), its slope is taken off ``pull`` (3).
    """
    time = 0.0
    for j in range(4):
        weight, z = 0.5 * h[i], 0.5 + (_GAUSS if j == 1 else -_GAUSS)
        if j == 2:
            # s = j t^3 / 6 takes the time 3 s / v
            weight, z = (3.0 * ends[0] if i == 0 else 0.0), 0.0
        elif j == 3:
            weight, z = (3.0 * ends[1] if i == h.size - 1 else 0.0), 1.0
        if weight == 0.0:
            continue
        e1, e2 = 2.0 * z, z * z
        x = Y[i, 0] + e1 * Y[i, 1] + e2 * Y[i, 2]
        part = weight / sqrt(x)
        time += part
        slope, bend = 0.5 * part / x, 0.75 * part / (x * x)
        pull[0] += slope
        pull[1] += slope * e1
        pull[2] += slope * e2
        H[0] += bend
        H[1] += bend * e1
        H[2] += bend * e2
        H[3] += bend * e1 * e1
        H[4] += bend * e1 * e2
        H[5] += bend * e2 * e2
    return time


@kernel
def _assemble(
    h: FloatArray,
    ends: FloatArray,
    maps: FloatArray,
    S: FloatArray,
    Y: FloatArray,
    A: FloatArray,
    V: FloatArray,
    W: FloatArray,
    L: FloatArray,
    band: FloatArray,
    out: FloatArray,
) -> None:
    """Write Newton's matrix (rows 0 to 2 of ``band``), its right side (3) and the residual (4).

    ``V`` becomes what slacks lack; ``out`` is time, complementarity and the most that one lacks.
    """
    m, rows = W.shape
    band[:, :] = 0.0
    H, pull, left = np.empty(6), np.empty(3), np.empty(3)
    time, gap, lack = 0.0, 0.0, 0.0
    for i in range(m):
        H[:], pull[:] = 0.0, 0.0
        time += _time_terms(i, h, ends, Y, H, pull)
        left[:] = pull
        h0, h1, h2, h3, h4, h5 = H[0], H[1], H[2], H[3], H[4], H[5]
        b0, b1, b2, g0, g1, g2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(rows):
            w, p, room = W[i, k], L[i, k], V[i, k]
            if room > w:
                # more is left than was promised
                w = room
                W[i, k] = w
            room -= w
            V[i, k] = room
            lack = max(lack, -room)
            gap += p * w
            f = p / w
            a, b, c = A[i, k, 0], A[i, k, 1], A[i, k, 2]
            fa, fb = f * a, f * b
            h0 += fa * a
            h1 += fa * b
            h2 += fa * c
            h3 += fb * b
            h4 += fb * c
            h5 += f * c * c
            t = f * room
            b0 -= t * a
            b1 -= t * b
            b2 -= t * c
            g0 += p * a
            g1 += p * b
            g2 += p * c
        for k in range(S.shape[1]):
            p = L[i, rows - S.shape[1] + k]
            for c in range(0, 6, 3):
                a, b, d = S[i, k, c], S[i, k, c + 1], S[i, k, c + 2]
                h0 += p * a * a
                h1 += p * a * b
                h2 += p * a * d
                h3 += p * b * b
                h4 += p * b * d
                h5 += p * d * d
        for k in range(3):
            m0, m1, m2 = maps[i, 0, k], maps[i, 1, k], maps[i, 2, k]
            p0 = h0 * m0 + h1 * m1 + h2 * m2
            p1 = h1 * m0 + h3 * m1 + h4 * m2
            p2 = h2 * m0 + h4 * m1 + h5 * m2
            for r in range(k + 1):
                band[k - r, i + r] += maps[i, 0, r] * p0 + maps[i, 1, r] * p1 + maps[i, 2, r] * p2
            band[3, i + k] += m0 * (pull[0] + b0) + m1 * (pull[1] + b1) + m2 * (pull[2] + b2)
            band[4, i + k] += m0 * (left[0] + g0) + m1 * (left[1] + g1) + m2 * (left[2] + g2)
    out[0], out[1], out[2] = time, gap, lack


@kernel
def _predict(
    maps: FloatArray,
    A: FloatArray,
    V: FloatArray,
    W: FloatArray,
    L: FloatArray,
    dY: FloatArray,
    C: FloatArray,
    sides: FloatArray,
) -> float:
    """Give the share of complementarity that is left after a step to the very end of all slacks.

    ``C`` becomes the products that such a step leaves over, ``sides`` the two right sides from
    which Newton's own is made once the aim is known.
    """
    m, rows = W.shape
    sides[:, :] = 0.0
    primal, dual = 1.0, 1.0
    gap, first, second, both = 0.0, 0.0, 0.0, 0.0
    for i in range(m):
        u0, u1, u2 = dY[i, 0], dY[i, 1], dY[i, 2]
        a0, a1, a2, c0, c1, c2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(rows):
            w, p = W[i, k], L[i, k]
            a, b, c = A[i, k, 0], A[i, k, 1], A[i, k, 2]
            dw = a * u0 + b * u1 + c * u2 + V[i, k]
            reciprocal = 1.0 / w
            dp = -p - p * reciprocal * dw
            if dw * primal < -w:
                primal = -w / dw
            if dp * dual < -p:
                dual = -p / dp
            gap += p * w
            first += p * dw
            second += w * dp
            product = dw * dp
            both += product
            C[i, k] = product
            t = product * reciprocal
            a0 += reciprocal * a
            a1 += reciprocal * b
            a2 += reciprocal * c
            c0 += t * a
            c1 += t * b
            c2 += t * c
        for k in range(3):
            m0, m1, m2 = maps[i, 0, k], maps[i, 1, k], maps[i, 2, k]
            sides[0, i + k] += m0 * a0 + m1 * a1 + m2 * a2
            sides[1, i + k] += m0 * c0 + m1 * c1 + m2 * c2
    return (gap + primal * first + dual * second + primal * dual * both) / gap


@kernel
def _aim(
    A: FloatArray,
    V: FloatArray,
    W: FloatArray,
    L: FloatArray,
    Y: FloatArray,
    dY: FloatArray,
    C: FloatArray,
    mu: float,
    out: FloatArray,
) -> None:
    """Write how far x and the slacks may go, and how far the multipliers.

    ``V`` becomes the steps of the slacks, ``C`` those of the multipliers.
    """
    m, rows = W.shape
    primal, dual = inf, inf
    for i in range(m):
        u0, u1, u2 = dY[i, 0], dY[i, 1], dY[i, 2]
        for k in range(rows):
            w, p = W[i, k], L[i, k]
            dw = A[i, k, 0] * u0 + A[i, k, 1] * u1 + A[i, k, 2] * u2 + V[i, k]
            dp = (mu - C[i, k] - p * dw) / w - p
            V[i, k], C[i, k] = dw, dp
            if dw * primal < -w:
                primal = -w / dw
            if dp * dual < -p:
                dual = -p / dp
        for j in range(5):
            z = 0.5 * j if j < 3 else 0.5 + (_GAUSS if j == 3 else -_GAUSS)
            e1, e2 = 2.0 * z, z * z
            x = Y[i, 0] + e1 * Y[i, 1] + e2 * Y[i, 2]
            dx = u0 + e1 * u1 + e2 * u2
            if dx * primal < -x:
                primal = -x / dx
    out[0], out[1] = min(1.0, _STAY * primal), min(1.0, _STAY * dual)


@kernel
def improve(
    h: FloatArray,
    ends: FloatArray,
    maps: FloatArray,
    held: FloatArray,
    G: FloatArray,
    R: FloatArray,
    caps: FloatArray,
    T: FloatArray,
    S: FloatArray,
    goal: float,
    d: FloatArray,
    W: FloatArray,
    L: FloatArray,
    Y: FloatArray,
    out: FloatArray,
) -> bool:
    """Bring coefficients ``d`` near the quickest profile; tell whether that succeeded.

    Args:
        h: Lengths of the cells, shape (m,).
        ends: Lengths of the launch before and the landing behind them, 0 where there is none.
        maps: y by the coefficients, shape (m, 3, 3).
        held: 1 for each coefficient that stays as it is, shape (m + 2,).
        G: Rows by y, shape (m, rows, 3): the first half of accelerations, then a quarter of jerks
            at the begin of the cell and one at its end.
        R: Bounds of these three kinds in each cell, shape (m, 3).
        caps: Highest x at the begin, the middle and the end of each cell, shape (m, 3).
        T: Rows by y that are asked one way only, how much of the root of x at which share of the
            cell is added to them, and their bounds: three numbers, factor, bound and share, shape
            (m, k, 6).
        S: Pairs of rows by y whose squares are together at most 1, shape (m, l, 6).
        goal: To which share of the time the distance from the quickest shall shrink.
        d: Coefficients; x must be above zero with them.
        W: Slacks, shape (m, 2 rows + 3 + k + l), above zero.
        L: Multipliers, of the same shape, above zero.
        Y: Becomes y of each cell, shape (m, 3).
        out: Becomes time, its distance from the least, what slacks lack, residual, steps.
    """
    m, rows = W.shape
    n = m + 2
    A, V, C = np.empty((m, rows, 3)), np.empty((m, rows)), np.empty((m, rows))
    dY, step = np.empty((m, 3)), np.empty(n)
    band, sides, far = np.empty((5, n)), np.empty((2, n)), np.empty(2)
    fill_constant(G, caps, A)
    for count in range(_MOST_STEPS):
        states(maps, d, Y)
        measure(G, R, caps, T, S, Y, A, V)
        _assemble(h, ends, maps, S, Y, A, V, W, L, band, out)
        for k in range(n):
            if held[k] == 1.0:
                hold(band, k)
        residual = 0.0
        for k in range(n):
            residual += abs(band[4, k] * d[k])
        time = out[0]
        out[3], out[4] = residual / time, count
        if out[1] <= goal * time and residual <= _RESIDUAL * time and out[2] <= _LACK:
            return True
        if not factor(band[0], band[1], band[2]):
            break
        step[:] = band[3]
        substitute(band[0], band[1], band[2], step)
        states(maps, step, dY)
        share = _predict(maps, A, V, W, L, dY, C, sides)
        mu = out[1] / (m * rows) * max(share, 0.0) ** 3
        for k in range(n):
            step[k] = 0.0 if held[k] == 1.0 else band[3, k] + mu * sides[0, k] - sides[1, k]
        substitute(band[0], band[1], band[2], step)
        states(maps, step, dY)
        _aim(A, V, W, L, Y, dY, C, mu, far)
        for k in range(n):
            d[k] += far[0] * step[k]
        for i in range(m):
            for k in range(rows):
                W[i, k] += far[0] * V[i, k]
                L[i, k] += far[1] * C[i, k]
    return bool(out[1] <= _NEAR_GAP * out[0] and out[2] <= _NEAR_LACK)
