"""Curves through 1 000 and 10 000 points beside scipy.

Run it on one core, for example ``taskset -c 1 python benchmarks/curves_interpolation.py``. Each
figure is the best of several rounds in which both take turns; what counts is the ratio in one run.
"""

import datetime
import os
import platform

import numpy as np
from kinematics_forward import imported, processor, shortest

from splinearm.curves import interpolate


def main() -> None:
    """Print where and when, then a row for each kind of curve."""
    print(f"{datetime.datetime.now(tz=datetime.UTC):%Y-%m-%d %H:%M} UTC, {platform.platform()}")
    print(f"{processor()}, cores {sorted(os.sched_getaffinity(0))}, numpy {np.__version__}")
    scipy = imported("scipy.interpolate")
    if scipy is None:
        return
    for m in (1_000, 10_000):
        points = np.cumsum(np.random.default_rng(0).normal(size=(m, 3)), axis=0)
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        u = np.concatenate(([0.0], np.cumsum(steps)))
        for name, degree, ends, peer in (
            ("cubic, free ends", 3, "free", lambda p, u=u: scipy.make_interp_spline(u, p, k=3)),
            (
                "cubic, natural ends",
                3,
                "natural",
                lambda p, u=u: scipy.make_interp_spline(u, p, k=3, bc_type="natural"),
            ),
            ("quintic, free ends", 5, "free", lambda p, u=u: scipy.make_interp_spline(u, p, k=5)),
        ):
            curve = interpolate(points, degree=degree, parameters=u, ends=ends)
            miss = np.abs(curve.at(u) - points).max() / np.abs(points).max()
            own, theirs = shortest(
                lambda d=degree, e=ends, p=points, u=u: interpolate(
                    p, degree=d, parameters=u, ends=e
                ),
                lambda peer=peer, p=points: peer(p),
                number=3,
                rounds=15,
            )
            print(
                f"{m:6} points, {name:20} ours {1e3 * own:7.3f} ms (misses by {miss:.0e} of the "
                f"size)  scipy {1e3 * theirs:7.3f} ms  ratio {own / theirs:5.2f}"
            )


if __name__ == "__main__":
    main()
