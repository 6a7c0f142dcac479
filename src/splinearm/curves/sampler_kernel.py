"""Curves sampled from their polynomials, on bare arrays.

A curve comes as one array ``table``, shape (k + 1, width), so that a call passes few arguments.
Row i < k holds a piece: its start, the parameter around which its polynomial is written, the
piece at which the search for parameters in the i-th of k even shares of the domain begins, then
the coefficients of falling powers, each with ``columns`` numbers. Row k holds the end of the
domain, shares per parameter, the last piece, ``columns``, the degree and 1 if the last column is a
weight.
"""

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel

HEAD = 3
"""Numbers in a row before the coefficients."""

FOOT = 6
"""Numbers in the last row."""

OUTSIDE = 1
MISFIT = 2


@fast_kernel
def piece_of(table: FloatArray, u: float) -> int:
    """Give the piece in which a parameter of the domain lies."""
    k = table.shape[0] - 1
    share = int((u - table[0, 0]) * table[k, 1])
    share = min(max(share, 0), k - 1)
    low, high = int(table[share, 2]), int(table[share + 1, 2]) + 1
    while high - low > 1:
        middle = (low + high) >> 1
        if u >= table[middle, 0]:
            low = middle
        else:
            high = middle
    return low


@fast_kernel
def fill_three(table: FloatArray, piece: int, u: float, out: FloatArray) -> None:
    """Write position, velocity and acceleration on a piece into ``out``, shape (3, dim)."""
    k = table.shape[0] - 1
    columns, degree = int(table[k, 3]), int(table[k, 4])
    row = table[piece]
    x = u - row[1]
    if table[k, 5] == 0.0:
        for j in range(columns):
            a, b, c = row[HEAD + j], 0.0, 0.0
            for i in range(1, degree + 1):
                c = c * x + b
                b = b * x + a
                a = a * x + row[HEAD + i * columns + j]
            out[0, j] = a
            out[1, j] = b
            out[2, j] = 2.0 * c
        return
    last = HEAD + columns - 1
    w, w1, w2 = row[last], 0.0, 0.0
    for i in range(1, degree + 1):
        w2 = w2 * x + w1
        w1 = w1 * x + w
        w = w * x + row[last + i * columns]
    w = 1.0 / w
    for j in range(columns - 1):
        a, b, c = row[HEAD + j], 0.0, 0.0
        for i in range(1, degree + 1):
            c = c * x + b
            b = b * x + a
            a = a * x + row[HEAD + i * columns + j]
        # c and w2 are halves of second derivatives, for which Leibniz' rule has no binomials
        # (Piegl and Tiller, The NURBS Book, 2nd ed. 1997, eq. 4.8)
        a *= w
        b = (b - w1 * a) * w
        out[0, j] = a
        out[1, j] = b
        out[2, j] = 2.0 * (c - w1 * b - w2 * a) * w


@fast_kernel
def fill(table: FloatArray, piece: int, u: float, out: FloatArray) -> None:
    """Write position and derivatives on a piece into ``out``, shape (order + 1, dim)."""
    k = table.shape[0] - 1
    columns, degree = int(table[k, 3]), int(table[k, 4])
    rational = table[k, 5] != 0.0
    row = table[piece]
    x = u - row[1]
    rows = out.shape[0]
    powers = np.empty(rows)
    w = np.zeros(rows)
    for j in range(columns - 1, -1, -1):
        powers[:] = 0.0
        for i in range(degree + 1):
            for r in range(rows - 1, 0, -1):
                powers[r] = powers[r] * x + powers[r - 1]
            powers[0] = powers[0] * x + row[HEAD + i * columns + j]
        # powers[r] is the r-th derivative over r!
        if rational and j == columns - 1:
            for r in range(rows):
                w[r] = powers[r]
            continue
        factorial = 1.0
        for r in range(rows):
            if rational:
                for i in range(1, r + 1):
                    powers[r] -= w[i] * powers[r - i]
                powers[r] /= w[0]
            factorial *= max(r, 1)
            out[r, j] = powers[r] * factorial


@fast_kernel
def sample_one(table: FloatArray, u: float, out: FloatArray) -> int:
    """Write position and derivatives at one parameter into ``out``, shape (order + 1, dim).

    Returns:
        0, or what was wrong (OUTSIDE, MISFIT): then nothing was written.
    """
    k = table.shape[0] - 1
    if not (table[0, 0] <= u <= table[k, 0]):
        return OUTSIDE
    if out.shape[1] != int(table[k, 3]) - int(table[k, 5]) or out.shape[0] == 0:
        return MISFIT
    if out.shape[0] == 3:
        fill_three(table, piece_of(table, u), u, out)
    else:
        fill(table, piece_of(table, u), u, out)
    return 0


@fast_kernel
def sample_many(table: FloatArray, us: FloatArray, out: FloatArray) -> int:
    """Write position and derivatives at many parameters into ``out``, (m, order + 1, dim).

    Returns:
        -1, or the first parameter outside the domain: then nothing behind it was written.
    """
    k = table.shape[0] - 1
    start, end = table[0, 0], table[k, 0]
    piece, three = 0, out.shape[1] == 3
    low, high = table[0, 0], table[1, 0]
    for m in range(us.shape[0]):
        u = us[m]
        # neighbours often lie in the same piece
        if not (low <= u < high):
            if not (start <= u <= end):
                return m
            piece = piece_of(table, u)
            low, high = table[piece, 0], table[piece + 1, 0]
        if three:
            fill_three(table, piece, u, out[m])
        else:
            fill(table, piece, u, out[m])
    return -1


@fast_kernel
def sample_pieces(table: FloatArray, pieces: FloatArray, us: FloatArray, out: FloatArray) -> int:
    """Do as ``sample_many`` does, each parameter on its own piece, wherever it lies."""
    k = table.shape[0] - 1
    for m in range(us.shape[0]):
        if not (0.0 <= pieces[m] < k):
            return m
        if out.shape[1] == 3:
            fill_three(table, int(pieces[m]), us[m], out[m])
        else:
            fill(table, int(pieces[m]), us[m], out[m])
    return -1
