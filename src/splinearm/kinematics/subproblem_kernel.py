"""The subproblems that closed forms are made of, on cosines and sines instead of angles.

After B. Paden, Kinematics and Control of Robot Manipulators, 1986 (with W. Kahan), and
A. Elias and J. Wen, IK-Geo: Unified robot inverse kinematics using subproblem decomposition,
Mechanism and Machine Theory 209, 2025. In the frames of module gauge every joint turns about z, so
that their subproblems 1 (turn one vector onto another), 3 (distance) and 4 (height) become the two
functions here, and 2 (two axes that meet) is one after the other.
"""

import math

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

FREE = 1e-10
"""Below this share of its size an equation says nothing of its joint."""
SLACK = 1e-9
"""By which share an equation may miss and count as met at its boundary."""
_ONE = 1e-14
"""Below this square of their sine two roots are one."""


@kernel
def circle(
    a: float, b: float, c: float, size: float, seed: float
) -> tuple[int, float, float, float, float]:
    """Solve a cos + b sin = c: give the number of roots and the cosine and sine of both.

    ``size`` is what a and b are small against; a joint that the equation leaves free takes the
    angle ``seed``.
    """
    square = a * a + b * b
    if square <= FREE * FREE * size * size:
        if abs(c) > SLACK * size:
            return 0, 1.0, 0.0, 1.0, 0.0
        return 1, math.cos(seed), math.sin(seed), 1.0, 0.0
    inverse = 1.0 / square
    room = 1.0 - c * c * inverse
    if room < -SLACK:
        return 0, 1.0, 0.0, 1.0, 0.0
    if room <= _ONE:
        short = 1.0 / math.sqrt(square)
        if c < 0.0:
            short = -short
        return 1, a * short, b * short, 1.0, 0.0
    h = math.sqrt(room * inverse)
    c *= inverse
    # the first root turns against the clock from the direction (a, b), the second with it
    return 2, a * c - b * h, b * c + a * h, a * c + b * h, b * c - a * h


@kernel
def turn(x: float, y: float, u: float, v: float, size: float, seed: float) -> tuple[float, float]:
    """Give cosine and sine of the turn that brings (x, y) to the direction of (u, v).

    Where one of them is of no length the turn is free: it takes the angle ``seed``.
    """
    c, s = x * u + y * v, x * v - y * u
    square = c * c + s * s
    limit = FREE * size
    if square <= limit * limit * limit * limit:
        return math.cos(seed), math.sin(seed)
    short = 1.0 / math.sqrt(square)
    return c * short, s * short


@kernel
def wrap(angle: float) -> float:
    """Give an angle as its equal in -pi to pi."""
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)


@kernel
def product(P: FloatArray, Q: FloatArray, out: FloatArray) -> None:
    """Give the product of two rigid transforms in ``out``; its last row is left alone."""
    for i in range(3):
        a, b, c = P[i, 0], P[i, 1], P[i, 2]
        for j in range(3):
            out[i, j] = a * Q[0, j] + b * Q[1, j] + c * Q[2, j]
        out[i, 3] = a * Q[0, 3] + b * Q[1, 3] + c * Q[2, 3] + P[i, 3]


@kernel
def inverse(P: FloatArray, out: FloatArray) -> None:
    """Give the inverse of a rigid transform in ``out``; its last row is left alone."""
    for i in range(3):
        for j in range(3):
            out[i, j] = P[j, i]
        out[i, 3] = -(P[0, i] * P[0, 3] + P[1, i] * P[1, 3] + P[2, i] * P[2, 3])
