"""The shortest way through layers of joint positions, compiled: a dynamic programme.

A layer holds, for one place of the tool, the joint positions of every turn about its axis and
every branch: node ``turn * branches + branch``. From layer to layer the turn changes by one step at
the most and no joint moves farther than a bound, so that a way never jumps to another branch.
"""

import math

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel
from splinearm.kinematics import few_kernel

TURN = 2.0 * math.pi


@kernel
def few_batch(
    G: FloatArray, T: FloatArray, seed: FloatArray, free: int, axis: FloatArray, q: FloatArray
) -> None:
    """Write all branches of poses (m, 4, 4) of an arm of four or five joints in ``q`` (m, b, n)."""
    tolerance = G[len(G) - 1, 3]
    for i in range(len(T)):
        found, _ = few_kernel.solve(G, T[i], seed, free, axis, tolerance)
        q[i] = np.nan
        for b in range(min(len(found), q.shape[1])):
            q[i, b] = found[b]


@kernel
def near_limits(q: FloatArray, B: FloatArray) -> float:
    """Give how near joint positions, (n,), are to their limits: 0 where all have room.

    Rows of ``B``: least and largest position, speed, largest step, whether it turns, and the room
    below which a limit counts as near.
    """
    cost = 0.0
    for k in range(len(q)):
        room = min(q[k] - B[0, k], B[1, k] - q[k])
        if room < B[5, k]:
            short = 1.0 - room / B[5, k]
            cost += short * short
    return cost


@kernel
def _reach(q: FloatArray, before: FloatArray, B: FloatArray, most: float, out: FloatArray) -> float:
    """Give what it costs to go from joint positions to others, ``inf`` if it is a jump.

    Writes where the joints then are, whole turns counted, to ``out``.
    """
    cost = 0.0
    for k in range(len(q)):
        step = q[k] - before[k]
        if B[4, k] != 0.0:
            step -= TURN * math.floor(step / TURN + 0.5)
        size = abs(step)
        if size > B[3, k]:
            return math.inf
        there = before[k] + step
        if there < B[0, k] or there > B[1, k]:
            return math.inf
        cost += size / B[2, k]
        if cost >= most:
            return math.inf
        out[k] = there
    return cost


@kernel
def advance(
    layers: FloatArray,
    extra: FloatArray,
    weights: FloatArray,
    B: FloatArray,
    turns: int,
    turning: float,
    here: FloatArray,
    costs: FloatArray,
    parents: "npt.NDArray[np.int16]",
) -> int:
    """Go on through layers (m, N, n), NaN where there is no node; say how many were reached.

    Args:
        layers: Joint positions, whatever whole turns.
        extra: What a node costs besides, (m, N).
        weights: What nearness to limits costs in each layer, (m,).
        B: As ``near_limits`` has it.
        turns: How many turns about the axis a layer has.
        turning: What a step of the turn costs.
        here: Joint positions at the layer before, whole turns counted, (N, n); then at the last.
        costs: Cost of the cheapest way to each of them, (N,), ``inf`` if none; then to the last.
        parents: From which node the cheapest way comes, (m, N).
    """
    m, N, n = layers.shape
    branches = N // turns
    now, new = np.empty((N, n)), np.empty(N)
    tried, best = np.empty(n), np.empty(n)
    sides = 3 if turns > 2 else 1
    for layer in range(m):
        alive = False
        for i in range(N):
            new[i] = math.inf
            q = layers[layer, i]
            if not math.isfinite(q[0]) or not math.isfinite(extra[layer, i]):
                continue
            turn = i // branches
            least, parent = math.inf, -1
            for side in range(sides):
                beside = turn
                paid = 0.0
                if side > 0:
                    beside = (turn + 2 * side - 3 + turns) % turns
                    paid = turning
                for p in range(beside * branches, (beside + 1) * branches):
                    so_far = costs[p] + paid
                    if so_far >= least:
                        continue
                    whole = so_far + _reach(q, here[p], B, least - so_far, tried)
                    if whole < least:
                        least, parent = whole, p
                        for k in range(n):
                            best[k] = tried[k]
            if parent >= 0:
                alive = True
                parents[layer, i] = parent
                for k in range(n):
                    now[i, k] = best[k]
                new[i] = least + extra[layer, i] + weights[layer] * near_limits(best, B)
        if not alive:
            return int(layer)
        for i in range(N):
            costs[i] = new[i]
            for k in range(n):
                here[i, k] = now[i, k]
    return int(m)
