"""The farthest way of one joint in a given time, with limits of velocity, acceleration and jerk.

Among all velocities v(t) that lead from (v0, a0) to (vf, af) within T and keep the limits, a
convex set, one has the largest integral. Its jerk is +1, -1, +1 (the costate of the acceleration is
a convex parabola), with rests where the acceleration or the velocity is at its limit:

    up to a1,  h1 at a1 = 1,  down to a2 (with c at a = 0, v = top),  h2 at a2 = -1,  up to af

Units are the joint's own: the limits of acceleration and jerk are 1, ``top`` is that of velocity.
With C = vf - v0 + (a0^2 - af^2)/2 and D = (T + a0 - af)/2 the two sums over the phases read

    C = a1^2 - a2^2 + h1 - h2,    D = a1 - a2 + (h1 + h2 + c)/2

so that D alone says it all in closed form. Played backwards in time a way keeps its shape and C
changes its sign: everything here is done with C >= 0, where a2 <= -1 only once a1 = 1.
"""

import math
from typing import NamedTuple

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel


class Side(NamedTuple):
    """What the farthest way depends on, with C >= 0."""

    v0: float
    a0: float
    vf: float
    af: float
    C: float
    backwards: bool
    """Whether all this is played backwards in time."""
    a1: float
    """How far the acceleration goes up, with h1 and so on, where the top velocity is reached."""
    h1: float
    a2: float
    h2: float
    full: float
    """The D from which on the top velocity is reached."""
    top: float
    width: float
    """af - a0, so that T = 2 D + width."""


_ROUNDING = 1e-14
"""By this share of their terms differences are nothing."""

_BEND = 3.0**-0.25
"""Where neither limit of acceleration is reached, P bends over at D = _BEND sqrt(C)."""

_BEND_FREE = 4.0 / (2.0 + 4.0 / math.sqrt(3.0))
"""Up to this C, a1 <= 1 there."""

_BEND_HELD = 15.0 / 16.0
"""From this C on, P bends over where a1 = 1, at a2 = 1/4."""


@kernel
def side_of(v0: float, a0: float, vf: float, af: float, top: float) -> Side:
    """Give what the shape depends on."""
    C = vf - v0 + 0.5 * (a0 * a0 - af * af)
    backwards = False
    nothing = _ROUNDING * (abs(v0) + abs(vf) + a0 * a0 + af * af)
    if abs(C) <= nothing:
        # up all the way is a way of its own, and seen only where af is not negative
        C = 0.0
    if C < 0.0 or (C == 0.0 and af < 0.0):
        v0, a0, vf, af, C, backwards = vf, -af, v0, -a0, -C, True
    rise = max(top - v0 + 0.5 * a0 * a0, 0.0)
    fall = max(top - vf + 0.5 * af * af, 0.0)
    a1 = max(a0, min(1.0, math.sqrt(rise)))
    a2 = min(af, -min(1.0, math.sqrt(fall)))
    h1 = max(rise - a1 * a1, 0.0)
    h2 = max(fall - a2 * a2, 0.0)
    full = a1 - a2 + 0.5 * (h1 + h2)
    return Side(v0, a0, vf, af, C, backwards, a1, h1, a2, h2, full, top, af - a0)


@kernel
def shape_of(side: Side, D: float) -> tuple[float, float, float, float, float]:
    """Give a1, h1, a2, h2 and c."""
    if side.full <= D:
        return side.a1, side.h1, side.a2, side.h2, 2.0 * (D - side.full)
    C = side.C
    h1 = h2 = 0.0
    # a1 + a2, and by rounding never such that the way would begin or end by falling
    q = C / D if D > 0.0 else 2.0 * side.a0
    q = min(max(q, 2.0 * side.a0 - D), 2.0 * side.af + D)
    a1, a2 = 0.5 * (q + D), 0.5 * (q - D)
    if a1 <= 1.0:
        pass
    elif D > 2.0 + 0.5 * C:
        a1, a2 = 1.0, -1.0
        h1, h2 = D - 2.0 + 0.5 * C, D - 2.0 - 0.5 * C
    else:
        s = math.sqrt(max(2.0 * D - C, 0.0))
        a1, a2 = 1.0, 1.0 - s
        h1 = max(2.0 * (D - s), 0.0)
    return max(a1, side.a0), h1, min(a2, side.af), h2, 0.0


@kernel
def place_of(side: Side, D: float) -> tuple[float, float]:
    """Give the distance P and dP/dD.

    dP/dT is the Hamiltonian of the problem, constant along the way: where the way turns from up to
    down it is v + a1 L/2, with L the duration of the way down (its costate is zero half way).
    """
    v0, a0, top = side.v0, side.a0, side.top
    a1, h1, a2, h2, c = shape_of(side, D)
    t1, t2, t3 = a1 - a0, a1 - a2, side.af - a2
    P = t1 * (v0 + t1 * (0.5 * a0 + t1 / 6.0))
    v = v0 + 0.5 * (a1 * a1 - a0 * a0)
    P += h1 * (v + 0.5 * a1 * h1)
    v += a1 * h1
    slope = 2.0 * v + a1 * t2
    if c > 0.0:
        slope = 2.0 * top
    P += t2 * (v + t2 * (0.5 * a1 - t2 / 6.0)) + top * c
    v += 0.5 * (a1 * a1 - a2 * a2)
    P += h2 * (v + 0.5 * a2 * h2)
    v += a2 * h2
    P += t3 * (v + t3 * (0.5 * a2 + t3 / 6.0))
    return P, slope


@kernel
def domain_of(side: Side) -> tuple[float, float, float]:
    """Give (begin, gap_begin, gap_end): the D that exist are from begin on, without the gap.

    Without a gap its ends are NaN. The way must not begin by falling below a0 (a1 >= a0) nor end
    by falling to af (a2 <= af); a2 only falls with D, a1 falls and rises again.
    """
    a0, af, C = side.a0, side.af, side.C
    peak = math.sqrt(C + af * af)
    if peak > 1.0:
        begin = 1.0 - af + 0.5 * (C + af * af - 1.0)
    elif af > 0.0:
        begin = C / (peak + af)
    else:
        begin = peak - af
    if a0 <= 0.0 or a0 * a0 <= C:
        return begin, math.nan, math.nan
    root = math.sqrt(a0 * a0 - C)
    low, high = C / (a0 + root), a0 + root
    if peak <= 1.0:
        before = af > 0.0 and peak + af >= (a0 + root) * (1.0 - _ROUNDING)
    else:
        before = begin <= low
    if before:
        return begin, max(begin, low), high
    return max(begin, high), math.nan, math.nan


@kernel
def bend_of(side: Side) -> float:
    """Give the D up to which P is concave in D, and from which on it is convex."""
    C = side.C
    if C <= _BEND_FREE:
        return _BEND * math.sqrt(C)
    if C < _BEND_HELD:
        return 1.0 - math.sqrt(1.0 - C)
    return 0.5 * (C + 0.5625)


@kernel
def roots_of(side: Side, p: float, begin: float, end: float, out: FloatArray, k: int) -> int:
    """Write the D in [begin, end] (end may be inf) where P = p to out[k:]; give the new k."""
    bend = bend_of(side)
    if begin < end and end > side.full:
        last = max(side.full, begin)
        P, _ = place_of(side, last)
        if p >= P:
            out[k] = last + 0.5 * (p - P) / side.top
            k += 1
        end = last
    for sign in (-1.0, 1.0):
        left, right = (begin, min(bend, end)) if sign < 0.0 else (max(begin, bend), end)
        if left < right:
            k = _convex_roots(side, p, left, right, sign, out, k)
    return k


@kernel
def _convex_roots(
    side: Side, p: float, begin: float, end: float, sign: float, out: FloatArray, k: int
) -> int:
    """Write the roots of sign (P - p), convex from begin to end, below end; give the new k."""
    P, slope = place_of(side, begin)
    left, left_slope = sign * (P - p), sign * slope
    P, slope = place_of(side, end)
    right, right_slope = sign * (P - p), sign * slope
    if left > 0.0:
        if right >= 0.0 and (left_slope >= 0.0 or right_slope <= 0.0):
            return k
        x = _newton(side, p, begin, begin, end, sign)
        if math.isnan(x):
            return k
        out[k] = x
        k += 1
    if right > 0.0:
        x = end
        if left <= 0.0:
            # any start with a rising slope will do: the next place is right of the root
            guess = begin + (-4.0 * left) ** (1.0 / 3.0)
            if left_slope > 0.0:
                guess = min(guess, begin - left / left_slope)
            if guess < end:
                P, slope = place_of(side, guess)
                if sign * slope > 0.0:
                    x = min(max(guess - (P - p) / slope, begin), end)
        out[k] = _newton(side, p, x, begin, end, sign)
        k += 1
    return k


@kernel
def _newton(side: Side, p: float, x: float, begin: float, end: float, sign: float) -> float:
    """Give the root that Newton's method reaches from outside of a convex dip, or NaN.

    From outside it comes nearer from one side only, and with rounding may pass the root once.
    """
    falling = True
    for i in range(100):
        P, slope = place_of(side, x)
        beyond = sign * (P - p)
        if i == 0:
            falling = sign * slope < 0.0
        elif beyond > 0.0 and (sign * slope < 0.0) != falling:
            return math.nan
        if slope == 0.0:
            return x
        nearer = min(max(x - (P - p) / slope, begin), end)
        if nearer == x or (nearer > x) != falling:
            # passed, by rounding
            return nearer
        x = nearer
    return x


@kernel
def phases_of(side: Side, D: float, sign: float, spans: FloatArray, jerks: FloatArray) -> None:
    """Write the durations and jerks of the seven phases; ``sign`` -1 turns the way round."""
    a1, h1, a2, h2, c = shape_of(side, D)
    if c > 0.0:
        first, second = a1, -a2
    else:
        first, second = a1 - a2, 0.0
    spans[0], spans[1], spans[2], spans[3] = a1 - side.a0, h1, first, c
    spans[4], spans[5], spans[6] = second, h2, side.af - a2
    for i in range(7):
        jerks[i] = 0.0
    jerks[0] = jerks[6] = sign
    jerks[2] = jerks[4] = -sign
    if side.backwards:
        for i in range(3):
            spans[i], spans[6 - i] = spans[6 - i], spans[i]
            jerks[i], jerks[6 - i] = jerks[6 - i], jerks[i]
