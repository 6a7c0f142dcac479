"""Blocks of poses of six joints, structure of arrays, so that the loops become vector code.

The formulas are those of modules wrist_kernel and parallel_kernel without a branch: a root that
does not exist is marked by a large miss, and a pose near to a singular one is marked to be solved
by those modules instead.

``t`` (12, w): the poses in the frames of module gauge, rotation row-major, then translation;
``xy`` (2, 34, w): cosines and sines; ``miss`` (8, w); ``redo`` (w).
"""

import math

from splinearm.arrays import FloatArray
from splinearm.compiled import fast_kernel

from .subproblem_kernel import SLACK

WIDTH = 32
"""Poses in a block."""
ANGLES = 34
"""Different angles that eight branches are made of."""

_TINY = 1e-300
_EDGE = 1e-10
_NEAR = 1e-4


@fast_kernel
def enter(G: FloatArray, T: FloatArray, start: int, width: int, t: FloatArray) -> None:
    """Put poses T_base_tool (m, 4, 4) from ``start`` on into the frames of module gauge."""
    for i in range(3):
        a, b, c, d = G[6 + i, 0], G[6 + i, 1], G[6 + i, 2], G[6 + i, 3]
        for w in range(width):
            P = T[start + w]
            x = a * P[0, 0] + b * P[1, 0] + c * P[2, 0]
            y = a * P[0, 1] + b * P[1, 1] + c * P[2, 1]
            z = a * P[0, 2] + b * P[1, 2] + c * P[2, 2]
            p = a * P[0, 3] + b * P[1, 3] + c * P[2, 3] + d
            t[3 * i, w] = x * G[9, 0] + y * G[10, 0] + z * G[11, 0]
            t[3 * i + 1, w] = x * G[9, 1] + y * G[10, 1] + z * G[11, 1]
            t[3 * i + 2, w] = x * G[9, 2] + y * G[10, 2] + z * G[11, 2]
            t[9 + i, w] = x * G[9, 3] + y * G[10, 3] + z * G[11, 3] + p


@fast_kernel
def shoulder(
    P: FloatArray,
    height: float,
    width: int,
    t: FloatArray,
    X: FloatArray,
    Y: FloatArray,
    v: FloatArray,
    lost: FloatArray,
    redo: FloatArray,
) -> None:
    """Give both first joints in rows 0 and 1 of ``X`` and ``Y``, and the target seen from them.

    ``v`` (2, 3, w) is the target's point in the frame behind the first joint, ``lost`` (w) large
    where there is none.
    """
    a0, d0, ca0, sa0 = P[0, 0], P[0, 1], P[0, 2], P[0, 3]
    size = 0.0
    for k in range(6):
        size += abs(P[k, 0]) + abs(P[k, 1])
    least = 1e-16 * size * size
    for w in range(width):
        ux, uy, uz = t[9, w], t[10, w], t[11, w] - d0
        A, B, C = -sa0 * uy, sa0 * ux, height - ca0 * uz
        square = A * A + B * B + _TINY
        inverse = 1.0 / square
        room = 1.0 - C * C * inverse
        redo[w] = 1.0 if (square < least or abs(room) < _EDGE) else 0.0
        lost[w] = 1.0 if room < -SLACK else 0.0
        h = math.sqrt(max(room, 0.0) * inverse)
        C *= inverse
        for i in range(2):
            c, s = A * C - B * h, B * C + A * h
            h = -h
            X[i, w], Y[i, w] = c, s
            y = c * uy - s * ux
            v[i, 0, w] = c * ux + s * uy - a0
            v[i, 1, w] = ca0 * y + sa0 * uz
            v[i, 2, w] = ca0 * uz - sa0 * y


@fast_kernel
def spherical(
    P: FloatArray,
    width: int,
    t: FloatArray,
    X: FloatArray,
    Y: FloatArray,
    v: FloatArray,
    lost: FloatArray,
    redo: FloatArray,
    miss: FloatArray,
) -> None:
    """Solve the rest of a spherical wrist whose axes are square, second and third parallel."""
    ca0, sa0, a1, d1 = P[0, 2], P[0, 3], P[1, 0], P[1, 1]
    a2, d2, ca2, sa2, d3 = P[2, 0], P[2, 1], P[2, 2], P[2, 3], P[3, 1]
    sa3, sa4 = P[3, 3], P[4, 3]
    wx, wy, wz = a2, -sa2 * d3, d2 + ca2 * d3
    w2 = wx * wx + wy * wy
    inverse = 1.0 / w2
    least = 1e-16 * w2 * w2
    for i in range(2):
        for j in range(2):
            sense = 1.0 - 2.0 * j
            arm = 2 * i + j
            for w in range(width):
                vx, vy = v[i, 0, w], v[i, 1, w]
                C = (vx * vx + vy * vy - a1 * a1 - w2) / (2.0 * a1)
                room = 1.0 - C * C * inverse
                h = sense * math.sqrt(max(room, 0.0) * inverse)
                C *= inverse
                c2, s2 = wx * C + wy * h, wx * h - wy * C
                gone = lost[w] + (1.0 if room < -SLACK else 0.0)
                zx, zy = a1 + c2 * wx - s2 * wy, s2 * wx + c2 * wy
                c1, s1 = zx * vx + zy * vy, zx * vy - zy * vx
                square = c1 * c1 + s1 * s1 + _TINY
                short = 1.0 / math.sqrt(square)
                c1, s1 = c1 * short, s1 * short
                redo[w] += 1.0 if (abs(room) < _EDGE or square < least) else 0.0
                gone += abs(c1 * zx - s1 * zy - vx) + abs(s1 * zx + c1 * zy - vy)
                gone += abs(v[i, 2, w] - d1 - wz)
                # axes of the third frame in that behind the first joint, then in the first
                c12, s12 = c1 * c2 - s1 * s2, s1 * c2 + c1 * s2
                c0, s0 = X[i, w], Y[i, w]
                fx, fy = -ca0 * s0, ca0 * c0
                gx, gy = sa0 * s0, -sa0 * c0
                xx, xy, xz = c12 * c0 + s12 * fx, c12 * s0 + s12 * fy, s12 * sa0
                ex, ey, ez = c12 * fx - s12 * c0, c12 * fy - s12 * s0, c12 * sa0
                yx, yy, yz = ca2 * ex + sa2 * gx, ca2 * ey + sa2 * gy, ca2 * ez + sa2 * ca0
                zx, zy, zz = ca2 * gx - sa2 * ex, ca2 * gy - sa2 * ey, ca2 * ca0 - sa2 * ez
                m11 = xx * t[0, w] + xy * t[3, w] + xz * t[6, w]
                m21 = yx * t[0, w] + yy * t[3, w] + yz * t[6, w]
                m31 = zx * t[0, w] + zy * t[3, w] + zz * t[6, w]
                m32 = zx * t[1, w] + zy * t[4, w] + zz * t[7, w]
                m13 = xx * t[2, w] + xy * t[5, w] + xz * t[8, w]
                m23 = yx * t[2, w] + yy * t[5, w] + yz * t[8, w]
                m33 = zx * t[2, w] + zy * t[5, w] + zz * t[8, w]
                across = math.sqrt(m13 * m13 + m23 * m23)
                redo[w] += 1.0 if across < _NEAR else 0.0
                short = 1.0 / (across + _TINY)
                c4 = -m33 * sa3 * sa4
                # Rz(3) brings (s4 sa4, 0) to (m13, m23), Rz(5) brings (m31, m32) to (s4 sa3, 0)
                c3, s3 = sa4 * m13 * short, sa4 * m23 * short
                short = 1.0 / math.sqrt(m31 * m31 + m32 * m32 + _TINY)
                c5, s5 = sa3 * m31 * short, -sa3 * m32 * short
                length = 1.0 / math.sqrt(c4 * c4 + across * across + _TINY)
                s4 = across * length
                c4 *= length
                # forward again; sine of the middle joint and turns of the others change sign alike
                kx, ky, kz = c5 * c4, c5 * s4, s5 * sa4
                off = abs(c3 * kx + s3 * sa3 * kz - m11) + abs(s3 * kx - c3 * sa3 * kz - m21)
                off += abs(sa3 * ky - m31) + abs(c3 * s4 * sa4 - m13) + abs(s3 * s4 * sa4 - m23)
                off += abs(sa3 * sa4 * c4 + m33)
                X[2 + arm, w], Y[2 + arm, w] = c1, s1
                X[6 + arm, w], Y[6 + arm, w] = c2, s2
                X[10 + 2 * arm, w], Y[10 + 2 * arm, w] = c3, s3
                X[11 + 2 * arm, w], Y[11 + 2 * arm, w] = -c3, -s3
                X[18 + 2 * arm, w], Y[18 + 2 * arm, w] = c4, s4
                X[19 + 2 * arm, w], Y[19 + 2 * arm, w] = c4, -s4
                X[26 + 2 * arm, w], Y[26 + 2 * arm, w] = c5, s5
                X[27 + 2 * arm, w], Y[27 + 2 * arm, w] = -c5, -s5
                miss[2 * arm, w] = gone + off
                miss[2 * arm + 1, w] = gone + off


@fast_kernel
def three_parallel(
    P: FloatArray,
    width: int,
    t: FloatArray,
    X: FloatArray,
    Y: FloatArray,
    v: FloatArray,
    lost: FloatArray,
    redo: FloatArray,
    miss: FloatArray,
) -> None:
    """Solve the rest of an arm of three parallel axes whose wrist's axes are square."""
    ca0, sa0, a1, a2, a3 = P[0, 2], P[0, 3], P[1, 0], P[2, 0], P[3, 0]
    sa3, d4, sa4 = P[3, 3], P[4, 1], P[4, 3]
    height = P[1, 1] + P[2, 1] + P[3, 1]
    bx, by = a3, -sa3 * d4
    least = 1e-16 * (abs(a1) + abs(a2)) ** 4
    for i in range(2):
        for k in range(2):
            sense = 1.0 - 2.0 * k
            for w in range(width):
                c0, s0 = X[i, w], Y[i, w]
                fx, fy = -ca0 * s0, ca0 * c0
                gx, gy = sa0 * s0, -sa0 * c0
                q11, q12, q13 = (
                    c0 * t[0, w] + s0 * t[3, w],
                    c0 * t[1, w] + s0 * t[4, w],
                    c0 * t[2, w] + s0 * t[5, w],
                )
                q21 = fx * t[0, w] + fy * t[3, w] + sa0 * t[6, w]
                q22 = fx * t[1, w] + fy * t[4, w] + sa0 * t[7, w]
                q23 = fx * t[2, w] + fy * t[5, w] + sa0 * t[8, w]
                m1 = gx * t[0, w] + gy * t[3, w] + ca0 * t[6, w]
                m2 = gx * t[1, w] + gy * t[4, w] + ca0 * t[7, w]
                m3 = gx * t[2, w] + gy * t[5, w] + ca0 * t[8, w]
                across = math.sqrt(m1 * m1 + m2 * m2)
                redo[w] += 1.0 if across < _NEAR else 0.0
                c4 = -m3 * sa3 * sa4
                length = 1.0 / math.sqrt(c4 * c4 + across * across + _TINY)
                s4 = sense * across * length
                c4 *= length
                short = sense * sa3 / (across + _TINY)
                c5, s5 = m1 * short, -m2 * short
                # Rz(f) brings the columns of Rx(alpha3) Rz(4) Rx(alpha4) Rz(5) to those of q
                e11, e12, e21, e22 = (
                    c5 * c4,
                    -s5 * c4,
                    -s5 * sa3 * sa4,
                    -c5 * sa3 * sa4,
                )
                g13 = s4 * sa4
                cf = e11 * q11 + e21 * q21 + e12 * q12 + e22 * q22 + g13 * q13
                sf = e11 * q21 - e21 * q11 + e12 * q22 - e22 * q12 + g13 * q23
                length = 1.0 / math.sqrt(cf * cf + sf * sf + _TINY)
                cf, sf = cf * length, sf * length
                gone = lost[w] + abs(v[i, 2, w] - height)
                gone += abs(cf * e11 - sf * e21 - q11) + abs(sf * e11 + cf * e21 - q21)
                gone += abs(cf * g13 - q13) + abs(sf * g13 - q23)
                gone += abs(c5 * s4 * sa3 - m1) + abs(s5 * s4 * sa3 + m2)
                rx = v[i, 0, w] - cf * bx + sf * by
                ry = v[i, 1, w] - sf * bx - cf * by
                c2 = (rx * rx + ry * ry - a1 * a1 - a2 * a2) / (2.0 * a1 * a2)
                room = 1.0 - c2 * c2
                gone += 1.0 if room < -SLACK else 0.0
                s2 = math.sqrt(max(room, 0.0))
                redo[w] += 1.0 if abs(room) < _EDGE else 0.0
                pair = 2 * i + k
                X[2 + pair, w], Y[2 + pair, w] = c4, s4
                X[6 + pair, w], Y[6 + pair, w] = c5, s5
                for j in range(2):
                    # the first root is the one that circle gives for a2 cos = reach
                    turned = s2 if (j == 0) == (a2 > 0.0) else -s2
                    zx, zy = a1 + a2 * c2, a2 * turned
                    c1, s1 = zx * rx + zy * ry, zx * ry - zy * rx
                    square = c1 * c1 + s1 * s1 + _TINY
                    redo[w] += 1.0 if square < least else 0.0
                    short = 1.0 / math.sqrt(square)
                    c1, s1 = c1 * short, s1 * short
                    c12, s12 = c1 * c2 - s1 * turned, s1 * c2 + c1 * turned
                    row = 2 * pair + j
                    X[10 + row, w], Y[10 + row, w] = c1, s1
                    X[18 + row, w], Y[18 + row, w] = c2, turned
                    X[26 + row, w] = cf * c12 + sf * s12
                    Y[26 + row, w] = sf * c12 - cf * s12
                    end = abs(a1 * c1 + a2 * c12 - rx) + abs(a1 * s1 + a2 * s12 - ry)
                    miss[row, w] = gone + end
