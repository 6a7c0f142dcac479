"""Points of B-splines and NURBS with two derivatives beside scipy, Drake and interpolatepy.

Run it on one core, for example ``taskset -c 1 python benchmarks/curves_evaluation.py``. Each
figure is the best of several rounds in which all take turns; what counts is the ratio in one run.
"""

import datetime
import math
import os
import platform
from collections.abc import Callable
from types import ModuleType

import numpy as np
from kinematics_forward import imported, processor, shortest

from splinearm.curves import BSpline

MANY = 100_000


def random_curve(degree: int, dim: int, count: int, *, rational: bool = False) -> BSpline:
    """Give a clamped curve over uneven knots from 0 to 1."""
    rng = np.random.default_rng(degree)
    inner = np.sort(rng.uniform(0.0, 1.0, count - degree - 1))
    knots = np.concatenate((np.zeros(degree + 1), inner, np.ones(degree + 1)))
    weights = rng.uniform(0.5, 2.0, count) if rational else None
    return BSpline(knots, rng.uniform(-1.0, 1.0, (count, dim)), degree, weights)


def print_row(name: str, unit: float, times: dict[str, float]) -> None:
    """Print times and the ratio of ours to each peer."""
    own = times["ours"]
    shown = [f"{peer} {time * unit:8.3f} ({own / time:5.2f}x)" for peer, time in times.items()]
    print(f"{name:34}", "  ".join(shown))


def timed(works: dict[str, Callable[[], object]], number: int, rounds: int) -> dict[str, float]:
    """Give the shortest time of each, s."""
    return dict(zip(works, shortest(*works.values(), number=number, rounds=rounds), strict=True))


def stacked(scipy: ModuleType, curve: BSpline) -> Callable[[object], object]:
    """Give scipy's quickest way: the curve and its derivatives as one piecewise polynomial."""
    degree, dim, breaks = curve.degree, curve.dim, curve.breaks
    spline = scipy.BSpline(curve.knots, curve.points, degree)
    values = [spline(breaks[:-1], nu=k) for k in range(degree + 1)]
    c = np.zeros((degree + 1, breaks.size - 1, 3 * dim))
    for i in range(3):
        for k in range(degree + 1 - i):
            c[degree - k, :, i * dim : (i + 1) * dim] = values[k + i] / math.factorial(k)
    return scipy.PPoly(c, breaks)


def compare_polynomial(scipy: ModuleType | None, degree: int) -> None:
    """Print rows of a curve with 7 coordinates and 50 control points."""
    curve = random_curve(degree, 7, 50)
    sampler, out = curve.sampler(), np.empty((3, 7))
    us = np.random.default_rng(0).uniform(0.0, 1.0, MANY)
    one: dict[str, Callable[[], object]] = {"ours": lambda: sampler.into(0.37, out)}
    random: dict[str, Callable[[], object]] = {"ours": lambda: sampler.sample(us)}
    rising = np.sort(us)
    ordered: dict[str, Callable[[], object]] = {"ours": lambda: sampler.sample(rising)}
    if scipy is not None:
        peer = stacked(scipy, curve)
        exact = scipy.BSpline(curve.knots, curve.points, degree)
        for order in range(3):
            theirs = exact(rising[::100], nu=order)
            off = np.abs(sampler.sample(rising[::100])[:, order] - theirs).max()
            print(f"  derivative {order}: {off / np.abs(theirs).max():.1e} from scipy, of its size")
        one["scipy"] = lambda: peer(0.37)
        random["scipy"], ordered["scipy"] = lambda: peer(us), lambda: peer(rising)
    drake = imported("pydrake.trajectories")
    if drake is not None:
        from pydrake.math import BsplineBasis

        theirs = drake.BsplineTrajectory(
            BsplineBasis(degree + 1, curve.knots.tolist()), [p[:, None] for p in curve.points]
        )
        first, second = theirs.MakeDerivative(1), theirs.MakeDerivative(2)
        one["Drake"] = lambda: (theirs.value(0.37), first.value(0.37), second.value(0.37))
    interpolatepy = imported("interpolatepy")
    if interpolatepy is not None:
        theirs_too = interpolatepy.BSpline(degree, curve.knots.copy(), curve.points.copy())
        one["interpolatepy"] = lambda: (
            theirs_too.evaluate(0.37),
            theirs_too.evaluate_derivative(0.37, 1),
            theirs_too.evaluate_derivative(0.37, 2),
        )
    print_row(f"degree {degree}, 7-D: one, us", 1e6, timed(one, 2000, 15))
    print_row(f"degree {degree}, 7-D: 100 000 sorted, ms", 1e3, timed(ordered, 1, 11))
    print_row(f"degree {degree}, 7-D: 100 000 random, ms", 1e3, timed(random, 1, 11))


def compare_rational(scipy: ModuleType | None) -> None:
    """Print rows of a cubic NURBS in space with 30 control points."""
    curve = random_curve(3, 3, 30, rational=True)
    sampler, out = curve.sampler(), np.empty((3, 3))
    us = np.sort(np.random.default_rng(0).uniform(0.0, 1.0, MANY))
    one: dict[str, Callable[[], object]] = {"ours": lambda: sampler.into(0.37, out)}
    many: dict[str, Callable[[], object]] = {"ours": lambda: sampler.sample(us)}
    if scipy is not None:
        peer = scipy.BSpline(curve.knots, curve.homogeneous, 3)
        first, second = peer.derivative(1), peer.derivative(2)

        def quotient(u: object) -> tuple[np.ndarray, ...]:
            a, b, c = peer(u), first(u), second(u)
            w = a[..., 3:]
            p = a[..., :3] / w
            v = (b[..., :3] - b[..., 3:] * p) / w
            return p, v, (c[..., :3] - 2.0 * b[..., 3:] * v - c[..., 3:] * p) / w

        off = max(
            np.abs(sampler.sample(us[::100])[:, k] - theirs).max() / np.abs(theirs).max()
            for k, theirs in enumerate(quotient(us[::100]))
        )
        print(f"  {off:.1e} from scipy by hand, of the size of each derivative")
        one["scipy by hand"], many["scipy by hand"] = lambda: quotient(0.37), lambda: quotient(us)
    print_row("cubic NURBS, 3-D: one, us", 1e6, timed(one, 2000, 15))
    print_row("cubic NURBS, 3-D: 100 000, ms", 1e3, timed(many, 1, 11))


def main() -> None:
    """Print where and when, then the rows."""
    print(f"{datetime.datetime.now(tz=datetime.UTC):%Y-%m-%d %H:%M} UTC, {platform.platform()}")
    print(f"{processor()}, cores {sorted(os.sched_getaffinity(0))}, numpy {np.__version__}")
    print("position, velocity and acceleration; in brackets the time of ours over that of the peer")
    scipy = imported("scipy.interpolate")
    for degree in (3, 5):
        compare_polynomial(scipy, degree)
    compare_rational(scipy)


if __name__ == "__main__":
    main()
