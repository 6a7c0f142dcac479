"""Offsets of splines: control points and time beside others: OpenCASCADE, kurbo, the literature.

Run it on one core, for example ``taskset -c 1 python benchmarks/toolpaths_spline.py``. The methods
of the literature are written here from their descriptions and may stray to both sides of the
offset; ours lies beyond it only, and a second row of each gives what they take if they must, too.
Tolerances are shares of the size of a curve. OpenCASCADE is taken if ``OCP`` is installed, kurbo
if ``kurbopy`` is.
"""

import datetime
import re
from collections.abc import Callable
from math import pi, tau

import numpy as np
from kinematics_forward import imported, processor, shortest

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline
from splinearm.curves.curvature import curvature
from splinearm.curves.projection import Projection
from splinearm.toolpaths.biarc import curve_arcs, offset_outline_arcs
from splinearm.toolpaths.piece import SplinePiece
from splinearm.toolpaths.spline_offset import offset_outline, offset_spline

MOST = 3000


def clamped(points: object, degree: int) -> BSpline:
    """Give a clamped spline over even knots."""
    rows = np.asarray(points, dtype=float)
    inner = np.linspace(0.0, 1.0, len(rows) - degree + 1)[1:-1]
    return BSpline(np.concatenate((np.zeros(degree + 1), inner, np.ones(degree + 1))), rows, degree)


def spiral(count: int) -> FloatArray:
    """Give points that go to and fro on their way round."""
    a = np.linspace(0.0, 5.2, count)
    r = 1.0 + 0.25 * (-1.0) ** np.arange(count)
    return np.stack((r * np.cos(a), r * np.sin(a)), axis=1)


SEVEN = [[0, 0], [0.6, 1.2], [1.5, 1.0], [2.2, -0.5], [3.1, -0.2], [3.6, 1.0], [4.6, 0.6]]
# curve, and the share of its smallest radius of curvature to the left by which it is offset
CURVES = {
    "S cubic": (clamped([[0, 0], [1, 1], [0.6, -1.0], [1.6, 0.2]], 3), 0.8),
    "cubic, 7 points": (clamped(SEVEN, 3), 0.8),
    "cubic, 12 points": (clamped(spiral(12), 3), 0.7),
    "quadratic, 7 points": (clamped(SEVEN, 2), 0.95),
}


class Exact:
    """The offset of a curve, and how far others are from it."""

    def __init__(self, curve: BSpline, distance: float) -> None:
        self.curve, self.d = curve, distance
        self.near = Projection(curve)

    def at(self, u: FloatArray) -> FloatArray:
        """Give its points."""
        point, way = np.moveaxis(self.curve.jet(u, 1), -2, 0)
        normal = np.stack((-way[:, 1], way[:, 0]), axis=1) / np.hypot(*way.T)[:, None]
        return point + self.d * normal

    def normal(self, u: FloatArray) -> FloatArray:
        """Give the normals of the curve to its left."""
        return (self.at(u) - self.curve.at(u)) / self.d

    def misses(self, other: BSpline, per_span: int = 12) -> tuple[FloatArray, FloatArray]:
        """Give parameters in all spans and how far another curve is off there, (spans, k) each."""
        ends = other.breaks
        u = ends[:-1, None] + np.diff(ends)[:, None] * np.linspace(0.0, 1.0, per_span)
        away = self.near.nearest(other.at(u.ravel())).distance.reshape(u.shape)
        return u, away - abs(self.d)


def refined(exact: Exact, tolerance: float, made: Callable[[BSpline], BSpline]) -> int:
    """Give how many points it takes if spans that miss are halved."""
    base = exact.curve
    while len(base.points) < MOST:
        other = made(base)
        u, miss = exact.misses(other)
        bad = np.abs(miss).max(axis=1) > tolerance
        if not bad.any():
            return len(other.points)
        base = base.with_knots(0.5 * (u[bad, 0] + u[bad, -1]))
    return MOST


def greville(curve: BSpline) -> FloatArray:
    """Give the nodes of a spline."""
    p = curve.degree
    return np.array([curve.knots[i + 1 : i + p + 1].mean() for i in range(len(curve.points))])


def cobb(exact: Exact) -> Callable[[BSpline], BSpline]:
    """Cobb 1984: control points moved along the normals at their nodes."""

    def made(base: BSpline) -> BSpline:
        moved = base.points + exact.d * exact.normal(greville(base))
        return BSpline(base.knots, moved, base.degree)

    return made


def tiller(exact: Exact) -> Callable[[BSpline], BSpline]:
    """Tiller and Hanson 1984: the legs of the control polygon moved and met again."""

    def made(base: BSpline) -> BSpline:
        P = base.points
        way = np.diff(P, axis=0)
        way /= np.hypot(*way.T)[:, None]
        n = np.stack((-way[:, 1], way[:, 0]), axis=1)
        moved = np.concatenate((P[:1] + exact.d * n[:1], P[1:-1], P[-1:] + exact.d * n[-1:]))
        s = n[:-1] + n[1:]
        moved[1:-1] += exact.d * 2.0 * s / (s * s).sum(axis=1)[:, None]
        return BSpline(base.knots, moved, base.degree)

    return made


def elber(exact: Exact) -> Callable[[BSpline], BSpline]:
    """Elber and Cohen 1991: as Cobb, set right by what is off at the nodes."""

    def made(base: BSpline) -> BSpline:
        u = greville(base)
        target, points = exact.at(u), base.points + exact.d * exact.normal(u)
        for _ in range(12):
            points = points + target - BSpline(base.knots, points, base.degree).at(u)
        return BSpline(base.knots, points, base.degree)

    return made


def least(exact: Exact, corrections: int) -> Callable[[BSpline], BSpline]:
    """Least squares over the knots of the base; Hoschek 1988: with parameters set right."""

    def made(base: BSpline) -> BSpline:
        from scipy.interpolate import BSpline as Basis

        ends = base.breaks
        u = np.unique(ends[:-1, None] + np.diff(ends)[:, None] * np.linspace(0.0, 1.0, 14))
        target, at, p = exact.at(u), u.copy(), base.degree
        points = base.points
        for turn in range(corrections + 1):
            if turn:
                curve = BSpline(base.knots, points, p)
                place, way = np.moveaxis(curve.jet(at, 1), -2, 0)
                step = ((target - place) * way).sum(axis=1) / (way * way).sum(axis=1)
                at[1:-1] = np.clip(at + step, 0.0, 1.0)[1:-1]
                at = np.maximum.accumulate(at)
            A = Basis.design_matrix(at, base.knots, p).toarray()
            inner, *_ = np.linalg.lstsq(
                A[:, 1:-1], target - A[:, [0, -1]] @ target[[0, -1]], rcond=None
            )
            points = np.concatenate((target[:1], inner, target[-1:]))
        return BSpline(base.knots, points, p)

    return made


def occt(exact: Exact, tolerance: float, *, smooth: int) -> int | None:
    """Give the points of OpenCASCADE's approximation of its exact offset, of degree up to 8."""
    if imported("OCP") is None:
        return None
    from OCP.Geom2d import Geom2d_BSplineCurve, Geom2d_OffsetCurve
    from OCP.Geom2dConvert import Geom2dConvert_ApproxCurve
    from OCP.GeomAbs import GeomAbs_Shape
    from OCP.gp import gp_Pnt2d
    from OCP.OCP.collections import Array1_double, Array1_gp_Pnt2d, Array1_int

    curve = exact.curve
    poles = Array1_gp_Pnt2d(1, len(curve.points))
    for i, (x, y) in enumerate(curve.points.tolist(), start=1):
        poles.SetValue(i, gp_Pnt2d(x, y))
    values, times = np.unique(curve.knots, return_counts=True)
    knots, often = Array1_double(1, len(values)), Array1_int(1, len(values))
    for i, (value, count) in enumerate(zip(values.tolist(), times.tolist(), strict=True), start=1):
        knots.SetValue(i, value)
        often.SetValue(i, count)
    base = Geom2d_BSplineCurve(poles, knots, often, curve.degree)
    kind = GeomAbs_Shape.GeomAbs_C1 if smooth == 1 else GeomAbs_Shape.GeomAbs_C2
    moved = Geom2d_OffsetCurve(base, -exact.d, True)  # noqa: FBT003
    done = Geom2dConvert_ApproxCurve(moved, tolerance, kind, 500, 8)
    return int(done.Curve().NbPoles()) if done.HasResult() else None


def kurbo(exact: Exact, tolerance: float) -> int | None:
    """Give the points of kurbo's cubics along the offset, one after the other: 3 n + 1."""
    if imported("kurbopy") is None:
        return None
    from kurbopy import CubicBez, Point, offset_cubic

    curve = exact.curve if exact.curve.degree == 3 else exact.curve.elevated()
    pieces = [CubicBez(*(Point(x, y) for x, y in rows.tolist())) for rows in curve.bezier()[1]]
    asked = tolerance
    while asked > 0.01 * tolerance:
        made = [one for piece in pieces for one in cubics(offset_cubic(piece, exact.d, asked))]
        chain = BSpline(
            np.repeat(np.arange(len(made) + 1.0), [4] + [3] * (len(made) - 1) + [4]),
            np.concatenate([made[0][:1], *(rows[1:] for rows in made)]),
            3,
        )
        if np.abs(exact.misses(chain)[1]).max() <= tolerance:
            return len(chain.points)
        asked *= 0.8
    return MOST


def cubics(path: object) -> list[FloatArray]:
    """Give the control points of a path of kurbo's that has cubics only."""
    numbers = re.findall(r"-?\d[\d.e-]*", path.to_svg())  # type: ignore[attr-defined]
    points = np.array(numbers, dtype=float).reshape(-1, 2)
    return [points[k : k + 4] for k in range(0, len(points) - 1, 3)]


def peers(curve: BSpline, distance: float, tolerance: float) -> list[int | None]:
    """Give how many points others need to stay within a tolerance on both sides."""
    exact = Exact(curve, distance)
    methods = (cobb(exact), tiller(exact), elber(exact), least(exact, 0), least(exact, 6))
    counts: list[int | None] = [refined(exact, tolerance, method) for method in methods]
    counts += [occt(exact, tolerance, smooth=1), occt(exact, tolerance, smooth=2)]
    return [*counts, kurbo(exact, tolerance)]


def open_curves() -> None:
    """Print how many control points each method takes."""
    print("\ncontrol points of the offset of a curve that is not trimmed; ratio: ours to the best")
    print("plain: others stray by the tolerance to both sides, and gouge by it; kept: they too are")
    print("held beyond the distance, to which half a tolerance is added and half of it then kept")
    names = ("Cobb", "Tiller", "Elber", "least sq", "Hoschek", "OCCT C1", "OCCT C2", "kurbo")
    head = "".join(f"{name:>9}" for name in (*names, "ours", "arcs"))
    print(f"{'curve':20} {'tol':>6}       {head}   ratio   time")
    for name, (curve, share) in CURVES.items():
        u = np.linspace(0.0, 1.0, 4001)
        d = share / float(curvature(curve, u).max())
        size = float(np.ptp(curve.points, axis=0).max())
        for tolerance in (1e-3, 1e-4, 1e-5, 1e-6):
            tol = tolerance * size
            ours = sum(len(found.points) for found in offset_spline(curve, d, tol))
            (time,) = shortest(
                lambda c=curve, d=d, t=tol: offset_spline(c, d, t), number=1, rounds=7
            )
            arcs = len(curve_arcs(curve, tol).pieces)
            for kind, more in (("plain", 0.0), ("kept", 0.5 * tol)):
                counts = peers(curve, d + more, tol - more)
                best = min(count for count in counts if count is not None)
                cells = "".join(
                    f"{'-' if c is None else '>' + str(MOST) if c >= MOST else c:>9}"
                    for c in [*counts, ours, arcs]
                )
                last = f" {1e3 * time:5.1f} ms" if not more else ""
                print(f"{name:20} {tolerance:6.0e} {kind:5} {cells} {ours / best:7.2f}{last}")


def ring(radius: Callable[[FloatArray], FloatArray], count: int, weights: object = None) -> BSpline:
    """Give a closed cubic around the origin from its radius in mm."""
    a = tau * np.arange(count) / count
    points = 1e-3 * radius(a)[:, None] * np.stack((np.cos(a), np.sin(a)), axis=1)
    shares = None if weights is None else np.asarray(weights, dtype=float)
    return BSpline.closed(np.linspace(0.0, 1.0, count + 1), points, 3, shares)


def c_shape() -> BSpline:
    """Give a bent bar of changing width."""
    a = np.linspace(0.5, tau - 0.5, 14)
    half = 18.0 + 4.5 * np.cos(np.linspace(0.0, 6.0 * pi, 14))
    way = np.stack((np.cos(a), np.sin(a)), axis=1)
    points = np.concatenate((way * (52.0 + half)[:, None], (way * (52.0 - half)[:, None])[::-1]))
    return BSpline.closed(np.linspace(0.0, 1.0, 29), 1e-3 * points, 3)


WEIGHTS = [1.0, 2.5, 0.6, 1.0, 3.0, 0.7, 1.2, 2.0, 0.8]
OUTLINES = {
    "peanut": (ring(lambda a: 46.0 + 29.0 * np.cos(2.0 * a), 12), (-8, 8, -22)),
    "star": (ring(lambda a: 55.0 + 20.0 * np.cos(5.0 * a), 20), (-6, 12)),
    "cshape": (c_shape(), (-12, 10, -18, 23)),
    "wiggle": (ring(lambda a: 62.0 + 11.0 * np.cos(9.0 * a), 36), (-6, 6)),
    "nurbs_blob": (ring(lambda a: 60.0 + 12.0 * np.cos(3.0 * a + 0.3), 9, WEIGHTS), (-10, 10)),
}


def bisected(curve: BSpline, tolerance: float) -> int:
    """Give how many arcs it takes if parameter ranges are halved until a biarc fits."""
    from splinearm.toolpaths.biarc_kernel import biarc, strays
    from splinearm.toolpaths.spline_source import source_of

    source = source_of([[SplinePiece(curve)]], 0.0)
    S, arcs = source.segments, np.empty((2, 5))
    chain = 0.0, float(len(S))

    def count(a: float, b: float) -> int:
        x, y, _, _ = biarc(S, chain, a, b, arcs)
        end = float(arcs[1, 0]), float(arcs[1, 1])
        off = max(strays(S, chain, arcs[0], end, 9), strays(S, chain, arcs[1], (x, y), 9))
        if off <= tolerance / source.unit:
            return 2
        return count(a, 0.5 * (a + b)) + count(0.5 * (a + b), b)

    return sum(count(float(k), k + 1.0) for k in range(len(S)))


def outlines() -> None:
    """Print what becomes of closed splines, trimmed."""
    for tolerance in (1e-7, 1e-5):
        print(f"\nclosed splines of about 150 mm, trimmed, tolerance {tolerance * 1e3:g} mm")
        print("case            loops pieces points  arcs  biarcs of the outline    of arcs    time")
        print("                                    ours  longest    halved    halved")
        for name, (curve, distances) in OUTLINES.items():
            longest = len(curve_arcs(curve, tolerance).pieces)
            halved = bisected(curve, tolerance)
            for distance in distances:
                outline, d = [SplinePiece(curve)], 1e-3 * distance
                wires = offset_outline(outline, d, tolerance)
                (time,) = shortest(
                    lambda o=outline, d=d, t=tolerance: offset_outline(o, d, t), number=1, rounds=7
                )
                pieces = [piece for wire in wires for piece in wire.pieces]
                points = sum(
                    len(piece.curve.points) if isinstance(piece, SplinePiece) else 2
                    for piece in pieces
                )
                regions = offset_outline_arcs(outline, d, tolerance)
                arcs = sum(len(c.bulges) for region in regions for c in region.contours)
                print(
                    f"{name:11} {distance:3d} {len(wires):5d} {len(pieces):6d} {points:6d} "
                    f"{arcs:5d} {longest:8d} {halved:9d} {points / halved:9.2f} "
                    f"{1e3 * time:8.1f} ms"
                )


if __name__ == "__main__":
    print(f"{processor()}, {datetime.datetime.now(tz=datetime.UTC):%Y-%m-%d}")
    open_curves()
    outlines()
