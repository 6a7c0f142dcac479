"""Arms of four and five joints whose second to fourth axes are parallel, and planar arms.

Their poses seldom exist as a whole, so each function meets a part of the target: see module
closed_form for the words. Rows of results are as in module parallel_kernel; joints that an arm
does not have stay at zero. ``T`` is the pose of the last row's frame in the first's; ``tool`` the
pose of the tool in the last row's frame. An arm of four joints has ``five`` False.
"""

import math

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .parallel_kernel import planar_three
from .subproblem_kernel import circle, turn

_STRAIGHT = 1e-10
_OBLIQUE = 1e-9


@kernel
def size_of(P: FloatArray) -> float:
    """Give what lengths of the arm are small against."""
    total = 0.0
    for k in range(4):
        total += abs(P[k, 0]) + abs(P[k, 1])
    return total


@kernel
def planar(
    P: FloatArray,
    c0: float,
    s0: float,
    cf: float,
    sf: float,
    c4: float,
    s4: float,
    px: float,
    py: float,
    pz: float,
    bx: float,
    by: float,
    bz: float,
    seed: FloatArray,
    out: FloatArray,
    found: int,
    code: float,
    tolerance: float,
) -> int:
    """Add the elbows for a point (px, py, pz) that joint 0, the turn f and joint 4 bring to b."""
    a0, d0, ca0, sa0 = P[0, 0], P[0, 1], P[0, 2], P[0, 3]
    ty, tz = c0 * py - s0 * px, pz - d0
    vx, vy, vz = c0 * px + s0 * py - a0, ca0 * ty + sa0 * tz, ca0 * tz - sa0 * ty
    if abs(vz - P[1, 1] - P[2, 1] - bz) > tolerance:
        return found
    row = out[len(out) - 1]
    row[0], row[1], row[8], row[9] = c0, s0, c4, s4
    rx, ry = vx - cf * bx + sf * by, vy - sf * bx - cf * by
    begin = found
    found = planar_three(row, P[1, 0], P[2, 0], rx, ry, cf, sf, seed, out, found, code)
    for k in range(begin, found):
        out[k, 13] = 0.0 if out[k, 13] < tolerance else 1.0
    return found


@kernel
def ahead(
    P: FloatArray, px: float, py: float, pz: float, bz: float, size: float, seed: float
) -> tuple[int, float, float, float, float]:
    """Solve joint 0 for a point at the height bz over the plane of the parallel joints."""
    ca0, sa0 = P[0, 2], P[0, 3]
    height = P[1, 1] + P[2, 1] + bz - ca0 * (pz - P[0, 1])
    return circle(-sa0 * py, sa0 * px, height, size, seed)


@kernel
def point_of(
    P: FloatArray, five: bool, c4: float, s4: float, l0: float, l1: float, l2: float
) -> tuple[float, float, float]:
    """Give a point l of the last frame in the frame that the turn f leads to."""
    if not five:
        return l0, l1, l2
    x, y = c4 * l0 - s4 * l1, s4 * l0 + c4 * l1
    ca, sa = P[3, 2], P[3, 3]
    return P[3, 0] + x, ca * y - sa * l2, P[3, 1] + sa * y + ca * l2


@kernel
def whole(
    P: FloatArray, five: bool, T: FloatArray, seed: FloatArray, out: FloatArray, tolerance: float
) -> int:
    """Give the branches that meet the whole pose; it exists for few."""
    size = size_of(P)
    bx, by, bz = point_of(P, five, 1.0, 0.0, 0.0, 0.0, 0.0)
    n0, c0, s0, c0b, s0b = ahead(P, T[0, 3], T[1, 3], T[2, 3], bz, size, seed[0])
    square = T[0, 3] * T[0, 3] + T[1, 3] * T[1, 3]
    if n0 and P[0, 3] * P[0, 3] * square <= 1e-16 * size * size:
        # the point is on the first axis: the orientation alone says where the arm looks
        level = (P[3, 2] if five else 1.0) - P[0, 2] * T[2, 2]
        n0, c0, s0, c0b, s0b = circle(-P[0, 3] * T[1, 2], P[0, 3] * T[0, 2], level, 1.0, seed[0])
    found = 0
    for i in range(n0):
        if i:
            c0, s0 = c0b, s0b
        found = _with_first(P, five, T, c0, s0, bx, by, bz, seed, out, found, 4.0 * i, tolerance)
    return found


@kernel
def _with_first(
    P: FloatArray,
    five: bool,
    T: FloatArray,
    c0: float,
    s0: float,
    bx: float,
    by: float,
    bz: float,
    seed: FloatArray,
    out: FloatArray,
    found: int,
    code: float,
    tolerance: float,
) -> int:
    """Add the branches that meet the whole pose with joint 0 given."""
    ca0, sa0 = P[0, 2], P[0, 3]
    yx, yy, zx, zy = -ca0 * s0, ca0 * c0, sa0 * s0, -sa0 * c0
    q13 = c0 * T[0, 2] + s0 * T[1, 2]
    q23 = yx * T[0, 2] + yy * T[1, 2] + sa0 * T[2, 2]
    q33 = zx * T[0, 2] + zy * T[1, 2] + ca0 * T[2, 2]
    if five:
        cf, sf = turn(0.0, -P[3, 3], q13, q23, 1.0, seed[1] + seed[2] + seed[3])
        m1 = zx * T[0, 0] + zy * T[1, 0] + ca0 * T[2, 0]
        m2 = zx * T[0, 1] + zy * T[1, 1] + ca0 * T[2, 1]
        c4, s4 = turn(m1, m2, 0.0, P[3, 3], 1.0, seed[4])
        miss = abs(sf * P[3, 3] - q13) + abs(cf * P[3, 3] + q23) + abs(q33 - P[3, 2])
    else:
        q11 = c0 * T[0, 0] + s0 * T[1, 0]
        q21 = yx * T[0, 0] + yy * T[1, 0] + sa0 * T[2, 0]
        cf, sf = turn(1.0, 0.0, q11, q21, 1.0, 0.0)
        c4, s4 = 1.0, 0.0
        miss = abs(q33 - 1.0) + abs(q13) + abs(q23) + abs(cf - q11) + abs(sf - q21)
    if miss > tolerance:
        return found
    px, py, pz = T[0, 3], T[1, 3], T[2, 3]
    return planar(
        P, c0, s0, cf, sf, c4, s4, px, py, pz, bx, by, bz, seed, out, found, code, tolerance
    )


@kernel
def level(
    P: FloatArray,
    five: bool,
    p: FloatArray,
    m: FloatArray,
    tool: FloatArray,
    seed: FloatArray,
    out: FloatArray,
    tolerance: float,
) -> int:
    """Give the branches that meet the point ``p`` and the first axis seen from the last frame, m.

    That is the pose but for a turn about the first axis.
    """
    size = size_of(P)
    ca0, sa0 = P[0, 2], P[0, 3]
    ca3, sa3 = (P[3, 2], P[3, 3]) if five else (1.0, 0.0)
    across = math.sqrt(m[0] * m[0] + m[1] * m[1])
    n, cf, sf = 1, 1.0, 0.0
    if five:
        cf = (ca0 * ca3 - m[2]) / (sa0 * sa3)
        if ca0 == 0.0 and ca3 == 0.0:
            sf = across
        else:
            room = (1.0 - cf) * (1.0 + cf)
            if room < -1e-9:
                return 0
            sf = math.sqrt(max(room, 0.0))
        short = 1.0 / math.sqrt(cf * cf + sf * sf)
        cf, sf = cf * short, sf * short
        n = 1 if sf <= _STRAIGHT else 2
    else:
        # seen from the arm the first axis turns against it
        cf, sf = turn(m[0], m[1], 0.0, sa0, 1.0, 0.0)
        if abs(m[2] - ca0) > tolerance:
            return 0
    found = 0
    for i in range(n):
        if i:
            sf = -sf
        c4, s4 = 1.0, 0.0
        if five:
            k1, k2 = sa0 * sf, sa0 * cf * ca3 + ca0 * sa3
            if across > _STRAIGHT:
                c4, s4 = turn(m[0], m[1], k1, k2, 1.0, seed[4])
            else:
                c4, s4 = math.cos(seed[4]), math.sin(seed[4])
        found = _anywhere(P, five, p, cf, sf, c4, s4, tool, size, seed, out, found, i, tolerance)
    return found


@kernel
def _anywhere(
    P: FloatArray,
    five: bool,
    p: FloatArray,
    cf: float,
    sf: float,
    c4: float,
    s4: float,
    tool: FloatArray,
    size: float,
    seed: FloatArray,
    out: FloatArray,
    found: int,
    i: int,
    tolerance: float,
) -> int:
    """Add the branches that meet the point with the turn f and joint 4 given."""
    bx, by, bz = point_of(P, five, c4, s4, tool[0, 3], tool[1, 3], tool[2, 3])
    n0, c0, s0, c0b, s0b = ahead(P, p[0], p[1], p[2], bz, size, seed[0])
    for j in range(n0):
        if j:
            c0, s0 = c0b, s0b
        found = planar(
            P, c0, s0, cf, sf, c4, s4, p[0], p[1], p[2], bx, by, bz, seed, out, found,
            4.0 * j + i, tolerance,
        )  # fmt: skip
    return found


@kernel
def pitched(
    P: FloatArray,
    five: bool,
    p: FloatArray,
    pitch: float,
    axis: FloatArray,
    tool: FloatArray,
    seed: FloatArray,
    out: FloatArray,
    tolerance: float,
) -> int:
    """Give the branches that meet the point and the sine of the pitch of an axis of the tool.

    ``axis`` is given in the last frame; joint 4 keeps its seed.
    """
    size = size_of(P)
    c4, s4 = (math.cos(seed[4]), math.sin(seed[4])) if five else (1.0, 0.0)
    x, y, z = axis[0], axis[1], axis[2]
    if five:
        x, y = c4 * x - s4 * y, s4 * x + c4 * y
        y, z = P[3, 2] * y - P[3, 3] * z, P[3, 3] * y + P[3, 2] * z
    n, cf, sf, cfb, sfb = circle(
        P[0, 3] * y, P[0, 3] * x, pitch - P[0, 2] * z, 1.0, seed[1] + seed[2] + seed[3]
    )
    found = 0
    for i in range(n):
        if i:
            cf, sf = cfb, sfb
        found = _anywhere(P, five, p, cf, sf, c4, s4, tool, size, seed, out, found, i, tolerance)
    return found


@kernel
def pointed(
    P: FloatArray,
    p: FloatArray,
    T: FloatArray,
    tool: FloatArray,
    seed: FloatArray,
    out: FloatArray,
    tolerance: float,
) -> int:
    """Give the branches of five joints that meet the point and the direction of the last axis.

    ``T`` has that direction as its third column. Where the tool point is beside the last axis,
    joint 4 turns it to where it shall be; else joint 4 keeps its seed.
    """
    size = size_of(P)
    ca0, sa0, ca3, sa3 = P[0, 2], P[0, 3], P[3, 2], P[3, 3]
    nx, ny, nz = T[0, 2], T[1, 2], T[2, 2]
    lx, ly = tool[0, 3], tool[1, 3]
    beside = math.sqrt(lx * lx + ly * ly)
    upright = math.sqrt(nx * nx + ny * ny)
    found = 0
    c4, s4 = math.cos(seed[4]), math.sin(seed[4])
    fixed = beside <= _OBLIQUE * size or upright <= _STRAIGHT
    if fixed:
        _, _, bz = point_of(P, True, c4, s4, lx, ly, tool[2, 3])
        n0, c0, s0, c0b, s0b = ahead(P, p[0], p[1], p[2], bz, size, seed[0])
        if n0 and p[0] * p[0] + p[1] * p[1] <= 1e-16 * size * size:
            n0, c0, s0, c0b, s0b = circle(-sa0 * ny, sa0 * nx, ca3 - ca0 * nz, 1.0, seed[0])
    else:
        n0, c0, s0, c0b, s0b = circle(-sa0 * ny, sa0 * nx, ca3 - ca0 * nz, 1.0, seed[0])
    for i in range(n0):
        if i:
            c0, s0 = c0b, s0b
        zx, zy = sa0 * s0, -sa0 * c0
        q13 = c0 * nx + s0 * ny
        q23 = -ca0 * s0 * nx + ca0 * c0 * ny + sa0 * nz
        if abs(zx * nx + zy * ny + ca0 * nz - ca3) > tolerance:
            continue
        cf, sf = turn(0.0, -sa3, q13, q23, 1.0, 0.0)
        n4, c4b, s4b = 1, c4, s4
        c, s = c4, s4
        if not fixed:
            over = zx * p[0] + zy * p[1] + ca0 * (p[2] - P[0, 1])
            over -= P[1, 1] + P[2, 1] + P[3, 1] + ca3 * tool[2, 3]
            n4, c, s, c4b, s4b = circle(sa3 * ly, sa3 * lx, over, beside, seed[4])
        for j in range(n4):
            if j:
                c, s = c4b, s4b
            bx, by, bz = point_of(P, True, c, s, lx, ly, tool[2, 3])
            found = planar(
                P, c0, s0, cf, sf, c, s, p[0], p[1], p[2], bx, by, bz, seed, out, found,
                4.0 * i + j, tolerance,
            )  # fmt: skip
    return found
