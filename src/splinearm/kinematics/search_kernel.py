"""Search for joint positions from many starts, compiled; the order of starts is that of ``start``.

The limits of an arm are one array B, shape (5, n): lower, upper and unit of each joint, and lower
and upper where joints that have room for a whole turn count as having no limits. Its starts are
an array (count, n), their tools an array (12, count): positions and orientations, row-major.
"""

from math import ceil, pi, sqrt

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel, kernel
from splinearm.direct import MODEL, WRITE, answer, matrix, vector

from .descent_kernel import Workspace, cut, look
from .descent_kernel import descend as descend
from .descent_kernel import room as room
from .descent_kernel import workspace as workspace

IntArray = npt.NDArray[np.int64]

_ROUNDING = 1e-12

# one row of how a search goes about it
SEED_STEP, SEED_ITERATIONS, STEP, FIRST_ITERATIONS, LAST_ITERATIONS, CONTINUED, NEAREST = range(7)

# one row of what a single search is asked beside its target; SHOULDER stands for three numbers
PLACE, TURN, POSITION_TOLERANCE, ORIENTATION_TOLERANCE, RESTARTS, SEEDED, HOPELESS, REACH = range(8)
SHOULDER = 8

STRIPES = 32
"""In how many parts the starts are kept that are left; the nearest is looked for in one of them."""


@fast_kernel
def distances(G: FloatArray, tools: FloatArray, found: FloatArray) -> None:
    """Write how far the tools of the starts, (12, count), are from the goal."""
    place, turn = G[12] * G[12], G[13] * G[13]
    px, py, pz = G[0], G[1], G[2]
    a, b, c, d, e, f, g, h, k = G[3], G[4], G[5], G[6], G[7], G[8], G[9], G[10], G[11]
    for i in range(len(found)):
        dx, dy, dz = tools[0, i] - px, tools[1, i] - py, tools[2, i] - pz
        # |R - R'|^2 = 6 - 2 R:R'
        alike = (
            (a * tools[3, i] + b * tools[4, i] + c * tools[5, i])
            + (d * tools[6, i] + e * tools[7, i] + f * tools[8, i])
            + (g * tools[9, i] + h * tools[10, i] + k * tools[11, i])
        )
        found[i] = place * (dx * dx + dy * dy + dz * dz) + turn * (3.0 - alike)


@kernel
def _least(left: FloatArray, least: FloatArray) -> None:
    """Write the least of each stripe of numbers: every so many-th one."""
    stripes = len(least)
    least[:] = np.inf
    for begin in range(0, len(left), stripes):
        for j in range(min(stripes, len(left) - begin)):
            least[j] = min(least[j], left[begin + j])


@kernel
def _pop(left: FloatArray, least: FloatArray) -> int:
    """Give which start is the nearest of those left, and take it away."""
    stripe = 0
    for j in range(1, len(least)):
        if least[j] < least[stripe]:
            stripe = j
    best, rest = stripe, np.inf
    for i in range(stripe, len(left), len(least)):
        if left[i] < left[best]:
            rest = left[best]
            best = i
        elif i != best and left[i] < rest:
            rest = left[i]
    left[best] = np.inf
    least[stripe] = rest
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
    least: FloatArray,
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
        least: Room for a number a stripe of starts, written over.
        work: A workspace, written over.

    Returns:
        Whether the last rest is the answer, how many rests there are, and all their steps.
    """
    n = B.shape[1]
    units = B[2]
    near = seed[1]
    count, steps = 0, 0
    first = seed[0, 0] == seed[0, 0]
    total, nearest, stride = restarts, 0, 1
    if restarts > 0:
        distances(G, tools, left)
        _least(left, least)
        nearest = int(how[NEAREST])
        stride = max(1, (len(left) - nearest) // max(1, restarts - nearest))
        total = min(restarts, nearest + (len(left) - nearest + stride - 1) // stride)
    for trial in range(-1 if first else 0, total):
        row = rests[count]
        q = row[:n]
        if trial < 0:
            for k in range(n):
                q[k] = min(max(seed[0, k], B[0, k]), B[1, k])
            step, most = how[SEED_STEP], int(how[SEED_ITERATIONS])
            lower, upper = B[0], B[1]
        else:
            start = _pop(left, least)
            if trial > nearest:
                for _ in range(stride - 1):
                    start = _pop(left, least)
            for k in range(n):
                q[k] = starts[start, k]
            step, most = how[STEP], int(how[FIRST_ITERATIONS])
            lower, upper = B[3], B[4]
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
        for k in range(n):
            row[k] = rests[best, k]
        row[n], row[n + 1], row[n + 2], taken, at_rest = descend(
            O, B[3], B[4], units, G, row[:n], how[STEP], int(how[LAST_ITERATIONS]), work
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
    p: FloatArray,
    quat: FloatArray,
    q_seed: FloatArray,
    terms: FloatArray,
    starts: FloatArray,
    tools: FloatArray,
    how: FloatArray,
    rests: FloatArray,
    scratch: FloatArray,
    q: FloatArray,
    said: FloatArray,
) -> bool:
    """Search for one goal as it comes; False where an argument is not as wanted.

    Args:
        O: The arm, packed.
        B: Its limits and units.
        p: Where the tool shall be, (3,).
        quat: How it shall be turned, w x y z, (4,).
        q_seed: Where to start, (n,).
        terms: What stands in ``solver.Terms``.
        starts: Where to start, (count, n).
        tools: Their tools, (12, count).
        how: Step sizes and numbers of steps.
        rests: As in ``search``, (restarts + CONTINUED + 2, n + 5).
        scratch: Room, as many numbers as ``solver`` says; written over.
        q: The answer if there is one, (n,).
        said: Whether there is, its position and orientation error, all steps, and how many rests.
    """
    n, count = O.shape[0] - 1, len(starts)
    if len(p) != 3 or len(quat) != 4 or len(q_seed) != n:
        return False
    restarts = int(terms[RESTARTS])
    seeded = terms[SEEDED] != 0.0
    G = scratch[:16]
    for i in range(3):
        G[i] = p[i]
    if not abs(G[0]) + abs(G[1]) + abs(G[2]) < np.inf:
        return False
    turn = terms[TURN]
    w, x, y, z = quat[0], quat[1], quat[2], quat[3]
    G[3], G[4], G[5] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    G[6], G[7], G[8] = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
    G[9], G[10], G[11] = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
    G[12], G[13] = terms[PLACE], turn
    G[14], G[15] = terms[POSITION_TOLERANCE], terms[ORIENTATION_TOLERANCE]
    dx, dy, dz = G[0] - terms[SHOULDER], G[1] - terms[SHOULDER + 1], G[2] - terms[SHOULDER + 2]
    if sqrt(dx * dx + dy * dy + dz * dz) > terms[REACH] + G[14]:
        restarts = min(restarts, int(terms[HOPELESS]))
    seed = scratch[16 : 16 + 2 * n].reshape((2, n))
    for k in range(n):
        if seeded and not abs(q_seed[k]) < np.inf:
            return False
        seed[0, k] = q_seed[k] if seeded else np.nan
        seed[1, k] = q_seed[k]
    at = 16 + 2 * n
    left, least = scratch[at : at + count], scratch[at + count : at + count + STRIPES]
    work = cut(scratch[at + count + STRIPES :], n)
    met, tried, steps = search(
        O, B, G, starts, tools, seed, how, restarts, rests, left, least, work
    )
    said[0], said[3], said[4] = met, steps, tried
    if met:
        row = rests[tried - 1]
        for k in range(n):
            q[k] = row[k]
        said[1], said[2] = row[n + 1], row[n + 2]
    return True


def search_call(model: int, arguments: int, count: int) -> int:
    """Do as `search_alone` does, for the arm it is bound to; see `direct.bind`."""
    given = model, arguments
    return answer(
        count == 12
        and search_alone(
            matrix(given, MODEL),
            matrix(given, 0),
            vector(given, 1),
            vector(given, 2),
            vector(given, 3),
            vector(given, 4),
            matrix(given, 5),
            matrix(given, 6),
            vector(given, 7),
            matrix(given, 8, WRITE),
            vector(given, 9, WRITE),
            vector(given, 10, WRITE),
            vector(given, 11, WRITE),
        )
    )


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
    left, least = np.empty(len(starts)), np.empty(STRIPES)
    most = 0
    for i in range(len(goals)):
        most = max(most, restarts[i])
    rests = np.empty((2 + most + int(how[CONTINUED]), n + 5))
    for i in range(len(goals)):
        seed = seeds[i] if len(seeds) > 1 else seeds[0]
        met, count, steps = search(
            O, B, goals[i], starts, tools, seed, how, restarts[i], rests, left, least, work
        )
        row = rests[count - 1]
        for k in range(n):
            answers[i, k] = row[k] if met else np.nan
        if met:
            answers[i, n], answers[i, n + 1] = row[n + 1], row[n + 2]
        else:
            answers[i, n] = answers[i, n + 1] = np.inf
        answers[i, n + 2], answers[i, n + 3] = steps, count
