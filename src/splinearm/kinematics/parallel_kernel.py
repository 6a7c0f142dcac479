"""Arms whose second, third and fourth axes are parallel: six joints (UR), five and four.

The axes that are parallel leave heights along them and turns about them alone: the joints around
them follow from these, and the three themselves are a planar arm. After A. Elias and J. Wen,
IK-Geo, 2025, section 4 (three parallel axes), written out in the frames of module gauge. ``T`` is
the pose of the last row's frame in the first's.
"""

import math

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .subproblem_kernel import circle, turn

_STRAIGHT = 1e-10


@kernel
def planar_three(
    row: FloatArray,
    a1: float,
    a2: float,
    rx: float,
    ry: float,
    cf: float,
    sf: float,
    seed: FloatArray,
    out: FloatArray,
    found: int,
    code: float,
) -> int:
    """Add the elbows of the planar arm of joints 1, 2, 3 that reach (rx, ry) with turn f in all.

    ``row`` holds the other joints; new rows are written to ``out`` from ``found`` on.
    """
    size = abs(a1) + abs(a2)
    reach = (rx * rx + ry * ry - a1 * a1 - a2 * a2) / (2.0 * a1)
    n2, c2, s2, c2b, s2b = circle(a2, 0.0, reach, size, seed[2])
    for i in range(n2):
        if i:
            c2, s2 = c2b, s2b
        c1, s1 = turn(a1 + a2 * c2, a2 * s2, rx, ry, size, seed[1])
        c12, s12 = c1 * c2 - s1 * s2, s1 * c2 + c1 * s2
        to = out[found]
        for k in range(12):
            to[k] = row[k]
        to[2], to[3], to[4], to[5] = c1, s1, c2, s2
        to[6], to[7] = cf * c12 + sf * s12, sf * c12 - cf * s12
        to[12] = code + 2.0 * i
        # forward again: does the planar arm end where it shall?
        miss = abs(a1 * c1 + a2 * c12 - rx) + abs(a1 * s1 + a2 * s12 - ry)
        to[13] = miss
        found += 1
    return found


@kernel
def turn_to_reach(
    vx: float, vy: float, bx: float, by: float, a1: float, a2: float, seed: float
) -> float:
    """Give the turn nearest to ``seed`` that leaves the planar arm (vx, vy) - Rz b in reach."""
    far, near = abs(a1) + abs(a2), abs(abs(a1) - abs(a2))
    c, s = math.cos(seed), math.sin(seed)
    rx, ry = vx - c * bx + s * by, vy - s * bx - c * by
    r = math.sqrt(rx * rx + ry * ry)
    if near <= r <= far:
        return seed
    goal = far if r > far else near
    square = vx * vx + vy * vy + bx * bx + by * by - goal * goal
    n, c, s, cb, sb = circle(vx * bx + vy * by, vy * bx - vx * by, 0.5 * square, far * far, seed)
    if n == 0:
        return seed
    one, other = math.atan2(s, c), math.atan2(sb, cb)
    if n == 2 and math.cos(other - seed) > math.cos(one - seed):
        return other
    return one


@kernel
def ur(P: FloatArray, T: FloatArray, seed: FloatArray, out: FloatArray, tolerance: float) -> int:
    """Give all branches of six joints, the axes of the last two meeting, in rows of ``out``."""
    a0, d0, ca0, sa0 = P[0, 0], P[0, 1], P[0, 2], P[0, 3]
    a1, a2, a3 = P[1, 0], P[2, 0], P[3, 0]
    ca3, sa3, d4, ca4, sa4 = P[3, 2], P[3, 3], P[4, 1], P[4, 2], P[4, 3]
    height = P[1, 1] + P[2, 1] + P[3, 1] + ca3 * d4
    ux, uy, uz = T[0, 3], T[1, 3], T[2, 3] - d0
    size = abs(a0) + abs(a1) + abs(a2) + abs(a3) + abs(height) + abs(d4)
    bx, by = a3, -sa3 * d4
    square = ca3 == 0.0 and ca4 == 0.0
    found = 0
    row = out[15]
    n0, c0, s0, c0b, s0b = circle(-sa0 * uy, sa0 * ux, height - ca0 * uz, size, seed[0])
    for i in range(n0):
        if i:
            c0, s0 = c0b, s0b
        tx, ty = c0 * ux + s0 * uy - a0, c0 * uy - s0 * ux
        vx, vy, vz = tx, ca0 * ty + sa0 * uz, ca0 * uz - sa0 * ty
        # rows of the frame behind joint 0: x, y and the axis of the parallel joints
        yx, yy = -ca0 * s0, ca0 * c0
        zx, zy = sa0 * s0, -sa0 * c0
        q11, q12, q13 = c0 * T[0, 0] + s0 * T[1, 0], c0 * T[0, 1] + s0 * T[1, 1], 0.0
        q13 = c0 * T[0, 2] + s0 * T[1, 2]
        q21 = yx * T[0, 0] + yy * T[1, 0] + sa0 * T[2, 0]
        q22 = yx * T[0, 1] + yy * T[1, 1] + sa0 * T[2, 1]
        q23 = yx * T[0, 2] + yy * T[1, 2] + sa0 * T[2, 2]
        m1 = zx * T[0, 0] + zy * T[1, 0] + ca0 * T[2, 0]
        m2 = zx * T[0, 1] + zy * T[1, 1] + ca0 * T[2, 1]
        m3 = zx * T[0, 2] + zy * T[1, 2] + ca0 * T[2, 2]
        across = math.sqrt(m1 * m1 + m2 * m2)
        c4 = (ca3 * ca4 - m3) / (sa3 * sa4)
        room = (1.0 - c4) * (1.0 + c4)
        if square:
            s4 = across
            short = 1.0 / math.sqrt(c4 * c4 + s4 * s4)
            c4, s4 = c4 * short, s4 * short
        else:
            if room < -1e-9:
                continue
            s4 = math.sqrt(room) if room > 1e-16 else 0.0
            c4 = min(max(c4, -1.0), 1.0)
        for wrist in range(2):
            if wrist:
                if across <= _STRAIGHT or s4 == 0.0:
                    break
                s4 = -s4
            hx, hy = s4 * sa3, ca4 * c4 * sa3 + sa4 * ca3
            # columns of Rx(alpha3) Rz(4) Rx(alpha4): upper two rows
            g11, g12, g13 = c4, -s4 * ca4, s4 * sa4
            g21 = ca3 * s4
            g22 = ca3 * c4 * ca4 - sa3 * sa4
            g23 = -ca3 * c4 * sa4 - sa3 * ca4
            if across > _STRAIGHT:
                c5, s5 = turn(m1, m2, hx, hy, 1.0, seed[5])
            else:
                # axis 5 lies along the parallel ones: the last joint is free as far as the
                # planar arm reaches
                c5, s5 = _last_free(
                    g11, g12, g21, g22, q11, q12, q21, q22, vx, vy, bx, by, a1, a2, seed
                )
            e11, e12 = c5 * g11 + s5 * g12, c5 * g12 - s5 * g11
            e21, e22 = c5 * g21 + s5 * g22, c5 * g22 - s5 * g21
            cf = e11 * q11 + e21 * q21 + e12 * q12 + e22 * q22 + g13 * q13 + g23 * q23
            sf = e11 * q21 - e21 * q11 + e12 * q22 - e22 * q12 + g13 * q23 - g23 * q13
            length = math.sqrt(cf * cf + sf * sf)
            if length == 0.0:
                continue
            cf, sf = cf / length, sf / length
            miss = abs(cf * e11 - sf * e21 - q11) + abs(sf * e11 + cf * e21 - q21)
            miss += abs(cf * g13 - sf * g23 - q13) + abs(sf * g13 + cf * g23 - q23)
            miss += abs(c5 * hx + s5 * hy - m1) + abs(vz - height)
            row[0], row[1], row[8], row[9], row[10], row[11] = c0, s0, c4, s4, c5, s5
            rx, ry = vx - cf * bx + sf * by, vy - sf * bx - cf * by
            begin = found
            found = planar_three(row, a1, a2, rx, ry, cf, sf, seed, out, found, 4.0 * i + wrist)
            for k in range(begin, found):
                out[k, 13] = 0.0 if out[k, 13] + miss < tolerance else 1.0
    return found


@kernel
def _last_free(
    g11: float,
    g12: float,
    g21: float,
    g22: float,
    q11: float,
    q12: float,
    q21: float,
    q22: float,
    vx: float,
    vy: float,
    bx: float,
    by: float,
    a1: float,
    a2: float,
    seed: FloatArray,
) -> tuple[float, float]:
    """Give the last joint, nearest to its seed, when only its sum with the three matters."""
    c, s = math.cos(seed[5]), math.sin(seed[5])
    e11, e12 = c * g11 + s * g12, c * g12 - s * g11
    e21, e22 = c * g21 + s * g22, c * g22 - s * g21
    cf = e11 * q11 + e21 * q21 + e12 * q12 + e22 * q22
    sf = e11 * q21 - e21 * q11 + e12 * q22 - e22 * q12
    start = math.atan2(sf, cf)
    f = turn_to_reach(vx, vy, bx, by, a1, a2, start)
    # the turn of the last joint that leaves f: with or against it, as axis 5 lies
    cf, sf = math.cos(f), math.sin(f)
    k11, k12 = cf * q11 + sf * q21, cf * q12 + sf * q22
    k21, k22 = cf * q21 - sf * q11, cf * q22 - sf * q12
    return turn(
        1.0,
        0.0,
        g11 * k11 + g21 * k21 + g12 * k12 + g22 * k22,
        g12 * k11 + g22 * k21 - g11 * k12 - g21 * k22,
        1.0,
        seed[5],
    )
