"""Time laws of a given duration along which the path parameter jerks least."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import cbrt, inf, isfinite, sqrt

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import CurveError
from splinearm.joints import JointLimits

from .joint_path import JointPath
from .polynomial_law import PolynomialLaw
from .smooth_grid import check_bend

_LOOKS = 1024
"""In so many parts of the time limits are looked at."""

_EXACT = 1.0 + 1e-9
"""By what share rounding may carry a value over its limit."""

_OCTAVES, _STEPS = 6, 16
"""Durations with end speeds are sought so many octaves around a likely one, in such parts."""

_HALVINGS = 60


def minimum_jerk(
    path: JointPath,
    limits: JointLimits,
    duration: float,
    span: tuple[float, float] | None = None,
    speeds: tuple[float, float] = (0.0, 0.0),
) -> PolynomialLaw:
    """Give the law with the least integral of the squared jerk of s, of all that take so long.

    d2s/dt2 is zero at both ends. Velocity, acceleration and, if it is limited, jerk of every joint
    are within their limits at every moment.

    Args:
        path: The way of the joints.
        limits: What the joints may do.
        duration: How long it shall take, s.
        span: From where to where, by default the whole path.
        speeds: ds/dt at the start and at the end, not below zero.

    Raises:
        CurveError: If the duration is too short for the limits, with the shortest that is not; if
            with these speeds at its ends it went backwards; or if jerks are limited and the path's
            second derivative jumps.
        ValueError: If the numbers do not fit.
    """
    start, end = _checked(path, limits, span, speeds)
    if not (isfinite(duration) and duration > 0.0):
        raise ValueError(f"duration: want a number above 0, got {duration}")
    law = _law(start, end, duration, speeds)
    if _over(path, limits, law) <= _EXACT:
        return law
    shortest = shortest_duration(path, limits, span, speeds)
    if duration > shortest:
        raise CurveError(
            f"a law of {duration:.9g} s with these speeds at its ends goes backwards or breaks a "
            f"limit; one of {shortest:.9g} s does not",
            "minimum jerk",
        )
    raise CurveError(
        f"{duration:.9g} s are too short for the limits; {shortest:.9g} s are enough",
        "minimum jerk",
    )


def shortest_duration(
    path: JointPath,
    limits: JointLimits,
    span: tuple[float, float] | None = None,
    speeds: tuple[float, float] = (0.0, 0.0),
) -> float:
    """Give the shortest duration, s, for which ``minimum_jerk`` has a law; arguments as there.

    Where the joints do not move and nothing is asked of the ends it is zero.

    Raises:
        CurveError: If there is no such duration, or if jerks are limited and the path's second
            derivative jumps.
        ValueError: If the numbers do not fit.
    """
    start, end = _checked(path, limits, span, speeds)
    use = _use(path, limits, _law(start, end, 1.0, (0.0, 0.0)))
    # from rest to rest the three go with powers of the duration
    likely = max(float(use[0]), sqrt(use[1]), cbrt(use[2]))
    if max(speeds) == 0.0:
        return likely
    likely = max(likely, (end - start) / max(speeds))
    factors = [2.0 ** (k / _STEPS) for k in range(-_OCTAVES * _STEPS, _OCTAVES * _STEPS + 1)]
    tried = 0.0
    for long in (likely * factor for factor in factors):
        if _over(path, limits, _law(start, end, long, speeds)) <= _EXACT:
            return _shortest(lambda t: _law(start, end, t, speeds), path, limits, (tried, long))
        tried = long
    raise CurveError("no duration keeps the limits with these speeds at the ends", "minimum jerk")


def _shortest(
    law_of: Callable[[float], PolynomialLaw],
    path: JointPath,
    limits: JointLimits,
    between: tuple[float, float],
) -> float:
    """Give the shortest duration whose law is within limits, between one that is not and one."""
    short, long = between
    for _ in range(_HALVINGS):
        middle = 0.5 * (short + long)
        if middle in (short, long):
            break
        if _over(path, limits, law_of(middle)) <= _EXACT:
            long = middle
        else:
            short = middle
    return long


def _checked(
    path: JointPath,
    limits: JointLimits,
    span: tuple[float, float] | None,
    speeds: Sequence[float],
) -> tuple[float, float]:
    """Give where the way starts and ends."""
    if limits.n != path.n:
        raise ValueError(f"limits: want them for the {path.n} joints of the path, got {limits.n}")
    first, last = path.domain
    start, end = path.domain if span is None else span
    if not first <= start < end <= last:
        raise ValueError(f"span: want a part of the path's {path.domain}, got {(start, end)}")
    if len(speeds) != 2 or not all(isfinite(speed) and speed >= 0.0 for speed in speeds):
        raise ValueError(f"speeds: want two numbers of at least 0, got {speeds}")
    if limits.qddd_max is not None:
        check_bend(path, start, end)
    return float(start), float(end)


def _law(start: float, end: float, duration: float, speeds: Sequence[float]) -> PolynomialLaw:
    """Give the quintic with these ends, whose accelerations there are zero."""
    # Flash and Hogan, The coordination of arm movements, J. Neuroscience 5 (1985) 1688: the sixth
    # derivative of a path with the least integral of squared jerk is zero
    way, v0, v1 = end - start, speeds[0] * duration, speeds[1] * duration
    coefficients = np.array(
        [
            start,
            v0,
            0.0,
            10.0 * way - 6.0 * v0 - 4.0 * v1,
            -15.0 * way + 8.0 * v0 + 7.0 * v1,
            6.0 * way - 3.0 * v0 - 3.0 * v1,
        ]
    )
    return PolynomialLaw(coefficients, duration)


def _over(path: JointPath, limits: JointLimits, law: PolynomialLaw) -> float:
    """Give the largest share of a limit that a law uses; infinity for one that goes backwards."""
    _, speed, _ = law.sample(np.linspace(0.0, law.duration, _LOOKS + 1))
    if (speed < -1e-9 * speed.max()).any():
        return inf
    return float(_use(path, limits, law).max())


def _use(path: JointPath, limits: JointLimits, law: PolynomialLaw) -> FloatArray:
    """Give the largest shares of velocity, acceleration and jerk limits that are used, (3,)."""
    inner = path.breaks[1:-1]
    inner = inner[(inner > law.s[0]) & (inner < law.s[-1])]
    passed = [law.time_at(s) for s in inner]
    use = np.zeros(3)
    edges = np.array([0.0, *passed, law.duration])
    for begin, end in pairwise(edges):
        count = 8 + int(_LOOKS * (end - begin) / law.duration)
        t = np.linspace(begin, end, count + 1)
        use = np.maximum(use, _use_within_piece(path, limits, law, t))
    return use


def _use_within_piece(
    path: JointPath, limits: JointLimits, law: PolynomialLaw, t: FloatArray
) -> FloatArray:
    """Give the same at even times on one piece of the path, with tops between them."""
    s, speed, acceleration = (values[:, None] for values in law.sample(t))
    jerk = law.jerk(t)[:, None]
    pieces = np.full(len(t), path.pieces_of(s[len(t) // 2])[0])
    _, slope, bend = path.sample(s[:, 0], pieces)
    values = [slope * speed / limits.qd_max]
    values.append((slope * acceleration + bend * speed**2) / limits.qdd_max)
    if limits.qddd_max is not None:
        third = path.third(s[:, 0], pieces)
        sum_of = slope * jerk + 3.0 * bend * speed * acceleration + third * speed**3
        values.append(sum_of / limits.qddd_max)
    use = [_top(value) for value in values]
    return np.array(use + [0.0] * (3 - len(use)))


def _top(values: FloatArray) -> float:
    """Give the largest magnitude of values at even times, axis 0, and of parabolas between."""
    top = float(np.abs(values).max())
    middle = values[1:-1]
    bend, tilt = values[2:] - 2.0 * middle + values[:-2], 0.5 * (values[2:] - values[:-2])
    between = (bend * middle < 0.0) & (np.abs(tilt) < np.abs(bend))
    tops = np.abs(middle - 0.5 * tilt * tilt / np.where(between, bend, 1.0))
    return max(top, float(tops[between].max(initial=0.0)))
