"""Arc length and its inverse beside splipy, geomdl and the table that users write.

Run it on one core, for example ``taskset -c 1 python benchmarks/curves_arc_length.py``. Times are
the best of several rounds, errors are relative to the whole length, against quadrature with 64
nodes on parts of each span. What is wanted: the map built within 1 ms, 1 000 answers of its
inverse within 50 us, both right to 1e-12.
"""

import datetime
import os
import platform
from collections.abc import Callable

import numpy as np
from kinematics_forward import imported, processor, shortest

from splinearm.curves import BSpline
from splinearm.curves.arc_length import ArcLength
from splinearm.curves.natural import NaturalCurve

NODES, WEIGHTS = np.polynomial.legendre.leggauss(64)
QUERIES = 1000
PARTS = 16


def curve_of(*, rational: bool) -> BSpline:
    """Give a cubic in space with 50 control points."""
    rng = np.random.default_rng(0)
    inner = np.linspace(0.0, 1.0, 48)
    knots = np.concatenate((np.zeros(3), inner, np.ones(3)))
    weights = rng.uniform(0.5, 2.0, 50) if rational else None
    return BSpline(knots, rng.normal(size=(50, 3)), 3, weights)


def cusp() -> BSpline:
    """Give (u^2, u^3) for u from -1 to 1, whose speed is 0 in the middle."""
    points = [[1.0, -1.0], [-1 / 3, 1.0], [-1 / 3, -1.0], [1.0, 1.0]]
    return BSpline([-1, -1, -1, -1, 1, 1, 1, 1], points, 3)


class Truth:
    """Lengths by quadrature with many nodes."""

    def __init__(self, curve: BSpline) -> None:
        breaks = curve.breaks
        shares = np.arange(PARTS) / PARTS
        edges = (breaks[:-1, None] + np.diff(breaks)[:, None] * shares).ravel()
        self.curve, self.edges = curve, np.append(edges, breaks[-1])
        self.sums = np.append(0.0, np.cumsum(self._between(self.edges[:-1], self.edges[1:])))

    def _between(self, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        half = 0.5 * (end - start)[:, None]
        u = np.minimum(start[:, None] + half * (1.0 + NODES), end[:, None])
        return np.sum(half * WEIGHTS * np.linalg.norm(self.curve.at(u, 1), axis=-1), axis=1)

    @property
    def length(self) -> float:
        """The whole length."""
        return float(self.sums[-1])

    def s(self, u: np.ndarray) -> np.ndarray:
        """Give lengths from the start."""
        k = np.clip(np.searchsorted(self.edges, u, side="right") - 1, 0, len(self.edges) - 2)
        return self.sums[k] + self._between(self.edges[k], u)


def row(what: str, build: float, ask: float | None, errors: tuple[float, float | None]) -> None:
    """Print one way to measure."""
    queries = "       -" if ask is None else f"{1e6 * ask:8.1f}"
    inverse = "      -" if errors[1] is None else f"{errors[1]:7.0e}"
    print(f"  {what:44} {1e6 * build:10.1f} {queries}   {errors[0]:7.0e}  {inverse}")


def table_of(curve: BSpline, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Give what users write: parameters and cumulative chords, for np.interp."""
    u = np.linspace(*curve.domain, count)
    chords = np.linalg.norm(np.diff(curve.at(u), axis=0), axis=1)
    return u, np.append(0.0, np.cumsum(chords))


def compare(name: str, curve: BSpline) -> None:
    """Print ours, the users' table and the peers for one curve."""
    print(f"{name}: build, {QUERIES} inverse queries in us; errors of the length, of the inverse")
    truth = Truth(curve)
    shares = np.random.default_rng(1).uniform(0.0, 1.0, QUERIES)
    arc = ArcLength(curve)
    s = shares * arc.length
    wrong = float(np.abs(truth.s(arc.u(s)) - s).max()) / truth.length
    error = abs(arc.length / truth.length - 1.0)
    build, ask = shortest(lambda: ArcLength(curve), lambda: arc.u(s), number=5, rounds=21)
    row("ArcLength", build, ask, (error, wrong))
    met = build <= 1e-3 and ask <= 50e-6 and max(error, wrong) <= 1e-12
    print(f"    wanted 1000 us, 50 us, 1e-12: {'met' if met else 'NOT MET'}")
    one = shortest(lambda: arc.u(0.5 * arc.length), number=200, rounds=11)[0]
    print(f"    one query {1e6 * one:.2f} us")
    (gauss,) = shortest(curve.length, number=1, rounds=7)
    row("BSpline.length", gauss, None, (abs(curve.length() / truth.length - 1.0), None))
    for count in (1000, 10_000):
        u, sums = table_of(curve, count)
        s = shares * sums[-1]
        wrong = float(np.abs(truth.s(np.interp(s, sums, u)) - shares * truth.length).max())
        build, ask = shortest(
            lambda n=count: table_of(curve, n),
            lambda s=s, sums=sums, u=u: np.interp(s, sums, u),
            number=3,
            rounds=11,
        )
        errors = abs(sums[-1] / truth.length - 1.0), wrong / truth.length
        row(f"table of {count} chords, np.interp", build, ask, errors)
    for peer, make in (("splipy", splipy_length), ("geomdl", geomdl_length)):
        measure = make(curve)
        if measure is not None:
            (time,) = shortest(measure, number=1, rounds=3)
            row(f"{peer}, length only", time, None, (abs(measure() / truth.length - 1.0), None))


def splipy_length(curve: BSpline) -> Callable[[], float] | None:
    """Give what measures the curve in splipy, or None."""
    splipy = imported("splipy")
    if splipy is None:
        return None
    rational = curve.weights is not None
    basis = splipy.BSplineBasis(curve.degree + 1, curve.knots)
    rows = curve.homogeneous if rational else curve.points
    return splipy.Curve(basis, rows, rational=rational, raw=rational).length


def geomdl_length(curve: BSpline) -> Callable[[], float] | None:
    """Give what measures the curve in geomdl, or None."""
    if imported("geomdl") is None:
        return None
    from geomdl import NURBS, operations
    from geomdl import BSpline as Polynomial

    theirs = Polynomial.Curve() if curve.weights is None else NURBS.Curve()
    theirs.degree = curve.degree
    theirs.ctrlpts = curve.points.tolist()
    theirs.knotvector = curve.knots.tolist()
    if curve.weights is not None:
        theirs.weights = curve.weights.tolist()
    theirs.delta = 0.001
    return lambda: operations.length_curve(theirs)


def reparametrise(curve: BSpline) -> None:
    """Print what a B-spline by arc length costs and keeps."""
    natural = NaturalCurve(curve)
    s = np.linspace(0.0, natural.length, 20_000)
    for tolerance in (1e-3, 1e-6, 1e-9):
        spline = natural.to_bspline(tolerance)
        off = float(np.linalg.norm(spline.at(s) - natural.at(s), axis=1).max())
        (time,) = shortest(lambda t=tolerance: natural.to_bspline(t), number=1, rounds=5)
        print(
            f"  as a B-spline within {tolerance:.0e}: {1e3 * time:6.1f} ms, {len(spline.points):5} "
            f"control points, {off:.1e} off"
        )


def main() -> None:
    """Print where and when, then a table for each curve."""
    print(f"{datetime.datetime.now(tz=datetime.UTC):%Y-%m-%d %H:%M} UTC, {platform.platform()}")
    print(f"{processor()}, cores {sorted(os.sched_getaffinity(0))}, numpy {np.__version__}")
    compare("cubic, 50 control points", curve_of(rational=False))
    reparametrise(curve_of(rational=False))
    compare("rational cubic, 50 control points", curve_of(rational=True))
    compare("a cusp", cusp())


if __name__ == "__main__":
    main()
