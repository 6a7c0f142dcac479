"""Six joints with a spherical wrist: position by the first three, orientation by the last three.

After D. Pieper, The Kinematics of Manipulators under Computer Control, 1968. Everything is in the
frames of module gauge; ``T`` is the pose of the last row's frame in the first's. Results are
cosine and sine of every joint in a row.
"""

import math

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .quartic_kernel import pieper
from .subproblem_kernel import circle, turn

PARALLEL_23 = 0
"""Kind of base: the second and third axes are parallel (Puma, WidowX-250, industrial arms)."""
MEETING_12 = 1
"""Kind of base: the first and second axes meet."""
MEETING_23 = 2
"""Kind of base: the second and third axes meet."""
PARALLEL_12 = 3
"""Kind of base: the first and second axes are parallel."""
GENERAL = 4
"""Kind of base: none of these; a quartic in the third joint."""

_NEAR_STRAIGHT = 1e-4
"""Below this sine of the wrist's bend its last joint is found after its first."""
_STRAIGHT = 1e-10
"""Below this sine of the wrist's bend only the sum of two joints matters."""


@kernel
def centre(P: FloatArray) -> tuple[float, float, float]:
    """Give the wrist's centre in the frame that the third joint turns."""
    return P[2, 0], -P[2, 3] * P[3, 1], P[2, 1] + P[2, 2] * P[3, 1]


@kernel
def place(
    P: FloatArray,
    kind: int,
    wx: float,
    wy: float,
    wz: float,
    T: FloatArray,
    seed: FloatArray,
    out: FloatArray,
) -> int:
    """Put the point w that the third joint turns on the origin of ``T``: rows of three joints.

    Of the rows of ``out`` the first six columns are written, and column 12 with the branch.
    """
    a0, d0, ca0, sa0 = P[0, 0], P[0, 1], P[0, 2], P[0, 3]
    a1, d1, ca1, sa1 = P[1, 0], P[1, 1], P[1, 2], P[1, 3]
    ux, uy, uz = T[0, 3], T[1, 3], T[2, 3] - d0
    w2 = wx * wx + wy * wy
    size = abs(a0) + abs(a1) + abs(d1) + math.sqrt(w2) + abs(wz)
    found = 0
    if kind in (PARALLEL_23, MEETING_23):
        if kind == PARALLEL_23:
            A, B, C = -sa0 * uy, sa0 * ux, d1 + wz - ca0 * uz
        else:
            A = -2.0 * a0 * ux + 2.0 * d1 * sa0 * uy
            B = -2.0 * a0 * uy - 2.0 * d1 * sa0 * ux
            square = ux * ux + uy * uy + uz * uz + a0 * a0
            C = w2 + wz * wz - d1 * d1 - square + 2.0 * d1 * ca0 * uz
            A, B, C = A / size, B / size, C / size
        n0, c0, s0, c0b, s0b = circle(A, B, C, size, seed[0])
        for i in range(n0):
            if i:
                c0, s0 = c0b, s0b
            tx = c0 * ux + s0 * uy - a0
            ty = c0 * uy - s0 * ux
            vx, vy, vz = tx, ca0 * ty + sa0 * uz, ca0 * uz - sa0 * ty
            if kind == PARALLEL_23:
                reach = (vx * vx + vy * vy - a1 * a1 - w2) / (2.0 * a1)
                n2, c2, s2, c2b, s2b = circle(wx, -wy, reach, size, seed[2])
            else:
                n2, c2, s2, c2b, s2b = circle(sa1 * wy, sa1 * wx, vz - d1 - ca1 * wz, size, seed[2])
            for j in range(n2):
                if j:
                    c2, s2 = c2b, s2b
                zx, zy = c2 * wx - s2 * wy, s2 * wx + c2 * wy
                c1, s1 = turn(a1 + zx, ca1 * zy - sa1 * wz, vx, vy, size, seed[1])
                _three(out[found], c0, s0, c1, s1, c2, s2)
                out[found, 12] = 4 * i + 2 * j
                found += 1
        return found
    if kind == GENERAL:
        return pieper(P, wx, wy, wz, T, seed, out)
    if kind == MEETING_12:
        square = ux * ux + uy * uy + uz * uz - a1 * a1 - d1 * d1 - w2 - wz * wz
        n2, c2, s2, c2b, s2b = circle(
            (a1 * wx + d1 * sa1 * wy) / size,
            (d1 * sa1 * wx - a1 * wy) / size,
            (0.5 * square - d1 * ca1 * wz) / size,
            size,
            seed[2],
        )
    else:
        n2, c2, s2, c2b, s2b = circle(sa1 * wy, sa1 * wx, uz - d1 - ca1 * wz, size, seed[2])
    for i in range(n2):
        if i:
            c2, s2 = c2b, s2b
        zx, zy = c2 * wx - s2 * wy, s2 * wx + c2 * wy
        x, y, z = a1 + zx, ca1 * zy - sa1 * wz, d1 + sa1 * zy + ca1 * wz
        if kind == MEETING_12:
            n1, c1, s1, c1b, s1b = circle(sa0 * y, sa0 * x, uz - ca0 * z, size, seed[1])
        else:
            reach = ux * ux + uy * uy - a0 * a0 - x * x - y * y
            n1, c1, s1, c1b, s1b = circle(x, -y, reach / (2.0 * a0), size, seed[1])
        for j in range(n1):
            if j:
                c1, s1 = c1b, s1b
            vx, vy = c1 * x - s1 * y, s1 * x + c1 * y
            c0, s0 = turn(a0 + vx, ca0 * vy - sa0 * z, ux, uy, size, seed[0])
            _three(out[found], c0, s0, c1, s1, c2, s2)
            out[found, 12] = 4 * j + 2 * i
            found += 1
    return found


@kernel
def _three(
    row: FloatArray, c0: float, s0: float, c1: float, s1: float, c2: float, s2: float
) -> None:
    row[0], row[1], row[2], row[3], row[4], row[5] = c0, s0, c1, s1, c2, s2


@kernel
def orient(
    P: FloatArray, T: FloatArray, seed: FloatArray, out: FloatArray, found: int, tolerance: float
) -> int:
    """Turn the wrist for each of the ``found`` places; give the rows, checked, in ``out``.

    Room for twice as many rows is needed: the flipped wrists come behind the others. Column 12
    counts the branch, column 13 is 1 where the row misses the pose by more than ``tolerance``.
    """
    size = 1.0
    d3 = P[3, 1]
    ca3, sa3, ca4, sa4 = P[3, 2], P[3, 3], P[4, 2], P[4, 3]
    square = ca3 == 0.0 and ca4 == 0.0
    for k in range(found):
        row, flip = out[k], out[found + k]
        # columns of the rotation of the first three rows, and their translation
        xx, xy, xz = 1.0, 0.0, 0.0
        yx, yy, yz = 0.0, 1.0, 0.0
        zx, zy, zz = 0.0, 0.0, 1.0
        px, py, pz = 0.0, 0.0, 0.0
        for i in range(3):
            c, s = row[2 * i], row[2 * i + 1]
            a, d, ca, sa = P[i, 0], P[i, 1], P[i, 2], P[i, 3]
            ex, ey, ez = c * xx + s * yx, c * xy + s * yy, c * xz + s * yz
            fx, fy, fz = c * yx - s * xx, c * yy - s * xy, c * yz - s * xz
            px += a * ex + d * zx
            py += a * ey + d * zy
            pz += a * ez + d * zz
            xx, xy, xz = ex, ey, ez
            yx, yy, yz = ca * fx + sa * zx, ca * fy + sa * zy, ca * fz + sa * zz
            zx, zy, zz = ca * zx - sa * fx, ca * zy - sa * fy, ca * zz - sa * fz
        miss = abs(px + d3 * zx - T[0, 3]) + abs(py + d3 * zy - T[1, 3])
        miss += abs(pz + d3 * zz - T[2, 3])
        m11 = xx * T[0, 0] + xy * T[1, 0] + xz * T[2, 0]
        m21 = yx * T[0, 0] + yy * T[1, 0] + yz * T[2, 0]
        m31 = zx * T[0, 0] + zy * T[1, 0] + zz * T[2, 0]
        m32 = zx * T[0, 1] + zy * T[1, 1] + zz * T[2, 1]
        m13 = xx * T[0, 2] + xy * T[1, 2] + xz * T[2, 2]
        m23 = yx * T[0, 2] + yy * T[1, 2] + yz * T[2, 2]
        m33 = zx * T[0, 2] + zy * T[1, 2] + zz * T[2, 2]
        across = math.sqrt(m13 * m13 + m23 * m23)
        c4 = (ca3 * ca4 - m33) / (sa3 * sa4)
        room = (1.0 - c4) * (1.0 + c4)
        if square:
            s4 = across
            short = 1.0 / math.sqrt(c4 * c4 + s4 * s4)
            c4, s4 = c4 * short, s4 * short
        else:
            if room < -1e-9:
                miss = 1.0
            s4 = math.sqrt(room) if room > 1e-16 else 0.0
            c4 = min(max(c4, -1.0), 1.0)
        for wrist in range(2):
            to = row
            if wrist:
                to, s4 = flip, -s4
            gx, gy = s4 * sa4, -ca3 * c4 * sa4 - sa3 * ca4
            hx, hy = s4 * sa3, ca4 * c4 * sa3 + sa4 * ca3
            if across > _NEAR_STRAIGHT:
                c3, s3 = gx * m13 + gy * m23, gx * m23 - gy * m13
                short = 1.0 / math.sqrt(c3 * c3 + s3 * s3)
                c3, s3 = c3 * short, s3 * short
                c5, s5 = m31 * hx + m32 * hy, m31 * hy - m32 * hx
                short = 1.0 / math.sqrt(c5 * c5 + s5 * s5)
                c5, s5 = c5 * short, s5 * short
            else:
                if across > _STRAIGHT:
                    c3, s3 = turn(gx, gy, m13, m23, size, seed[3])
                else:
                    c3, s3 = math.cos(seed[3]), math.sin(seed[3])
                # what is left for the last joint: Rx(-alpha4) Rz(-4) Rx(-alpha3) Rz(-3) M
                ax, ay, az = c3 * m11 + s3 * m21, c3 * m21 - s3 * m11, m31
                ay, az = ca3 * ay + sa3 * az, ca3 * az - sa3 * ay
                ax, ay = c4 * ax + s4 * ay, c4 * ay - s4 * ax
                ay = ca4 * ay + sa4 * az
                c5, s5 = turn(1.0, 0.0, ax, ay, size, seed[5])
            # forward again: x and z columns of Rz(3) Rx Rz(4) Rx Rz(5), turned by all before
            ix, iy = c5 * c4 - s5 * ca4 * s4, c5 * s4 + s5 * ca4 * c4
            iz = s5 * sa4
            iy, iz = ca3 * iy - sa3 * iz, sa3 * iy + ca3 * iz
            jx, jy, jz = gx, gy, -sa3 * c4 * sa4 + ca3 * ca4
            off = abs(c3 * ix - s3 * iy - m11) + abs(s3 * ix + c3 * iy - m21) + abs(iz - m31)
            off += abs(c3 * jx - s3 * jy - m13) + abs(s3 * jx + c3 * jy - m23) + abs(jz - m33)
            if wrist:
                for i in range(6):
                    to[i] = row[i]
                to[12] = row[12] + 1.0
            to[6], to[7], to[8], to[9], to[10], to[11] = c3, s3, c4, s4, c5, s5
            to[13] = 0.0 if miss + off < tolerance else 1.0
            if wrist and (across <= _STRAIGHT or s4 == 0.0):
                # straight: flipped is the same with the two joints that share the turn half round
                to[13] = 1.0
    return 2 * found
