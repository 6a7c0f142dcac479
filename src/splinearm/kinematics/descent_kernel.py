"""Descent to a target, compiled: the same method as module ``descent``, step for step.

A goal is one array G, shape (16,): position (0..2), orientation row-major (3..11), weight of the
position (12), weight of the orientation (13; 0: any orientation will do), the position's (14) and
the orientation's (15) tolerance. A workspace is what ``workspace`` gives, or ``cut`` of room
that somebody has; it is written over.
"""

from math import atan2, cos, sqrt

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .sine_kernel import sine_and_cosine

# the constants of module descent, each explained there
_POLISH = 1e-3
_REST = 1e-9
_ROUNDING = 1e-14
_FIRST_DAMPING = 0.1
_LEAST_DAMPING = 1e-3
_NO_STEP = 1e-12
_STALL = 1e-4
_PATIENCE = 8

Workspace = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]


@kernel
def workspace(n: int) -> Workspace:
    """Give room for the descents of an arm of n joints."""
    return cut(np.empty(room(n)), n)


@kernel
def room(n: int) -> int:
    """Give how many numbers a workspace holds."""
    return 2 * n * n + 19 * n + 12


@kernel
def cut(room: FloatArray, n: int) -> Workspace:
    """Give a workspace in room for it."""
    a = 12 * n
    b = a + 12
    c = b + 3 * n
    d = c + 2 * n * n
    return (
        room[:a].reshape((2, n, 6)),
        room[a:b].reshape((2, 6)),
        room[b:c].reshape((3, n)),
        room[c:d].reshape((2, n, n)),
        room[d : d + 4 * n].reshape((4, n)),
    )


@kernel
def rotation_vector(
    xx: float,
    xy: float,
    xz: float,
    yx: float,
    yy: float,
    yz: float,
    zx: float,
    zy: float,
    zz: float,
) -> tuple[float, float, float]:
    """Give axis times angle of a rotation matrix, rad; exact at and near 0 and pi."""
    x = zy - yz
    y = xz - zx
    z = yx - xy
    sine2 = sqrt(x * x + y * y + z * z)
    cosine2 = xx + yy + zz - 1.0
    if cosine2 > -1.9:
        scale = 0.5
        if sine2 > 1e-150:
            scale = atan2(sine2, cosine2) / sine2
        return scale * x, scale * y, scale * z
    # near a half turn the axis is in the symmetric part
    a = 0.5 * (xy + yx)
    b = 0.5 * (xz + zx)
    c = 0.5 * (yz + zy)
    h = 0.5 * cosine2
    first = (xx - h) * (xx - h) + a * a + b * b
    second = a * a + (yy - h) * (yy - h) + c * c
    third = b * b + c * c + (zz - h) * (zz - h)
    if first >= second and first >= third:
        ux, uy, uz, square = xx - h, a, b, first
    elif second >= third:
        ux, uy, uz, square = a, yy - h, c, second
    else:
        ux, uy, uz, square = b, c, zz - h, third
    length = sqrt(square)
    if ux * x + uy * y + uz * z < 0.0:
        length = -length
    scale = atan2(sine2, cosine2) / length
    return scale * ux, scale * uy, scale * uz


@kernel
def look(
    O: FloatArray, G: FloatArray, units: FloatArray, q: FloatArray, J: FloatArray, miss: FloatArray
) -> tuple[float, float, float]:
    """Write the weighted miss (6,) and its slopes (n, 6); give cost, position and angle missed."""
    n = len(q)
    r00 = r11 = r22 = 1.0
    r01 = r02 = r10 = r12 = r20 = r21 = x = y = z = 0.0
    for k in range(n + 1):
        o0, o1, o2 = O[k, 0], O[k, 1], O[k, 2]
        o3, o4, o5 = O[k, 3], O[k, 4], O[k, 5]
        o6, o7, o8 = O[k, 6], O[k, 7], O[k, 8]
        px, py, pz = O[k, 9], O[k, 10], O[k, 11]
        x += r00 * px + r01 * py + r02 * pz
        y += r10 * px + r11 * py + r12 * pz
        z += r20 * px + r21 * py + r22 * pz
        a00 = r00 * o0 + r01 * o3 + r02 * o6
        a01 = r00 * o1 + r01 * o4 + r02 * o7
        r02 = r00 * o2 + r01 * o5 + r02 * o8
        a10 = r10 * o0 + r11 * o3 + r12 * o6
        a11 = r10 * o1 + r11 * o4 + r12 * o7
        r12 = r10 * o2 + r11 * o5 + r12 * o8
        a20 = r20 * o0 + r21 * o3 + r22 * o6
        a21 = r20 * o1 + r21 * o4 + r22 * o7
        r22 = r20 * o2 + r21 * o5 + r22 * o8
        if k < n and O[k, 12] == 0.0:
            s, c = sine_and_cosine(q[k])
            r00 = a00 * c + a01 * s
            r01 = a01 * c - a00 * s
            r10 = a10 * c + a11 * s
            r11 = a11 * c - a10 * s
            r20 = a20 * c + a21 * s
            r21 = a21 * c - a20 * s
        else:
            r00, r01, r10, r11, r20, r21 = a00, a01, a10, a11, a20, a21
            if k < n:
                x += q[k] * r02
                y += q[k] * r12
                z += q[k] * r22
        if k < n:
            J[k, 0], J[k, 1], J[k, 2] = x, y, z
            J[k, 3], J[k, 4], J[k, 5] = r02, r12, r22
    wp, wo = G[12], G[13]
    dx, dy, dz = G[0] - x, G[1] - y, G[2] - z
    ux = uy = uz = 0.0
    if wo != 0.0:
        ux, uy, uz = rotation_vector(
            G[3] * r00 + G[4] * r01 + G[5] * r02,
            G[3] * r10 + G[4] * r11 + G[5] * r12,
            G[3] * r20 + G[4] * r21 + G[5] * r22,
            G[6] * r00 + G[7] * r01 + G[8] * r02,
            G[6] * r10 + G[7] * r11 + G[8] * r12,
            G[6] * r20 + G[7] * r21 + G[8] * r22,
            G[9] * r00 + G[10] * r01 + G[11] * r02,
            G[9] * r10 + G[10] * r11 + G[11] * r12,
            G[9] * r20 + G[10] * r21 + G[11] * r22,
        )
    miss[0], miss[1], miss[2] = wp * dx, wp * dy, wp * dz
    miss[3], miss[4], miss[5] = wo * ux, wo * uy, wo * uz
    for k in range(n):
        lever_x, lever_y, lever_z = x - J[k, 0], y - J[k, 1], z - J[k, 2]
        ax, ay, az = J[k, 3], J[k, 4], J[k, 5]
        u = units[k]
        if O[k, 12] == 0.0:
            J[k, 0] = wp * u * (ay * lever_z - az * lever_y)
            J[k, 1] = wp * u * (az * lever_x - ax * lever_z)
            J[k, 2] = wp * u * (ax * lever_y - ay * lever_x)
            J[k, 3], J[k, 4], J[k, 5] = wo * u * ax, wo * u * ay, wo * u * az
        else:
            J[k, 0], J[k, 1], J[k, 2] = wp * u * ax, wp * u * ay, wp * u * az
            J[k, 3] = J[k, 4] = J[k, 5] = 0.0
    place = dx * dx + dy * dy + dz * dz
    turn = ux * ux + uy * uy + uz * uz
    return 0.5 * (wp * wp * place + wo * wo * turn), sqrt(place), sqrt(turn)


@kernel
def _solve(N: FloatArray, L: FloatArray, free: FloatArray, damping: float, b: FloatArray) -> None:
    """Solve (N + damping) x = b for the free joints, in place, by Cholesky; the others get 0."""
    n = len(b)
    trace = 0.0
    for i in range(n):
        trace += N[i, i] * free[i]
    floor = _ROUNDING * trace
    for j in range(n):
        if free[j] == 0.0:
            b[j] = 0.0
            for i in range(j):
                L[j, i] = 0.0
            for i in range(j + 1, n):
                L[i, j] = 0.0
            L[j, j] = 1.0
            continue
        pivot = N[j, j] + damping + floor
        for k in range(j):
            pivot -= L[j, k] * L[j, k]
        # what rounding leaves of a direction that is lost
        inverse = 1.0 / sqrt(max(pivot, 0.1 * floor + 1e-300))
        L[j, j] = inverse
        for i in range(j + 1, n):
            value = N[i, j] * free[i]
            for k in range(j):
                value -= L[i, k] * L[j, k]
            L[i, j] = value * inverse
    for i in range(n):
        value = b[i]
        for k in range(i):
            value -= L[i, k] * b[k]
        b[i] = value * L[i, i]
    for i in range(n - 1, -1, -1):
        value = b[i]
        for k in range(i + 1, n):
            value -= L[k, i] * b[k]
        b[i] = value * L[i, i]


@kernel
def _step(
    J: FloatArray,
    A: FloatArray,
    V: FloatArray,
    q: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    units: FloatArray,
    damping: float,
) -> float:
    """Write the damped step of the free joints (V[2]) into V[1]; give its largest entry.

    Taken are the slope of the cost V[0] and which joints are free V[2]; a joint that would pass
    its limit goes to it, and the others make up for it.
    """
    n = len(q)
    N, L = A[0], A[1]
    slope, step, free, solved = V[0], V[1], V[2], V[3]
    for i in range(n):
        step[i] = 0.0
        for j in range(i + 1):
            N[i, j] = (
                J[i, 0] * J[j, 0]
                + J[i, 1] * J[j, 1]
                + J[i, 2] * J[j, 2]
                + J[i, 3] * J[j, 3]
                + J[i, 4] * J[j, 4]
                + J[i, 5] * J[j, 5]
            )
            N[j, i] = N[i, j]
    for _ in range(n):
        for i in range(n):
            solved[i] = slope[i]
        _solve(N, L, free, damping, solved)
        over = False
        left = False
        for i in range(n):
            if free[i] == 0.0:
                continue
            step[i] = solved[i] * units[i]
            there = q[i] + step[i]
            if there < lower[i] or there > upper[i]:
                over = True
                room = (upper[i] if step[i] > 0.0 else lower[i]) - q[i]
                step[i] = room
                free[i] = -1.0
            else:
                left = True
        if not over:
            break
        for i in range(n):
            if free[i] == -1.0:
                free[i] = 0.0
                for j in range(n):
                    slope[j] -= N[j, i] * step[i] / units[i]
        if not left:
            break
    biggest = 0.0
    for i in range(n):
        biggest = max(biggest, abs(step[i] / units[i]))
    return biggest


@kernel
def descend(
    O: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    units: FloatArray,
    G: FloatArray,
    q: FloatArray,
    max_step: float,
    max_iterations: int,
    work: Workspace,
) -> tuple[float, float, float, int, bool]:
    """Go down from ``q``, in place, until the goal is met or nothing helps.

    Gives cost, position error, orientation error, steps and whether it is at rest.
    """
    slopes, misses, places, A, V = work
    n = len(q)
    here = 0
    for k in range(n):
        places[0, k] = q[k]
    cost, position, angle = look(O, G, units, places[0], slopes[0], misses[0])
    kept_cost, kept_position, kept_angle = np.inf, 0.0, 0.0
    damping, stalled, nudged, at_rest = _FIRST_DAMPING, 0, False, False
    iteration = 0
    while iteration < max_iterations:
        if position <= _POLISH * G[14] and angle <= _POLISH * G[15]:
            kept_cost = np.inf
            at_rest = True
            break
        J, miss, there = slopes[here], misses[here], places[here]
        steepest = 0.0
        for k in range(n):
            slope = (
                J[k, 0] * miss[0]
                + J[k, 1] * miss[1]
                + J[k, 2] * miss[2]
                + J[k, 3] * miss[3]
                + J[k, 4] * miss[4]
                + J[k, 5] * miss[5]
            )
            V[0, k] = slope
            at_limit = (there[k] <= lower[k] and slope < 0.0) or (
                there[k] >= upper[k] and slope > 0.0
            )
            V[2, k] = 0.0 if at_limit else 1.0
            if not at_limit:
                steepest = max(steepest, abs(slope))
        if steepest <= _REST * sqrt(2.0 * cost):
            if nudged or (position <= G[14] and angle <= G[15]):
                at_rest = True
                break
            # a stretched arm, or one exactly between two ways, feels no slope: give it one
            nudged = True
            kept_cost, kept_position, kept_angle = cost, position, angle
            for k in range(n):
                places[2, k] = there[k]
                bend = 0.05 * units[k] * cos((k + 1.0) * (k + 1.0))
                moved = min(max(there[k] + bend, lower[k]), upper[k])
                if moved == there[k]:
                    moved = min(max(there[k] - bend, lower[k]), upper[k])
                places[here, k] = moved
            cost, position, angle = look(O, G, units, there, J, miss)
            iteration += 1
            continue
        biggest = _step(J, A, V, there, lower, upper, units, damping * cost)
        share = max_step / biggest if biggest > max_step else 1.0
        next_ = 1 - here
        for k in range(n):
            places[next_, k] = min(max(there[k] + share * V[1, k], lower[k]), upper[k])
        tried, tried_position, tried_angle = look(
            O, G, units, places[next_], slopes[next_], misses[next_]
        )
        iteration += 1
        if tried < cost:
            stalled = 0 if tried < (1.0 - _STALL) * cost else stalled + 1
            damping = max(0.3 * damping, _LEAST_DAMPING)
            here, cost, position, angle = next_, tried, tried_position, tried_angle
        elif (position <= G[14] and angle <= G[15]) or biggest < _NO_STEP:
            at_rest = True
            break
        else:
            damping *= 5.0
        if stalled >= _PATIENCE:
            at_rest = True
            break
    if kept_cost <= cost:
        here, cost, position, angle = 2, kept_cost, kept_position, kept_angle
    for k in range(n):
        q[k] = places[here, k]
    return cost, position, angle, iteration, at_rest or (position <= G[14] and angle <= G[15])
