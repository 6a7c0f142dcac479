"""Search for joint positions from many starts, compiled; the order of starts is that of ``start``.

The limits of an arm are one array B, shape (3, n): lower, upper, unit of each joint. Its starts are
an array (count, n), their tools an array (12, count): positions and orientations, row-major.
"""

from math import ceil, pi

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .descent_kernel import Workspace, look
from .descent_kernel import descend as descend
from .descent_kernel import workspace as workspace

IntArray = npt.NDArray[np.int64]

_ROUNDING = 1e-12

# one row of how a search goes about it
SEED_STEP, SEED_ITERATIONS, STEP, FIRST_ITERATIONS, LAST_ITERATIONS, CONTINUED, NEAREST = range(7)


@kernel
def distances(G: FloatArray, tools: FloatArray, found: FloatArray) -> None:
    """Write how far the tools of the starts, (12, count), are from the goal."""
    place, turn = G[12] * G[12], 0.5 * G[13] * G[13]
    count = len(found)
    for i in range(count):
        dx, dy, dz = tools[0, i] - G[0], tools[1, i] - G[1], tools[2, i] - G[2]
        found[i] = place * (dx * dx + dy * dy + dz * dz)
    if turn != 0.0:
        for r in range(3, 12):
            wanted = G[r]
            for i in range(count):
                d = tools[r, i] - wanted
                found[i] += turn * d * d


@kernel
def _pop(left: FloatArray) -> int:
    """Give which start is the nearest of those left, and take it away."""
    best = 0
    for i in range(1, len(left)):
        if left[i] < left[best]:
            best = i
    left[best] = np.inf
    return best


@kernel
def with_turns(O: FloatArray, B: FloatArray, q: FloatArray, near: FloatArray) -> None:
    """Add the whole turns to q, in place, that bring it within limits and nearest to ``near``."""
    turn = 2.0 * pi
    for k in range(len(q)):
        if O[k, 12] != 0.0:
            continue
        lower, upper = B[0, k], B[1, k]
        away = near[k] - q[k]
        if abs(away) <= pi and lower <= q[k] <= upper:
            continue
        value = q[k] + turn * np.round(away / turn)
        value -= turn * max(ceil((value - upper - _ROUNDING) / turn), 0.0)
        raised = value + turn * max(ceil((lower - _ROUNDING - value) / turn), 0.0)
        if raised <= upper + _ROUNDING or lower - (raised - turn) >= raised - upper:
            value = raised
        else:
            value = raised - turn
        inside = min(max(value, lower), upper)
        q[k] = inside if abs(value - inside) <= _ROUNDING else value


@kernel
def _judged(
    O: FloatArray, B: FloatArray, G: FloatArray, row: FloatArray, near: FloatArray, work: Workspace
) -> bool:
    """Say whether a rest, brought near by whole turns, meets goal and limits, by fk anew."""
    n = len(near)
    q = row[:n]
    with_turns(O, B, q, near)
    for k in range(n):
        # also refuses what is no number
        if not (B[0, k] <= q[k] <= B[1, k]):
            return False
    row[n], position, angle = look(O, G, B[2], q, work[0][0], work[1][0])
    row[n + 1], row[n + 2] = position, angle
    return bool(position <= G[14] and angle <= G[15])


@kernel
def search(
    O: FloatArray,
    B: FloatArray,
    G: FloatArray,
    starts: FloatArray,
    tools: FloatArray,
    seed: FloatArray,
    how: FloatArray,
    restarts: int,
    rests: FloatArray,
    left: FloatArray,
    work: Workspace,
) -> tuple[bool, int, int]:
    """Search from the seed, then from the starts, then on from the best of these.

    Args:
        O: The arm, packed.
        B: Its limits and units.
        G: The goal.
        starts: Where to start, (count, n).
        tools: Their tools, (12, count).
        seed: Where to start first and to be near to; (2, n): the first row is the start, NaN for
            none, the second what whole turns are to be near to.
        how: Step sizes and numbers of steps.
        restarts: How many starts may be tried; 0: the seed only.
        rests: Where the descents ended: q, cost, position error, orientation error, steps, at
            rest; shape (count, n + 5), written over.
        left: Room for a number a start, written over.
        work: A workspace, written over.

    Returns:
        Whether the last rest is the answer, how many rests there are, and all their steps.
    """
    n = B.shape[1]
    lower, upper, units = B[0], B[1], B[2]
    near = seed[1]
    count, steps = 0, 0
    first = seed[0, 0] == seed[0, 0]
    total, nearest, stride = restarts, 0, 1
    if restarts > 0:
        distances(G, tools, left)
        nearest = int(how[NEAREST])
        stride = max(1, (len(left) - nearest) // max(1, restarts - nearest))
        total = min(restarts, nearest + (len(left) - nearest + stride - 1) // stride)
    for trial in range(-1 if first else 0, total):
        row = rests[count]
        q = row[:n]
        if trial < 0:
            for k in range(n):
                q[k] = min(max(seed[0, k], lower[k]), upper[k])
            step, most = how[SEED_STEP], int(how[SEED_ITERATIONS])
        else:
            start = _pop(left)
            if trial > nearest:
                for _ in range(stride - 1):
                    start = _pop(left)
            q[:] = starts[start]
            step, most = how[STEP], int(how[FIRST_ITERATIONS])
        row[n], row[n + 1], row[n + 2], taken, at_rest = descend(
            O, lower, upper, units, G, q, step, most, work
        )
        row[n + 3], row[n + 4] = taken, 1.0 if at_rest else 0.0
        steps += taken
        count += 1
        if _judged(O, B, G, row, near, work):
            return True, count, steps
    if restarts == 0:
        return False, count, steps
    tried = count
    for _ in range(int(how[CONTINUED])):
        best = -1
        for i in range(1 if first else 0, tried):
            if rests[i, n + 4] == 0.0 and (best < 0 or rests[i, n] < rests[best, n]):
                best = i
        if best < 0:
            break
        rests[best, n + 4] = 2.0
        row = rests[count]
        row[:n] = rests[best, :n]
        row[n], row[n + 1], row[n + 2], taken, at_rest = descend(
            O, lower, upper, units, G, row[:n], how[STEP], int(how[LAST_ITERATIONS]), work
        )
        row[n + 3], row[n + 4] = taken, 1.0 if at_rest else 0.0
        steps += taken
        count += 1
        if _judged(O, B, G, row, near, work):
            return True, count, steps
    return False, count, steps


@kernel
def search_alone(
    O: FloatArray,
    B: FloatArray,
    G: FloatArray,
    starts: FloatArray,
    tools: FloatArray,
    seed: FloatArray,
    how: FloatArray,
    restarts: int,
    rests: FloatArray,
) -> tuple[bool, int, int]:
    """Search for one goal, with room of its own."""
    work = workspace(B.shape[1])
    left = np.empty(len(starts))
    return search(O, B, G, starts, tools, seed, how, restarts, rests, left, work)


@kernel
def search_batch(
    O: FloatArray,
    B: FloatArray,
    goals: FloatArray,
    starts: FloatArray,
    tools: FloatArray,
    seeds: FloatArray,
    how: FloatArray,
    restarts: IntArray,
    answers: FloatArray,
) -> None:
    """Search for many goals, (m, 16), each with its own seed rows (m or 1, 2, n) and restarts (m,).

    Writes q, position error, orientation error, steps and tries into answers, (m, n + 4); q is NaN
    where none was found.
    """
    n = B.shape[1]
    work = workspace(n)
    left = np.empty(len(starts))
    rests = np.empty((2 + restarts.max() + int(how[CONTINUED]), n + 5))
    for i in range(len(goals)):
        seed = seeds[i] if len(seeds) > 1 else seeds[0]
        met, count, steps = search(
            O, B, goals[i], starts, tools, seed, how, restarts[i], rests, left, work
        )
        answers[i, :n] = np.nan
        if met:
            row = rests[count - 1]
            answers[i, :n] = row[:n]
            answers[i, n], answers[i, n + 1] = row[n + 1], row[n + 2]
        else:
            answers[i, n] = answers[i, n + 1] = np.inf
        answers[i, n + 2], answers[i, n + 3] = steps, count
