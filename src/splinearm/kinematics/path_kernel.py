"""Following a path from joint positions to joint positions, compiled.

A path is the goals of its points (see ``descent_kernel``); between two of them the tool goes
straight and turns about one axis.
"""

from math import cos, sin, sqrt

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .descent_kernel import Workspace, descend, rotation_vector, workspace
from .search_kernel import distances

_LARGEST = 0.1
"""Largest change of a joint, in its unit, in a step that may count as continuous ..."""

_BEND = 0.3
"""... and share of it by which the place half-way may be off the middle.

Where a way stretches to a fold it goes like a square root, which is off by 0.21; a jump by 0.5."""

_TINY = 2e-3
"""A step as small as this is continuous however it bends (a limit is a kink)."""

_SHORTEST = 1.0 / 4096.0
"""Shortest share of a segment that is tried."""

_SEED_STEP, _SEED_ITERATIONS = 0.2, 100


@kernel
def between(a: FloatArray, b: FloatArray, turn: FloatArray, share: float, G: FloatArray) -> None:
    """Write the goal at a share of the way from goal a to goal b, ``turn`` (3,) apart."""
    for i in range(12, 16):
        G[i] = b[i]
    if share >= 1.0:
        for i in range(12):
            G[i] = b[i]
        return
    for i in range(3):
        G[i] = a[i] + share * (b[i] - a[i])
    if b[13] == 0.0:
        return
    angle = sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2])
    if angle < 1e-12:
        for i in range(3, 12):
            G[i] = a[i]
        return
    x, y, z = turn[0] / angle, turn[1] / angle, turn[2] / angle
    c, s = cos(share * angle), sin(share * angle)
    v = 1.0 - c
    for j in range(3):
        first, second, third = a[3 + j], a[6 + j], a[9 + j]
        along = x * first + y * second + z * third
        G[3 + j] = c * first + s * (y * third - z * second) + v * along * x
        G[6 + j] = c * second + s * (z * first - x * third) + v * along * y
        G[9 + j] = c * third + s * (x * second - y * first) + v * along * z


@kernel
def turn_between(a: FloatArray, b: FloatArray, turn: FloatArray) -> None:
    """Write axis times angle, (3,), of the turn from goal a to goal b."""
    turn[:] = 0.0
    if a[13] == 0.0 or b[13] == 0.0:
        return
    R = np.empty(9)
    for i in range(3):
        for j in range(3):
            R[3 * i + j] = (
                b[3 + 3 * i] * a[3 + 3 * j]
                + b[4 + 3 * i] * a[4 + 3 * j]
                + b[5 + 3 * i] * a[5 + 3 * j]
            )
    turn[0], turn[1], turn[2] = rotation_vector(
        R[0], R[1], R[2], R[3], R[4], R[5], R[6], R[7], R[8]
    )


@kernel
def _arrives(O: FloatArray, B: FloatArray, G: FloatArray, q: FloatArray, work: Workspace) -> bool:
    """Go from q, in place, to where its branch meets the goal; say whether it does."""
    _, position, angle, _, _ = descend(
        O, B[0], B[1], B[2], G, q, _SEED_STEP, _SEED_ITERATIONS, work
    )
    return bool(position <= G[14] and angle <= G[15])


@kernel
def follow(
    O: FloatArray, B: FloatArray, a: FloatArray, b: FloatArray, q: FloatArray, work: Workspace
) -> float:
    """Follow the segment from goal a, met by q, to goal b without a jump; q is moved along.

    Gives the share of the way that it went: 1 if it arrived.
    """
    n = len(q)
    turn, G = np.empty(3), np.empty(16)
    turn_between(a, b, turn)
    there, half = np.empty(n), np.empty(n)
    done, step = 0.0, 1.0
    while done < 1.0:
        ahead = min(done + step, 1.0)
        between(a, b, turn, ahead, G)
        for k in range(n):
            there[k] = q[k]
        met = _arrives(O, B, G, there, work)
        largest = 0.0
        for k in range(n):
            largest = max(largest, abs(there[k] - q[k]) / B[2, k])
        smooth = met and largest <= _LARGEST
        if smooth and largest > _TINY:
            between(a, b, turn, 0.5 * (done + ahead), G)
            for k in range(n):
                half[k] = q[k]
            smooth = _arrives(O, B, G, half, work)
            for k in range(n):
                off = abs(half[k] - 0.5 * (q[k] + there[k])) / B[2, k]
                smooth = smooth and off <= _BEND * largest
        if smooth:
            for k in range(n):
                q[k] = there[k]
            done = ahead
            step *= 2.0
        else:
            step *= 0.5
            if step < _SHORTEST:
                return done
    return 1.0


@kernel
def follow_all(
    O: FloatArray, B: FloatArray, a: FloatArray, b: FloatArray, nodes: FloatArray, out: FloatArray
) -> None:
    """Follow a segment from each of some joint positions, (count, n).

    Writes where each ended and the share of the way it went into ``out``, (count, n + 1).
    """
    n = nodes.shape[1]
    work = workspace(n)
    for i in range(len(nodes)):
        for k in range(n):
            out[i, k] = nodes[i, k]
        out[i, n] = follow(O, B, a, b, out[i, :n], work)


@kernel
def candidates(
    O: FloatArray,
    B: FloatArray,
    G: FloatArray,
    starts: FloatArray,
    tools: FloatArray,
    step: float,
    iterations: int,
    out: FloatArray,
) -> int:
    """Write answers to a goal from as many starts as ``out``, (count, n), has rows; say how many.

    Every second start is the nearest of those left, the others are spread over all of them.
    """
    n = B.shape[1]
    work = workspace(n)
    left = np.empty(len(starts))
    distances(G, tools, left)
    count = 0
    stride = max(1, 2 * len(starts) // len(out))
    place = 0
    for trial in range(len(out)):
        chosen = 0
        if trial % 2 == 0:
            for i in range(1, len(left)):
                if left[i] < left[chosen]:
                    chosen = i
        else:
            chosen = place % len(starts)
            place += stride
        if left[chosen] == np.inf:
            continue
        left[chosen] = np.inf
        for k in range(n):
            out[count, k] = starts[chosen, k]
        _, position, angle, _, _ = descend(
            O, B[0], B[1], B[2], G, out[count], step, iterations, work
        )
        if position <= G[14] and angle <= G[15]:
            count += 1
    return count
