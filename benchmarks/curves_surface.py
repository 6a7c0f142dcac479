"""Points of surfaces with derivatives and normals, beside scipy, splipy and geomdl.

Run it on one core, for example ``taskset -c 1 python benchmarks/curves_surface.py``. Each figure
is the best of several rounds in which all take turns; what counts is the ratio in one run. Below
are our own figures for what no peer has, each with its error against a closed form.
"""

import datetime
import os
import platform
import time
from collections.abc import Callable

import numpy as np
from kinematics_forward import imported, processor, shortest

from splinearm.curves import conic
from splinearm.curves.bspline import BSpline
from splinearm.curves.plane import Plane
from splinearm.curves.surface import BSplineSurface
from splinearm.curves.surface_box import bounding_box
from splinearm.curves.surface_nearest import nearest_on_surface
from splinearm.curves.surface_normal import normal
from splinearm.curves.surface_of_curves import revolved
from splinearm.curves.surface_offset import OffsetSurface
from splinearm.curves.surface_shape import area, curvatures
from splinearm.curves.sweep import swept

MANY = 100_000
SIDE = 300


def random_surface(*, rational: bool = False) -> BSplineSurface:
    """Give a bicubic surface in space of 30 x 20 control points over uneven knots."""
    rng = np.random.default_rng(1)
    knots = [
        np.concatenate((np.zeros(4), np.sort(rng.uniform(0, 1, count - 4)), np.ones(4)))
        for count in (30, 20)
    ]
    weights = rng.uniform(0.5, 2.0, (30, 20)) if rational else None
    return BSplineSurface(knots[0], knots[1], rng.uniform(-1, 1, (30, 20, 3)), 3, 3, weights)


def row(name: str, unit: float, works: dict[str, Callable[[], object]], number: int = 1) -> None:
    """Print times and the ratio of ours to each peer."""
    times = dict(zip(works, shortest(*works.values(), number=number, rounds=9), strict=True))
    own = times["ours"]
    shown = [f"{peer} {t * unit:9.3f} ({own / t:6.3f}x)" for peer, t in times.items()]
    print(f"{name:42}", "  ".join(shown))


def compare_polynomial() -> None:
    """Print rows of a polynomial surface."""
    surface = random_surface()
    u, v = np.random.default_rng(0).uniform(0.0, 1.0, (2, MANY))
    x = np.linspace(0.0, 1.0, SIDE)
    values: dict[str, Callable[[], object]] = {"ours": lambda: surface.at(u, v)}
    six: dict[str, Callable[[], object]] = {"ours": lambda: surface.jet(u, v, 2)}
    grid: dict[str, Callable[[], object]] = {"ours": lambda: surface.grid(x, x)}
    sloped: dict[str, Callable[[], object]] = {"ours": lambda: surface.grid(x, x, 1)}
    one: dict[str, Callable[[], object]] = {"ours": lambda: surface.jet(0.3, 0.6, 1)}
    scipy = imported("scipy.interpolate")
    if scipy is not None:
        peer = scipy.NdBSpline((surface.knots_u, surface.knots_v), surface.points, (3, 3))
        places, first = np.stack((u, v), axis=-1), [[0, 0], [1, 0], [0, 1]]
        orders = [*first, [2, 0], [1, 1], [0, 2]]
        off = max(
            np.abs(surface.at(u[:999], v[:999], *nu) - peer(places[:999], nu=nu)).max()
            / np.abs(peer(places[:999], nu=nu)).max()
            for nu in orders
        )
        print(f"  {off:.1e} from scipy, of the size of each derivative")
        all_of_grid = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1)
        values["scipy"] = lambda: peer(places)
        six["scipy"] = lambda: [peer(places, nu=nu) for nu in orders]
        grid["scipy"] = lambda: peer(all_of_grid)
        sloped["scipy"] = lambda: [peer(all_of_grid, nu=nu) for nu in first]
        one["scipy"] = lambda: [peer([[0.3, 0.6]], nu=nu) for nu in first]
    add_splipy(surface, x, (grid, sloped))
    add_geomdl(surface, one)
    row("one place and both slopes, us", 1e6, one, 200)
    row(f"{MANY} random places, ms", 1e3, values)
    row(f"{MANY} with all second derivatives, ms", 1e3, six)
    row(f"grid of {SIDE} x {SIDE}, ms", 1e3, grid)
    row(f"grid of {SIDE} x {SIDE} with slopes, ms", 1e3, sloped)


def add_splipy(
    surface: BSplineSurface, x: np.ndarray, grids: tuple[dict[str, Callable[[], object]], ...]
) -> None:
    """Add splipy to the rows of grids, which is all that it is quick at."""
    splipy = imported("splipy")
    if splipy is None:
        return
    bases = [splipy.BSplineBasis(4, knots) for knots in (surface.knots_u, surface.knots_v)]
    theirs = splipy.Surface(*bases, surface.points.swapaxes(0, 1).reshape(-1, 3))
    print(f"  {np.abs(theirs(x, x) - surface.grid(x, x)[:, :, 0, 0]).max():.1e} from splipy")
    grids[0]["splipy"] = lambda: theirs(x, x)
    grids[1]["splipy"] = lambda: [theirs.derivative(x, x, d=d) for d in ((0, 0), (1, 0), (0, 1))]


def add_geomdl(surface: BSplineSurface, one: dict[str, Callable[[], object]]) -> None:
    """Add geomdl to the row of single places."""
    geomdl = imported("geomdl.BSpline")
    if geomdl is None:
        return
    theirs = geomdl.Surface()
    theirs.degree_u = theirs.degree_v = 3
    theirs.set_ctrlpts(surface.points.reshape(-1, 3).tolist(), 30, 20)
    theirs.knotvector_u, theirs.knotvector_v = surface.knots_u.tolist(), surface.knots_v.tolist()
    one["geomdl"] = lambda: theirs.derivatives(0.3, 0.6, 1)


def timed(name: str, work: Callable[[], object], said: Callable[[object], str]) -> None:
    """Print how long our own work takes, and what came out."""
    result = work()
    took = np.inf
    for _ in range(5):
        start = time.perf_counter()
        result = work()
        took = min(took, time.perf_counter() - start)
    print(f"{name:42} {1e3 * took:9.3f} ms  {said(result)}")


def print_own() -> None:
    """Print figures of what no peer has."""
    upright = Plane(np.array([3.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    torus = revolved(conic.circle(1.0, upright), [0, 0, 0], [0, 0, 1])
    u, v = np.random.default_rng(0).uniform(0.0, 1.0, (2, 10_000))
    place = torus.at(u, v)
    from_axis = np.hypot(place[:, 0], place[:, 1])
    tube = np.hypot(from_axis - 3.0, place[:, 2])
    print(f"a torus of radii 3 and 1: its tube is off by {np.abs(tube - 1.0).max():.1e}")
    rational = random_surface(rational=True)
    timed("10 000 jets of order 2, rational", lambda: rational.jet(u, v, 2), lambda _: "")
    timed("10 000 normals", lambda: normal(torus, u, v), lambda _: "")
    exact = (from_axis - 3.0) / from_axis
    timed(
        "10 000 principal curvatures",
        lambda: curvatures(torus, u, v).values,
        lambda k: f"off by {np.abs(k[:, 0] - exact).max():.1e}",
    )
    whole = 12.0 * np.pi**2
    timed("area", lambda: area(torus), lambda a: f"off by {abs(a / whole - 1):.1e} of it")
    timed("box to 1e-9", lambda: bounding_box(torus), lambda b: f"up to {b[1].tolist()}")
    point = np.array([1.0, 2.0, 1.5])
    wanted = np.hypot(np.hypot(1.0, 2.0) - 3.0, 1.5) - 1.0
    timed(
        "nearest place, certified to 1e-9",
        lambda: nearest_on_surface(torus, point),
        lambda found: f"off by {abs(found.distance - wanted):.1e} m",
    )
    timed(
        "offset by 0.4 as a B-spline to 1e-6",
        lambda: OffsetSurface(torus, 0.4).to_bspline(1e-6),
        lambda fit: f"{fit[0].points.shape[:2]} points, off by {fit[1]:.1e} m",
    )
    rng = np.random.default_rng(2)
    points = np.column_stack((np.linspace(0.0, 1.0, 8), rng.uniform(-0.2, 0.2, (8, 2))))
    path = BSpline(np.r_[0, 0, 0, np.arange(6.0), 5, 5, 5], points, 3)
    timed(
        "sweep of a circle to 1e-6",
        lambda: swept(conic.circle(0.05), path, 1e-6),
        lambda surface: f"{surface.points.shape[:2]} points",
    )


def main() -> None:
    """Print where and when, then the rows."""
    print(f"{datetime.datetime.now(tz=datetime.UTC):%Y-%m-%d %H:%M} UTC, {platform.platform()}")
    print(f"{processor()}, cores {sorted(os.sched_getaffinity(0))}, numpy {np.__version__}")
    print("bicubic, 30 x 20 control points in space")
    compare_polynomial()
    print_own()


if __name__ == "__main__":
    main()
