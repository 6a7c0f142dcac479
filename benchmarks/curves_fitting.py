"""Curves near points, nearest places and meetings beside scipy and geomdl, in one run.

Run it on one core, for example ``taskset -c 1 python benchmarks/curves_fitting.py``. Each figure
is the best of several rounds in which both take turns; what counts is the ratio in one run.
"""

import datetime
import os
import platform
import warnings

import numpy as np
from kinematics_forward import imported, processor, shortest

from splinearm.curves import interpolate
from splinearm.curves.approximation import approximate
from splinearm.curves.conic import circle
from splinearm.curves.fit import fit
from splinearm.curves.interpolation import choose_parameters
from splinearm.curves.meeting import meet_curves, meet_itself
from splinearm.curves.projection import Projection
from splinearm.curves.smoothing import smooth


def main() -> None:
    """Print where and when, then a row for each task."""
    print(f"{datetime.datetime.now(tz=datetime.UTC):%Y-%m-%d %H:%M} UTC, {platform.platform()}")
    print(f"{processor()}, cores {sorted(os.sched_getaffinity(0))}, numpy {np.__version__}")
    scipy = imported("scipy.interpolate")
    if scipy is not None:
        _least_squares(scipy)
        _smoothing(scipy)
        _fewest(scipy)
    _nearest(imported("scipy.optimize"))
    _meetings()


def _least_squares(scipy) -> None:  # noqa: ANN001 - a module
    for m, control in ((1_000, 100), (10_000, 1_000)):
        points = np.cumsum(np.random.default_rng(0).normal(size=(m, 3)), axis=0)
        u = choose_parameters(points)
        knots = fit(points, control, parameters=u, ends="free").knots
        own, theirs = shortest(
            lambda p=points, k=knots, u=u: fit(p, k, parameters=u, ends="free"),
            lambda p=points, k=knots, u=u: scipy.make_lsq_spline(u, p, k, 3),
            number=2,
            rounds=15,
        )
        _row(f"least squares, {m} points, {control} control points", own, theirs)


def _smoothing(scipy) -> None:  # noqa: ANN001 - a module
    rng = np.random.default_rng(1)
    u = np.sort(rng.uniform(0.0, 10.0, 1_000))
    points = (np.sin(u) + 0.1 * rng.normal(size=1_000))[:, None]
    for name, stiffness in (("given", 0.5), ("by cross validation", None)):
        own, theirs = shortest(
            lambda s=stiffness: smooth(points, s, parameters=u),
            lambda s=stiffness: scipy.make_smoothing_spline(u, points[:, 0], lam=s),
            number=1,
            rounds=5,
        )
        _row(f"smoothing of 1 000 points, stiffness {name}", own, theirs)


def _fewest(scipy) -> None:  # noqa: ANN001 - a module
    t = np.linspace(0.0, 1.0, 1_000)
    noise = 1e-3 * np.random.default_rng(2).normal(size=(1_000, 2))
    shapes = {
        "Lissajous": np.column_stack((np.sin(6.0 * t), np.cos(4.0 * t + 1.0))),
        "spiral in space": np.column_stack((t * np.cos(20.0 * t), t * np.sin(20.0 * t), t)),
        "bump": np.column_stack((4.0 * t, np.exp(-((20.0 * (t - 0.5)) ** 2)))),
        "noisy Lissajous": np.column_stack((np.sin(6.0 * t), np.cos(4.0 * t + 1.0))) + noise,
    }
    print("control points for a tolerance (scipy: the best of 40 smoothing factors)")
    for name, points in shapes.items():
        for tolerance in (4e-3,) if "noisy" in name else (1e-2, 1e-4, 1e-6):
            u = t if "noisy" in name else choose_parameters(points)
            curve, _ = approximate(points, tolerance, parameters=u)
            moved, _ = approximate(points, tolerance, parameters=u, geometric=True)
            (own,) = shortest(
                lambda p=points, e=tolerance, u=u: approximate(p, e, parameters=u),
                number=1,
                rounds=3,
            )
            theirs = _fewest_of_scipy(scipy, points, u, tolerance)
            print(
                f"  {name:16} {tolerance:7.0e}  ours {len(curve.points):4} in {1e3 * own:6.1f} ms, "
                f"parameters moved {len(moved.points):4}  splprep {theirs:4}"
            )


def _fewest_of_scipy(scipy, points, u, tolerance) -> int:  # noqa: ANN001 - a module and arrays
    fewest = len(points)
    for s in len(u) * tolerance**2 * np.geomspace(1e-4, 2.0, 40):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tck, _ = scipy.splprep(points.T, u=u, s=s)
        gap = np.array(scipy.splev(u, tck)).T - points
        if np.linalg.norm(gap, axis=1).max() <= tolerance:
            fewest = min(fewest, len(tck[0]) - 4)
    return fewest


def _nearest(scipy) -> None:  # noqa: ANN001 - a module
    rng = np.random.default_rng(3)
    curve = interpolate(np.cumsum(rng.normal(size=(200, 3)), axis=0))
    points = curve.points.mean(axis=0) + 5.0 * rng.normal(size=(1_000, 3))
    projection = Projection(curve)
    (many,) = shortest(lambda: projection.nearest(points), number=1, rounds=5)
    (one,) = shortest(lambda: projection.nearest(points[0]), number=100, rounds=10)
    round_one = Projection(circle(1.0))
    (arc,) = shortest(lambda: round_one.nearest([0.3, 0.4]), number=100, rounds=10)
    print(
        f"nearest place, certified: cubic of 199 pieces in space {1e6 * one:6.1f} us one by one, "
    )
    print(f"  {1e3 * many:6.1f} us each of 1 000; NURBS circle {1e6 * arc:6.1f} us")
    if scipy is None:
        return
    sampler = curve.sampler()
    u = np.linspace(*curve.domain, 2_000)
    places = sampler.sample(u, 0)[:, 0]

    def by_hand() -> float:
        near = int(np.argmin(((places - points[0]) ** 2).sum(axis=1)))
        low, high = u[max(near - 1, 0)], u[min(near + 1, len(u) - 1)]
        found = scipy.minimize_scalar(
            lambda x: ((sampler.sample(np.array([x]), 0)[0, 0] - points[0]) ** 2).sum(),
            bounds=(low, high),
            method="bounded",
            options={"xatol": 1e-12},
        )
        return float(found.x)

    (theirs,) = shortest(by_hand, number=3, rounds=5)
    print(f"  2 000 samples and scipy's minimize_scalar, not certified {1e6 * theirs:8.1f} us")


def _meetings() -> None:
    rng = np.random.default_rng(4)
    a, b = (interpolate(rng.normal(size=(30, 2))) for _ in range(2))
    for name, function in (
        ("two walks of 29 cubics", lambda: meet_curves(a, b)),
        ("one of them with itself", lambda: meet_itself(a)),
        ("two NURBS circles", lambda: meet_curves(circle(1.0), circle(1.0).mapped(_SHIFT))),
    ):
        found = function()
        (own,) = shortest(function, number=1, rounds=5)
        print(f"{name:28} meet {len(found.u):4} times: {1e3 * own:7.1f} ms")


_SHIFT = [[1.0, 0.0, 0.7], [0.0, 1.0, 0.2], [0.0, 0.0, 1.0]]


def _row(name: str, own: float, theirs: float) -> None:
    print(
        f"{name:55} ours {1e3 * own:8.3f} ms  scipy {1e3 * theirs:8.3f} ms  "
        f"ratio {own / theirs:5.2f}"
    )


if __name__ == "__main__":
    main()
