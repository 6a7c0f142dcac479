"""Torques on cells of a path, compiled.

A cell is looked at in places at shares of it. Arrays of places have the shape (cells, shares, n).
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel

from .row_kernel import ROUNDING

_LEAST_ROOM = 1e-9
"""At least this share of a torque is left for moving, so that lines have a width."""

_STILL = 1e-12
"""A joint whose q' is below this share of the largest on the path does not move."""


@fast_kernel
def motion_into(
    breaks: FloatArray,
    coefficients: FloatArray,
    s: FloatArray,
    x: FloatArray,
    shares: FloatArray,
    out: FloatArray,
) -> None:
    """Write q, qd and qdd at places of cells, shape (3, cells, shares, n), for x at nodes s.

    Without any x: q and its derivatives by s.
    """
    order, n = coefficients.shape[1], coefficients.shape[2]
    piece, last = 0, coefficients.shape[0] - 1
    square, push, speed = 1.0, 0.0, 1.0
    for i in range(s.shape[0] - 1):
        h = s[i + 1] - s[i]
        while piece < last and 0.5 * (s[i] + s[i + 1]) >= breaks[piece + 1]:
            piece += 1
        if x.shape[0] > 0:
            push = (x[i + 1] - x[i]) / (2.0 * h)
        for m in range(shares.shape[0]):
            at = s[i] - breaks[piece] + h * shares[m]
            if x.shape[0] > 0:
                square = x[i] * (1.0 - shares[m]) + x[i + 1] * shares[m]
                speed = math.sqrt(square)
            for j in range(n):
                q, slope, half = 0.0, 0.0, 0.0
                for k in range(order - 1, -1, -1):
                    half = half * at + slope
                    slope = slope * at + q
                    q = q * at + coefficients[piece, k, j]
                out[0, i, m, j] = q
                out[1, i, m, j] = slope * speed
                out[2, i, m, j] = slope * push + 2.0 * half * square


@fast_kernel
def torque_lines_into(
    taken: FloatArray,
    drive: FloatArray,
    s: FloatArray,
    ease: FloatArray,
    ceiling: FloatArray,
    reference: FloatArray,
    lines: FloatArray,
    alone: FloatArray,
) -> None:
    """Write the lines of torques on cells, whose torques are taken at both ends and the middle.

    Args:
        taken: Torques of weight alone, of weight and qdd = q' pace, of qd = q' pace and
            qdd = q'' pace^2 with friction, and q' pace, shape (4, cells, 3, n).
        drive: Viscous and Coulomb friction, highest torques, no-load speeds, and the pace, each in
            a row, shape (5, n).
        s: Nodes, shape (cells + 1,).
        ease: By how much each torque is tightened, shape (cells, n).
        ceiling: No x of the cell is above this, shape (cells,).
        reference: The sqrt(x) at which roots are replaced by tangents, shape (cells, 2, n); where
            it is not above 0 it is chosen, and written.
        lines: Lines above and below, shape (2, cells, 2, 6 n).
        alone: Largest x[i] of each cell, shape (cells,).
    """
    n = drive.shape[1]
    W = np.empty((4, 3))
    for i in range(s.shape[0] - 1):
        alone[i] = math.inf
        half = 0.5 / (s[i + 1] - s[i])
        for j in range(n):
            for side in range(2):
                reference[i, side, j] = _side(
                    taken, drive, ease[i, j], ceiling[i], reference[i, side, j], W, (i, side, j)
                )
                alone[i] = min(alone[i], _write_side(W, half, lines, (i, side, j)))


@fast_kernel
def _side(
    taken: FloatArray,
    drive: FloatArray,
    ease: float,
    ceiling: float,
    root: float,
    W: FloatArray,
    at: tuple[int, int, int],
) -> float:
    """Write one side of a joint's torque on a cell as W[0] u + W[1] x <= W[2]; give its root."""
    i, side, j = at
    sign = 1.0 - 2.0 * side
    viscous, coulomb, full, pace = drive[0, j], drive[1, j], drive[2, j], drive[4, j]
    # where a joint turns back within a cell its friction may point either way
    forth = back = False
    for m in range(3):
        rate = sign * taken[3, i, m, j]
        forth, back = forth or rate > _STILL, back or rate < -_STILL
    sense = 1.0 if forth else (-1.0 if back else 0.0)
    top = math.sqrt(ceiling)
    steady = top
    for m in range(3):
        weight, rate = taken[0, i, m, j], taken[3, i, m, j]
        turn = 1.0 if rate > 0.0 else (-1.0 if rate < 0.0 else 0.0)
        rigid = taken[2, i, m, j] - weight - viscous * rate - coulomb * turn
        W[0, m] = sign * (taken[1, i, m, j] - weight) / pace
        W[1, m] = sign * rigid / (pace * pace)
        W[2, m] = full / ease - sign * weight - coulomb * sense
        W[3, m] = sign * viscous * rate / pace
        if sign * rate > 0.0:
            W[3, m] += full / drive[3, j] * sign * rate / pace
        if W[3, m] > 0.0:
            steady = min(steady, max(W[2, m], _LEAST_ROOM * full) / W[3, m])
    root = root if root > 0.0 else steady
    for m in range(3):
        # a tangent is never below the root; nor is the root below its chord from 0
        if W[3, m] > 0.0:
            W[1, m] += W[3, m] / (2.0 * root)
            W[2, m] -= 0.5 * W[3, m] * root
        else:
            W[1, m] += W[3, m] / top
        W[2, m] = max(W[2, m], _LEAST_ROOM * full)
    return root


@fast_kernel
def _write_side(W: FloatArray, half: float, lines: FloatArray, at: tuple[int, int, int]) -> float:
    """Write the lines of W[0] u + W[1] x <= W[2] on a cell; give the largest x[i] alone."""
    i, side, j = at
    n = lines.shape[3] // 6
    first, middle, last = W[0, 0] * half, W[0, 1] * half, W[0, 2] * half
    # Bernstein coefficients of parabolas through both ends and the middle
    a0, a1, a2 = W[1, 0] - first, 0.5 * W[1, 1] - middle, -last
    b0, b1, b2 = first, 0.5 * W[1, 1] + middle, W[1, 2] + last
    a1, b1 = 2.0 * a1 - 0.5 * (a0 + a2), 2.0 * b1 - 0.5 * (b0 + b2)
    least = min(W[2, 0], W[2, 1], W[2, 2])
    W[2, 1] = max(2.0 * W[2, 1] - 0.5 * (W[2, 0] + W[2, 2]), 0.5 * least)
    alone = math.inf
    for m in range(3):
        a, b = (a0, b0) if m == 0 else ((a1, b1) if m == 1 else (a2, b2))
        slot = (3 * side + m) * n + j
        lines[0, i, 0, slot] = lines[1, i, 0, slot] = 0.0
        lines[0, i, 1, slot] = lines[1, i, 1, slot] = math.inf
        if abs(b) > ROUNDING * abs(a):
            which = 0 if b > 0.0 else 1
            lines[which, i, 0, slot] = -a / b
            lines[which, i, 1, slot] = W[2, m] / abs(b)
        elif a > 0.0:
            alone = min(alone, W[2, m] / a)
    return alone


@fast_kernel
def torque_use_into(torque: FloatArray, qd: FloatArray, drive: FloatArray, use: FloatArray) -> None:
    """Write the largest share of each torque that is used in each cell, shape (cells, n).

    What a motor's line takes away as a joint drives counts as if it were used.
    """
    for i in range(torque.shape[0]):
        for j in range(torque.shape[2]):
            most = 0.0
            for m in range(torque.shape[1]):
                value = abs(torque[i, m, j]) / drive[2, j]
                if torque[i, m, j] * qd[i, m, j] > 0.0:
                    value += abs(qd[i, m, j]) / drive[3, j]
                most = max(most, value)
            use[i, j] = most
