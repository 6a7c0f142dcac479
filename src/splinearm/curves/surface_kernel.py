"""Tensor-product surfaces with all their partial derivatives, on bare arrays.

``rows`` are control points, shape (m, n, columns), of rational surfaces homogeneous, with zeros
behind up to a multiple of four columns; degrees follow from the number of knots. ``column`` is that
of the weight, 0 if there is none. Derivatives of one place have the shape (a, b, dim): entry (i, j)
is differentiated i times by u and j times by v. Parameters lie in the domain; at a knot values
come from the right, at the end of the domain from the left.
"""

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel


@fast_kernel
def span_at(knots: FloatArray, degree: int, u: float, hint: int) -> int:
    """Give the k with knots[k] <= u < knots[k + 1]; ``hint`` is looked at first."""
    if knots[hint] <= u < knots[hint + 1]:
        return hint
    low, high = degree, int(knots.shape[0]) - degree - 1
    if u >= knots[high]:
        while knots[high - 1] == knots[high]:
            high -= 1
        return high - 1
    while high - low > 1:
        middle = (low + high) >> 1
        if knots[middle] <= u:
            low = middle
        else:
            high = middle
    return low


@fast_kernel
def basis_rows(
    knots: FloatArray, span: int, u: float, inverse: FloatArray, out: FloatArray
) -> None:
    """Write the basis functions of a span and their derivatives, (orders, degree + 1)."""
    # Cox-de Boor recurrence (Piegl and Tiller, The NURBS Book, 2nd ed. 1997, eq. 2.5 and 2.7):
    # the o-th derivative takes its last o steps as differences
    orders, degree = out.shape[0], out.shape[1] - 1
    for o in range(orders):
        for j in range(degree + 1):
            out[o, j] = 0.0
    out[0, 0] = 1.0
    for d in range(1, degree + 1):
        begins = degree - d + 1
        if begins >= orders:
            carried = 0.0
            for j in range(d):
                low, high = knots[span + 1 - d + j], knots[span + 1 + j]
                share = out[0, j] / (high - low)
                out[0, j] = carried + (high - u) * share
                carried = (u - low) * share
            out[0, d] = carried
            continue
        for j in range(d):
            out[begins, j] = out[0, j]
            inverse[j] = 1.0 / (knots[span + 1 + j] - knots[span + 1 - d + j])
        for o in range(begins, min(orders, degree + 1)):
            carried = 0.0
            for j in range(d):
                share = d * inverse[j] * out[o, j]
                out[o, j] = carried - share
                carried = share
            out[o, d] = carried
        carried = 0.0
        for j in range(d):
            share = inverse[j] * out[0, j]
            out[0, j] = carried + (knots[span + 1 + j] - u) * share
            carried = (u - knots[span + 1 - d + j]) * share
        out[0, d] = carried


@fast_kernel
def contract(basis: FloatArray, rows: FloatArray, i: int, x: int, out: FloatArray) -> None:
    """Write sums of rows[i], rows[i + 1] ... by basis functions, from number x on."""
    # four at a time: what processors add at once
    for o in range(out.shape[0]):
        for y in range(0, out.shape[1], 4):
            t0, t1, t2, t3 = 0.0, 0.0, 0.0, 0.0
            for k in range(basis.shape[1]):
                share = basis[o, k]
                t0 += share * rows[i + k, x + y]
                t1 += share * rows[i + k, x + y + 1]
                t2 += share * rows[i + k, x + y + 2]
                t3 += share * rows[i + k, x + y + 3]
            out[o, y] = t0
            out[o, y + 1] = t1
            out[o, y + 2] = t2
            out[o, y + 3] = t3


@fast_kernel
def finish(
    strip: FloatArray,
    basis: FloatArray,
    first: int,
    binomials: FloatArray,
    jet: FloatArray,
    column: int,
    out: FloatArray,
) -> None:
    """Write the derivatives of one place from what ``contract`` gives, (a, b, dim)."""
    dim, columns = out.shape[2], jet.shape[2]
    for k in range(out.shape[0]):
        for m in range(out.shape[1]):
            for c in range(0, columns, 4):
                t0, t1, t2, t3 = 0.0, 0.0, 0.0, 0.0
                at = first * columns + c
                for j in range(basis.shape[1]):
                    share = basis[m, j]
                    t0 += share * strip[k, at]
                    t1 += share * strip[k, at + 1]
                    t2 += share * strip[k, at + 2]
                    t3 += share * strip[k, at + 3]
                    at += columns
                jet[k, m, c] = t0
                jet[k, m, c + 1] = t1
                jet[k, m, c + 2] = t2
                jet[k, m, c + 3] = t3
            if column == 0:
                for c in range(dim):
                    out[k, m, c] = jet[k, m, c]
    if column == 0:
        return
    # Leibniz' rule for w S = A, solved for the highest derivative of S: Piegl and Tiller, eq. 4.20
    inverse = 1.0 / jet[0, 0, column]
    for k in range(out.shape[0]):
        for m in range(out.shape[1]):
            for c in range(dim):
                value = jet[k, m, c]
                for i in range(k + 1):
                    for j in range(m + 1):
                        if i + j > 0:
                            share = binomials[k, i] * binomials[m, j] * jet[i, j, column]
                            value -= share * out[k - i, m - j, c]
                out[k, m, c] = value * inverse


@fast_kernel
def pascal(size: int) -> FloatArray:
    """Give the binomial coefficients, shape (size, size)."""
    table = np.zeros((size, size))
    for k in range(size):
        table[k, 0] = 1.0
        for i in range(1, k + 1):
            table[k, i] = table[k - 1, i - 1] + table[k - 1, i]
    return table


@fast_kernel
def jets(
    knots_u: FloatArray,
    knots_v: FloatArray,
    rows: FloatArray,
    us: FloatArray,
    vs: FloatArray,
    column: float,
    out: FloatArray,
) -> None:
    """Write the derivatives at as many u as v, one each, shape (k, a, b, dim)."""
    p, q = knots_u.shape[0] - rows.shape[0] - 1, knots_v.shape[0] - rows.shape[1] - 1
    a, b, columns = out.shape[1], out.shape[2], rows.shape[2]
    basis_u, basis_v = np.empty((a, p + 1)), np.empty((b, q + 1))
    inverse, binomials = np.empty(max(p, q) + 1), pascal(max(a, b))
    strip, jet = np.empty((a, (q + 1) * columns)), np.empty((a, b, columns))
    flat = rows.reshape(rows.shape[0], rows.shape[1] * columns)
    span_u, span_v = p, q
    for k in range(us.shape[0]):
        span_u = span_at(knots_u, p, us[k], span_u)
        span_v = span_at(knots_v, q, vs[k], span_v)
        basis_rows(knots_u, span_u, us[k], inverse, basis_u)
        basis_rows(knots_v, span_v, vs[k], inverse, basis_v)
        contract(basis_u, flat, span_u - p, (span_v - q) * columns, strip)
        finish(strip, basis_v, 0, binomials, jet, int(column), out[k])


@fast_kernel
def grid(
    knots_u: FloatArray,
    knots_v: FloatArray,
    rows: FloatArray,
    us: FloatArray,
    vs: FloatArray,
    column: float,
    out: FloatArray,
) -> None:
    """Write the derivatives at each u with each v, v running first, shape (k * l, a, b, dim)."""
    p, q = knots_u.shape[0] - rows.shape[0] - 1, knots_v.shape[0] - rows.shape[1] - 1
    a, b, columns, many = out.shape[1], out.shape[2], rows.shape[2], vs.shape[0]
    basis_u, bases_v = np.empty((a, p + 1)), np.empty((many, b, q + 1))
    inverse, binomials = np.empty(max(p, q) + 1), pascal(max(a, b))
    flat = rows.reshape(rows.shape[0], rows.shape[1] * columns)
    strip, jet = np.empty((a, flat.shape[1])), np.empty((a, b, columns))
    first = np.empty(many, dtype=np.int64)
    span_u, span_v = p, q
    for i in range(many):
        span_v = span_at(knots_v, q, vs[i], span_v)
        first[i] = span_v - q
        basis_rows(knots_v, span_v, vs[i], inverse, bases_v[i])
    for k in range(us.shape[0]):
        span_u = span_at(knots_u, p, us[k], span_u)
        basis_rows(knots_u, span_u, us[k], inverse, basis_u)
        contract(basis_u, flat, span_u - p, 0, strip)
        for i in range(many):
            finish(strip, bases_v[i], first[i], binomials, jet, int(column), out[k * many + i])
