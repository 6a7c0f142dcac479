"""Exact changes of a curve beside pantr, geomdl and scipy: time, and how far the curve drifts.

Run it on one core, for example ``taskset -c 1 python benchmarks/curves_algebra.py``. The curve has
50 control points with 7 coordinates and degree 3; what counts is the ratio to pantr in one run.
"""

import copy
import datetime
import os
import platform
from collections.abc import Callable
from types import ModuleType

import numpy as np
from kinematics_forward import imported, processor, shortest

from splinearm.curves import BSpline
from splinearm.curves.removal import remove_knots

DEGREE, COUNT, DIM = 3, 50, 7


def random_curve() -> BSpline:
    """Give a clamped curve over uneven knots from 0 to 1."""
    rng = np.random.default_rng(1)
    inner = np.sort(rng.uniform(0.0, 1.0, COUNT - DEGREE - 1))
    knots = np.concatenate((np.zeros(DEGREE + 1), inner, np.ones(DEGREE + 1)))
    return BSpline(knots, rng.uniform(-1.0, 1.0, (COUNT, DIM)), DEGREE)


def works_of_ours(curve: BSpline, us: np.ndarray) -> dict[str, Callable[[], object]]:
    """Give our changes of the curve by name."""
    finer = curve.with_knots(us[:1])
    return {
        "insert 1": lambda: curve.with_knots(us[:1]),
        "insert 20": lambda: curve.with_knots(us),
        "remove": lambda: remove_knots(finer, us[:1], 1e-9)[0],
        "elevate": curve.elevated,
        "to Bezier": curve.bezier,
    }


def works_of_pantr(curve: BSpline, us: np.ndarray) -> dict[str, Callable[[], object]]:
    """Give the same of pantr, or nothing."""
    if imported("pantr") is None:
        return {}
    from pantr.bspline import Bspline, BsplineSpace, BsplineSpace1D

    space = BsplineSpace([BsplineSpace1D(curve.knots.copy(), DEGREE)])
    theirs = Bspline(space, curve.points.copy())
    finer = theirs.insert_knots(us[:1])
    return {
        "insert 1": lambda: theirs.insert_knots(us[:1]),
        "insert 20": lambda: theirs.insert_knots(us),
        "remove": lambda: finer.remove_knots(us[:1], tol=1e-9),
        "elevate": lambda: theirs.elevate_degree(1),
        # it keeps its pieces, so each time they are asked of a curve made anew
        "to Bezier": lambda: Bspline(space, theirs.control_points).to_beziers(),
    }


def works_of_geomdl(curve: BSpline, us: np.ndarray) -> dict[str, Callable[[], object]]:
    """Give the same of geomdl, which changes a curve in place, or nothing."""
    if imported("geomdl") is None:
        return {}
    from geomdl import BSpline as Peer
    from geomdl import operations

    theirs = Peer.Curve()
    theirs.degree = DEGREE
    theirs.ctrlpts = curve.points.tolist()
    theirs.knotvector = curve.knots.tolist()
    finer = operations.insert_knot(copy.deepcopy(theirs), [float(us[0])], [1])

    def inserted() -> object:
        return operations.insert_knot(copy.deepcopy(theirs), [float(us[0])], [1])

    def removed() -> object:
        return operations.remove_knot(copy.deepcopy(finer), [float(us[0])], [1])

    def elevated() -> object:
        return operations.degree_operations(copy.deepcopy(theirs), [1])

    return {"insert 1": inserted, "remove": removed, "elevate": elevated}


def drift(result: object, curve: BSpline) -> float | None:
    """Give how far a changed curve is from what it was, of any library."""
    u = np.linspace(0.0, 1.0, 501)
    if isinstance(result, BSpline):
        values = result.at(u)
    elif isinstance(result, tuple):
        ends, pieces = result
        knots = np.repeat(ends, DEGREE + 1)
        values = BSpline(knots, pieces.reshape(-1, DIM), DEGREE).at(u)
    elif hasattr(result, "evaluate_list"):
        values = np.array(result.evaluate_list(u.tolist()))
    elif hasattr(result, "evaluate"):
        values = np.asarray(result.evaluate(u)).reshape(u.size, -1)
    else:
        return None
    return float(np.abs(values - curve.at(u)).max())


def compare(name: str, ours: Callable[[], object], peers: dict[str, Callable[[], object]]) -> None:
    """Print one row."""
    quick = [work for peer, work in peers.items() if peer != "geomdl"]
    times = dict.fromkeys(peers, 0.0)
    names = [peer for peer in peers if peer != "geomdl"]
    own, *others = shortest(ours, *quick, number=20, rounds=15)
    times.update(zip(names, others, strict=True))
    if "geomdl" in peers:
        # takes long enough to throw everyone else out of the caches
        times["geomdl"] = shortest(peers["geomdl"], number=1, rounds=3)[0]
    curve = random_curve()
    row = f"{name:10} ours {1e6 * own:8.1f} us (drift {drift(ours(), curve):.0e})"
    for peer, work in peers.items():
        off = drift(work(), curve)
        said = "" if off is None else f" (drift {off:.0e})"
        row += f"  {peer} {1e6 * times[peer]:8.1f} us{said}, ratio {own / times[peer]:5.2f}"
    print(row)


def scipy_insertion(scipy: ModuleType | None, curve: BSpline, us: np.ndarray) -> dict[str, object]:
    """Give the insertion of scipy, or nothing."""
    if scipy is None:
        return {}
    theirs = scipy.BSpline(curve.knots, curve.points, DEGREE)

    def many() -> object:
        finer = theirs
        for u in us:
            finer = finer.insert_knot(u)
        return finer

    return {"insert 1": lambda: theirs.insert_knot(us[0]), "insert 20": many}


def main() -> None:
    """Print where and when, then a row for each change."""
    print(f"{datetime.datetime.now(tz=datetime.UTC):%Y-%m-%d %H:%M} UTC, {platform.platform()}")
    print(f"{processor()}, cores {sorted(os.sched_getaffinity(0))}, numpy {np.__version__}")
    curve = random_curve()
    us = np.sort(np.random.default_rng(2).uniform(0.0, 1.0, 20))
    peers = {
        "pantr": works_of_pantr(curve, us),
        "geomdl": works_of_geomdl(curve, us),
        "scipy": scipy_insertion(imported("scipy.interpolate"), curve, us),
    }
    for name, ours in works_of_ours(curve, us).items():
        compare(name, ours, {peer: work[name] for peer, work in peers.items() if name in work})


if __name__ == "__main__":
    main()
