"""A C2 curve through orientations: rotation vectors that are quintic between neighbours.

On piece k the curve is R(u) = R_k exp(f(u)), f a polynomial with f = 0 at its start. Neighbouring
pieces share orientation, angular velocity and angular acceleration, so the curve is C2 whatever
the rates at the orientations are; they are chosen such that f would be cubic, as in a cubic
spline. All rates here are in the body unless said otherwise.
"""

from dataclasses import dataclass

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.curves import banded, basis
from splinearm.curves.hermite import Jet, quintic_pieces
from splinearm.kinematics import quaternion

from .turning import Turning, equal_signs, inside

_SWEEPS = 30
"""Most improvements of the rates."""

_CONVERGED = 1e-13
"""Relative change of the rates that is rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class RotationSpline:
    """A curve of orientations, C2, made of pieces between given orientations."""

    u: FloatArray
    """Parameters of the k + 1 ends of the pieces, rising, shape (k + 1,)."""
    quats: FloatArray
    """Orientation at the start of each piece, unit quaternions, shape (k, 4)."""
    coefficients: FloatArray
    """Of powers of u - u[i] in the rotation vector of piece i, shape (k, 6, 3)."""

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return float(self.u[0]), float(self.u[-1])

    @property
    def breaks(self) -> FloatArray:
        """The ends of the pieces."""
        return self.u

    def at(self, u: ArrayInput) -> Turning:
        """Give orientations, angular velocities and accelerations.

        Args:
            u: Parameters in the domain, shape (m,).

        Raises:
            CurveError: If one lies outside.
        """
        u = inside(u, self.domain)
        piece = np.clip(np.searchsorted(self.u, u, side="right") - 1, 0, len(self.quats) - 1)
        x = (u - self.u[piece])[:, None]
        c = self.coefficients[piece]
        f = np.zeros((len(u), 3))
        fd, fdd = np.zeros_like(f), np.zeros_like(f)
        for j in range(c.shape[1] - 1, -1, -1):
            fdd = fdd * x + 2.0 * fd
            fd = fd * x + f
            f = f * x + c[:, j]
        quat = quaternion.normalize(quaternion.multiply(self.quats[piece], quaternion.exp(f)))
        omega, alpha = body_rates(f, fd, fdd)
        return Turning(quat, quaternion.rotate(quat, omega), quaternion.rotate(quat, alpha))


def fit(u: FloatArray, quats: FloatArray, *, closed: bool) -> RotationSpline:
    """Give the C2 curve through orientations; an open one has no angular acceleration at its ends.

    Args:
        u: Parameters, rising, shape (m,), of a closed curve (m + 1,).
        quats: Unit quaternions, shape (m, 4).
        closed: Whether the curve returns to the first of them.
    """
    ring = np.vstack((quats, quats[:1])) if closed else quats
    ring = equal_signs(ring)
    turns = quaternion.log(quaternion.multiply(quaternion.conjugate(ring[:-1]), ring[1:]))
    h = np.diff(u)[:, None]
    rates = _choose_rates(turns, h, closed=closed)
    behind, ahead = _accelerations(turns, h, rates)
    bends = np.zeros_like(rates)
    bends[1:-1] = 0.5 * (behind[:-1] + ahead[1:])
    if closed:
        bends[0] = bends[-1] = 0.5 * (behind[-1] + ahead[0])
    return RotationSpline(u, ring[:-1], _quintic(turns, h, rates, bends))


def body_rates(f: FloatArray, fd: FloatArray, fdd: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give angular velocity and acceleration of exp(f), each of shape (m, 3).

    Args:
        f: Rotation vectors, shape (m, 3), and
        fd: their first and
        fdd: second derivatives.
    """
    # omega = J f' with the right Jacobian J = I - a [f] + b [f]^2 of SO(3) (Chirikjian, Stochastic
    # Models, Information Theory, and Lie Groups 2, 2012, eq. 10.86); alpha is its derivative
    a, b, a_slope, b_slope = _jacobian_factors(np.sum(f * f, axis=1, keepdims=True))
    growth = np.sum(f * fd, axis=1, keepdims=True)
    c1, c2 = np.cross(f, fd), np.cross(f, fdd)
    d1, d2 = np.cross(f, c1), np.cross(f, c2)
    omega = fd - a * c1 + b * d1
    alpha = fdd - a * c2 + b * (d2 + np.cross(fd, c1)) + growth * (b_slope * d1 - a_slope * c1)
    return omega, alpha


def _jacobian_factors(
    square: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Give a, b and da/dx / x, db/dx / x at angles x, of whose squares they are functions."""
    small = square < 0.09
    x = np.sqrt(np.where(small, 1.0, square))
    sine, cosine = np.sin(x), np.cos(x)
    z = np.where(small, square, 0.0)
    powers = np.stack((np.ones_like(z), -z, z**2, -(z**3), z**4))
    # a = sum (-z)^k / (2 k + 2)!, b = sum (-z)^k / (2 k + 3)!
    a = np.tensordot(_SERIES[0], powers, 1)
    b = np.tensordot(_SERIES[1], powers, 1)
    a_slope = np.tensordot(_SERIES[2], powers, 1)
    b_slope = np.tensordot(_SERIES[3], powers, 1)
    return (
        np.where(small, a, (1.0 - cosine) / x**2),
        np.where(small, b, (x - sine) / x**3),
        np.where(small, a_slope, (x * sine - 2.0 * (1.0 - cosine)) / x**4),
        np.where(small, b_slope, (3.0 * sine - x * cosine - 2.0 * x) / x**5),
    )


def _series(first: int) -> tuple[list[float], list[float]]:
    """Give five terms of sum (-z)^k / (2 k + first)! and of twice its derivative by z."""
    terms = [1.0]
    for i in range(2, 2 * 5 + first + 1):
        terms.append(terms[-1] / i)
    factorials = [terms[2 * k + first - 1] for k in range(6)]
    return factorials[:5], [-2.0 * (k + 1) * factorials[k + 1] for k in range(5)]


_A, _A_SLOPE = _series(2)
_B, _B_SLOPE = _series(3)
_SERIES = np.array((_A, _B, _A_SLOPE, _B_SLOPE))


def _inverse_jacobian(f: FloatArray) -> FloatArray:
    """Give the inverse right Jacobian, shape (m, 3, 3), at rotation vectors up to a half turn."""
    square = np.sum(f * f, axis=1)
    x = np.sqrt(square)
    # (1 - x/2 cot(x/2)) / x^2, at and near 0 by its series
    small = square < 1e-4
    safe = np.where(small, 1.0, x)
    c = np.where(
        small, 1.0 / 12.0 + square / 720.0, (1.0 - 0.5 * safe / np.tan(0.5 * safe)) / safe**2
    )
    cross = _cross_matrix(f)
    inverse: FloatArray = np.eye(3) + 0.5 * cross + c[:, None, None] * (cross @ cross)
    return inverse


def _cross_matrix(f: FloatArray) -> FloatArray:
    matrix = np.zeros((len(f), 3, 3))
    matrix[:, 2, 1], matrix[:, 0, 2], matrix[:, 1, 0] = f.T
    return matrix - np.swapaxes(matrix, 1, 2)


def _choose_rates(turns: FloatArray, h: FloatArray, *, closed: bool) -> FloatArray:
    """Give angular velocities at all ends of pieces, shape (k + 1, 3), for smooth cubic pieces.

    The condition is that the accelerations of neighbouring cubic pieces agree. It is linear up to
    products of rates, which are taken from the last sweep; sweeps that do not help are dropped.
    """
    # after Mayorov, Smooth attitude interpolation, 2019, the note behind scipy's RotationSpline
    inverse = _inverse_jacobian(turns)
    forward = np.asarray(np.linalg.inv(inverse), dtype=np.float64)
    first, matrix = _rate_matrix(inverse, forward, h, closed=closed)
    even = turns / h
    products = np.zeros_like(turns)
    best = np.vstack((even, even[-1:]))
    best_jump, last = np.inf, best
    for _ in range(_SWEEPS):
        rates = _solve_rates(first, matrix, turns, h, products, closed=closed)
        behind, ahead = _accelerations(turns, h, rates)
        jumps = np.roll(behind, 1, axis=0) - ahead
        jump = float(np.abs(jumps if closed else jumps[1:]).max(initial=0.0))
        if jump < best_jump:
            best, best_jump = rates, jump
        change = float(np.abs(rates - last).max())
        if not np.isfinite(change) or change <= _CONVERGED * float(np.abs(rates).max()):
            break
        last = rates
        # what the end acceleration of a piece holds beyond its linear part
        ends = np.einsum("kij,kj->ki", inverse, rates[1:])
        bends = (2.0 * rates[:-1] + 4.0 * ends) / h - 6.0 * turns / h**2
        products = behind - np.einsum("kij,kj->ki", forward, bends)
    return best


def _rate_matrix(
    inverse: FloatArray, forward: FloatArray, h: FloatArray, *, closed: bool
) -> tuple[basis.IndexArray, FloatArray]:
    """Give the block rows (before, at, behind) of the conditions, as banded rows."""
    k = len(h)
    m = k if closed else k + 1
    blocks = np.zeros((m, 3, 3, 3))
    scale = h[:, :, None]
    into_before, into_at = (
        2.0 * forward / scale,
        np.broadcast_to(4.0 * np.eye(3), forward.shape) / scale,
    )
    out_at, out_behind = into_at, 2.0 * inverse / scale
    pieces_in = np.arange(k) - 1 if closed else np.arange(k)
    rows_in = np.arange(k) if closed else np.arange(1, k + 1)
    blocks[rows_in, :, 0] += into_before[pieces_in]
    blocks[rows_in, :, 1] += into_at[pieces_in]
    blocks[:k, :, 1] += out_at
    blocks[:k, :, 2] += out_behind
    first = np.repeat(3 * (np.arange(m) - 1), 3)
    values = blocks.reshape(3 * m, 9)
    if not closed:
        # the first and the last row have nothing before and behind
        values[:3] = np.roll(values[:3], -3, axis=1)
        values[-3:] = np.roll(values[-3:], 3, axis=1)
        first[:3] = 0
        first[-3:] = 3 * (m - 3)
    return first, values


def _solve_rates(
    first: basis.IndexArray,
    matrix: FloatArray,
    turns: FloatArray,
    h: FloatArray,
    products: FloatArray,
    *,
    closed: bool,
) -> FloatArray:
    """Give the rates at all ends of pieces that fulfil the linear conditions."""
    pull = 6.0 * turns / h**2
    if closed:
        rhs = pull + np.roll(pull - products, 1, axis=0)
    else:
        nothing = np.zeros((1, 3))
        rhs = np.vstack((pull, nothing)) + np.vstack((nothing, pull - products))
    rates = banded.solve(first, matrix, rhs.reshape(-1, 1), closed=closed).reshape(-1, 3)
    return np.vstack((rates, rates[:1])) if closed else rates


def _accelerations(
    turns: FloatArray, h: FloatArray, rates: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Give the accelerations at the ends and at the starts of cubic pieces, each (k, 3)."""
    ends = np.einsum("kij,kj->ki", _inverse_jacobian(turns), rates[1:])
    bends = (2.0 * rates[:-1] + 4.0 * ends) / h - 6.0 * turns / h**2
    behind = body_rates(turns, ends, bends)[1]
    return behind, 6.0 * turns / h**2 - (4.0 * rates[:-1] + 2.0 * ends) / h


def _quintic(turns: FloatArray, h: FloatArray, rates: FloatArray, bends: FloatArray) -> FloatArray:
    """Give the coefficients of the pieces with these rates and accelerations at their ends."""
    inverse = _inverse_jacobian(turns)
    slope = np.einsum("kij,kj->ki", inverse, rates[1:])
    # alpha = J f'' + J' f': what J' f' is tells the acceleration of f'' = 0
    dragged = body_rates(turns, slope, np.zeros_like(slope))[1]
    bend = np.einsum("kij,kj->ki", inverse, bends[1:] - dragged)
    starts: Jet = (np.zeros_like(turns), rates[:-1], bends[:-1])
    return quintic_pieces(h[:, 0], starts, (turns, slope, bend))
