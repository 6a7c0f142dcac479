"""Eigenvalues and small linear systems, written out: kernels do without a library for them."""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

_EPS = 2.220446049250313e-16
_MOST = 60


@kernel
def triangulate(A: FloatArray, Q: FloatArray, order: FloatArray) -> None:
    """Bring ``A`` (m, n) to triangular form by reflections, columns with the most left first.

    ``A`` becomes R (its lower part is zero), ``Q`` (m, m) the product of the reflections, so that
    Q^T A with its columns in ``order`` is R. P. Businger and G. Golub, 1965.
    """
    m, n = A.shape
    for i in range(m):
        for j in range(m):
            Q[i, j] = 1.0 if i == j else 0.0
    for j in range(n):
        order[j] = j
    for k in range(min(m - 1, n)):
        _best_first(A, order, k)
        length = 0.0
        for i in range(k, m):
            length += A[i, k] * A[i, k]
        length = math.sqrt(length)
        if length == 0.0:
            continue
        if A[k, k] > 0.0:
            length = -length
        v0 = A[k, k] - length
        beta = -1.0 / (length * v0)
        A[k, k] = v0
        for j in range(k + 1, n):
            total = 0.0
            for i in range(k, m):
                total += A[i, k] * A[i, j]
            total *= beta
            for i in range(k, m):
                A[i, j] -= total * A[i, k]
        for r in range(m):
            total = 0.0
            for i in range(k, m):
                total += Q[r, i] * A[i, k]
            total *= beta
            for i in range(k, m):
                Q[r, i] -= total * A[i, k]
        A[k, k] = length
        for i in range(k + 1, m):
            A[i, k] = 0.0


@kernel
def _best_first(A: FloatArray, order: FloatArray, k: int) -> None:
    """Swap the column with the most left below row k to place k."""
    m, n = A.shape
    best, most = k, -1.0
    for j in range(k, n):
        total = 0.0
        for i in range(k, m):
            total += A[i, j] * A[i, j]
        if total > most * (1.0 + 1e-9):
            best, most = j, total
    if best != k:
        for i in range(m):
            A[i, k], A[i, best] = A[i, best], A[i, k]
        order[k], order[best] = order[best], order[k]


@kernel
def eliminate(A: FloatArray, B: FloatArray) -> float:
    """Solve A X = B in place of ``B``; give the smallest pivot over the largest.

    Rows are swapped for the largest pivot; ``A`` is spent.
    """
    n, m = B.shape
    low, high = math.inf, 0.0
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(A[i, k]) > abs(A[best, k]):
                best = i
        pivot = A[best, k]
        low, high = min(low, abs(pivot)), max(high, abs(pivot))
        if pivot == 0.0:
            return 0.0
        if best != k:
            for j in range(n):
                A[k, j], A[best, j] = A[best, j], A[k, j]
            for j in range(m):
                B[k, j], B[best, j] = B[best, j], B[k, j]
        for i in range(k + 1, n):
            share = A[i, k] / pivot
            if share != 0.0:
                for j in range(k + 1, n):
                    A[i, j] -= share * A[k, j]
                for j in range(m):
                    B[i, j] -= share * B[k, j]
    for k in range(n - 1, -1, -1):
        for j in range(m):
            B[k, j] /= A[k, k]
        for i in range(k):
            share = A[i, k]
            for j in range(m):
                B[i, j] -= share * B[k, j]
    return low / high


@kernel
def _hessenberg(A: FloatArray) -> None:
    """Bring ``A`` to Hessenberg form by elimination; R. Martin and J. Wilkinson, 1968."""
    n = len(A)
    for m in range(1, n - 1):
        best = m
        for i in range(m + 1, n):
            if abs(A[i, m - 1]) > abs(A[best, m - 1]):
                best = i
        x = A[best, m - 1]
        if best != m:
            for j in range(m - 1, n):
                A[m, j], A[best, j] = A[best, j], A[m, j]
            for i in range(n):
                A[i, m], A[i, best] = A[i, best], A[i, m]
        if x == 0.0:
            continue
        for i in range(m + 1, n):
            share = A[i, m - 1] / x
            A[i, m - 1] = 0.0
            if share != 0.0:
                for j in range(m, n):
                    A[i, j] -= share * A[m, j]
                for r in range(n):
                    A[r, m] += share * A[r, i]


@kernel
def eigenvalues(A: FloatArray, real: FloatArray, imaginary: FloatArray) -> bool:
    """Give the eigenvalues of a square matrix, which is spent; say whether all were found.

    By double steps of the QR algorithm: R. Martin, G. Peters and J. Wilkinson, The QR algorithm
    for real Hessenberg matrices, Numerische Mathematik 14, 1970.
    """
    _hessenberg(A)
    n = len(A)
    norm = 0.0
    for i in range(n):
        for j in range(max(i - 1, 0), n):
            norm += abs(A[i, j])
    for i in range(n):
        real[i], imaginary[i] = np.nan, np.nan
    high, shift, tries = n - 1, 0.0, 0
    while high >= 0:
        low = high
        while low > 0:
            size = abs(A[low - 1, low - 1]) + abs(A[low, low])
            if abs(A[low, low - 1]) <= _EPS * (size if size > 0.0 else norm):
                A[low, low - 1] = 0.0
                break
            low -= 1
        x = A[high, high]
        if low == high:
            real[high], imaginary[high] = x + shift, 0.0
            high, tries = high - 1, 0
            continue
        y, w = A[high - 1, high - 1], A[high, high - 1] * A[high - 1, high]
        if low == high - 1:
            _pair(x, y, w, shift, high, real, imaginary)
            high, tries = high - 2, 0
            continue
        if tries == _MOST:
            return False
        if tries in (10, 20, 40):
            shift += x
            for i in range(high + 1):
                A[i, i] -= x
            size = abs(A[high, high - 1]) + abs(A[high - 1, high - 2])
            x, y, w = 0.75 * size, 0.75 * size, -0.4375 * size * size
        tries += 1
        _double_step(A, low, high, x, y, w)
    return True


@kernel
def _pair(
    x: float,
    y: float,
    w: float,
    shift: float,
    high: int,
    real: FloatArray,
    imaginary: FloatArray,
) -> None:
    """Give the two eigenvalues of the last block, which ends at row ``high``."""
    p = 0.5 * (y - x)
    q = p * p + w
    z = math.sqrt(abs(q))
    x += shift
    if q >= 0.0:
        z = p + (z if p >= 0.0 else -z)
        real[high - 1] = x + z
        real[high] = x - w / z if z != 0.0 else x + z
        imaginary[high - 1], imaginary[high] = 0.0, 0.0
    else:
        real[high - 1], real[high] = x + p, x + p
        imaginary[high - 1], imaginary[high] = -z, z


@kernel
def _double_step(A: FloatArray, low: int, high: int, x: float, y: float, w: float) -> None:
    """Do one double step of the QR algorithm on rows and columns ``low`` to ``high``."""
    p, q, r = 0.0, 0.0, 0.0
    m = high - 2
    while True:
        z = A[m, m]
        r, s = x - z, y - z
        p = (r * s - w) / A[m + 1, m] + A[m, m + 1]
        q = A[m + 1, m + 1] - z - r - s
        r = A[m + 2, m + 1]
        s = abs(p) + abs(q) + abs(r)
        p, q, r = p / s, q / s, r / s
        if m == low:
            break
        u = abs(A[m, m - 1]) * (abs(q) + abs(r))
        v = abs(p) * (abs(A[m - 1, m - 1]) + abs(z) + abs(A[m + 1, m + 1]))
        if u <= _EPS * v:
            break
        m -= 1
    for i in range(m + 2, high + 1):
        A[i, i - 2] = 0.0
        if i > m + 2:
            A[i, i - 3] = 0.0
    for k in range(m, high):
        last = k == high - 1
        if k > m:
            p, q = A[k, k - 1], A[k + 1, k - 1]
            r = 0.0 if last else A[k + 2, k - 1]
            x = abs(p) + abs(q) + abs(r)
            if x == 0.0:
                continue
            p, q, r = p / x, q / x, r / x
        s = math.sqrt(p * p + q * q + r * r)
        if p < 0.0:
            s = -s
        if s == 0.0:
            continue
        if k > m:
            A[k, k - 1] = -s * x
        elif low != m:
            A[k, k - 1] = -A[k, k - 1]
        p += s
        x, y, z = p / s, q / s, r / s
        q, r = q / p, r / p
        for j in range(k, high + 1):
            t = A[k, j] + q * A[k + 1, j]
            if not last:
                t += r * A[k + 2, j]
                A[k + 2, j] -= t * z
            A[k + 1, j] -= t * y
            A[k, j] -= t * x
        for i in range(low, min(high, k + 3) + 1):
            t = x * A[i, k] + y * A[i, k + 1]
            if not last:
                t += z * A[i, k + 2]
                A[i, k + 2] -= t * r
            A[i, k + 1] -= t * q
            A[i, k] -= t
