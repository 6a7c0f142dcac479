"""Parts to be milled, and what is asked of every way of a cutter."""

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np
import pytest

from splinearm.arrays import FloatArray
from splinearm.toolpaths.action import Action, ArcFeed, Feed, Moving, Rapid
from splinearm.toolpaths.checking import verified
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.contour_kernel import distances
from splinearm.toolpaths.cutter import Cutter
from splinearm.toolpaths.gcode_check import write_checked
from splinearm.toolpaths.gcode_dialect import DIALECTS
from splinearm.toolpaths.offset import Offsets
from splinearm.toolpaths.operation import Milling
from splinearm.toolpaths.region import Region
from splinearm.toolpaths.work import Done

RADIUS = 2e-3


def _cutter(**changes: object) -> Cutter:
    facts = {
        "number": 1, "name": "end mill", "diameter": 2.0 * RADIUS, "feed": 0.015,
        "plunge": 0.005, "speed": 1000.0, "step_down": 2e-3, "step_over": 1.8e-3,
    }  # fmt: skip
    return Cutter(**(facts | changes))


def _star(n: int, seed: int) -> Region:
    """Give a pocket with arcs, necks and sharp corners."""
    rng = np.random.default_rng(seed)
    angle = 2.0 * np.pi * (np.arange(n) + rng.uniform(-0.3, 0.3, n)) / n
    far = 0.03 * (1.0 + 0.35 * rng.uniform(-1, 1, n))
    points = far[:, None] * np.stack((np.cos(angle), np.sin(angle)), axis=1)
    return Region(Contour(points, np.where(np.arange(n) % 2, 0.0, rng.uniform(-0.15, 0.15, n))))


@pytest.fixture(scope="session")
def parts() -> dict[str, Region]:
    """Regions by name."""
    plate = Contour.rectangle([0.0, 0.0], [0.06, 0.04], 0.004)
    wedge = Contour.polyline([[0.0, 0.0], [0.06, 0.0], [0.0, 0.025]])
    bone = Contour.polyline(
        np.array([[0, 0], [20, 0], [20, 7], [40, 7], [40, 0], [60, 0], [60, 20], [40, 20],
                  [40, 12.5], [20, 12.5], [20, 20], [0, 20]]) * 1e-3
    )  # fmt: skip
    islands = (
        Contour.circle([0.018, 0.02], 0.005),
        Contour.rectangle([0.035, 0.012], [0.012, 0.014], 0.001),
    )
    return {
        "plate": Region(plate),
        "islands": Region(plate, islands),
        "wedge": Region(wedge),
        "bone": Region(bone),
        "star": _star(12, 3),
        "disc": Region(Contour.circle([0.0, 0.0], 0.013)),
    }


@pytest.fixture
def milling() -> Callable[..., Milling]:
    """Gives how a cutter is used, with changes; those that name the cutter's facts change it."""

    def made(**changes: object) -> Milling:
        own = {k: changes.pop(k) for k in ("diameter", "speed", "number") if k in changes}
        return Milling(**({"cutter": _cutter(**own), "depth": 2e-3} | changes))

    return made


class Cuts:
    """The ways of a toolpath that cut, as pieces."""

    def __init__(self, actions: Iterable[Action]) -> None:
        self.actions = tuple(actions)
        self.ways = [a for a in self.actions if isinstance(a, Feed | ArcFeed)]

    def at(self, z: float) -> FloatArray:
        """Give the pieces of ways that are level at a height, shape (n, 9)."""
        return self._pieces([w for w in self.ways if w.start[2] == z and w.end[2] == z])

    def below(self, z: float) -> FloatArray:
        """Give the pieces of ways that are somewhere below a height, seen from above."""
        return self._pieces([w for w in self.ways if min(w.start[2], w.end[2]) < z])

    def _pieces(self, ways: Iterable[Feed | ArcFeed]) -> FloatArray:
        rows = [np.empty((0, 9))]
        for way in ways:
            if (way.start[:2] == way.end[:2]).all() and isinstance(way, Feed):
                continue
            bulge = np.tan(0.25 * way.turn) if isinstance(way, ArcFeed) else 0.0
            path = Contour(np.array([way.start[:2], way.end[:2]]), np.array([bulge]), closed=False)
            rows.append(path.packed()[0])
        return np.ascontiguousarray(np.concatenate(rows))


@pytest.fixture
def cuts() -> type[Cuts]:
    """The ways of a toolpath that cut."""
    return Cuts


def gaps(pieces: FloatArray, points: FloatArray) -> FloatArray:
    """Give how far points are from pieces, m."""
    found = np.empty(len(points))
    distances(pieces, np.ascontiguousarray(points), found)
    return found


@pytest.fixture
def uncut() -> Callable[..., float]:
    """Gives how far beyond the cutter's radius something is that it could have taken, m."""

    def measured(part: Region, pieces: FloatArray, reach: float, radius: float) -> float:
        rng = np.random.default_rng(0)
        x0, y0, x1, y1 = part.bounds
        points = rng.uniform([x0, y0], [x1, y1], (6000, 2))
        points = points[part.contains(points)]
        rooms = Offsets(part).at(-reach)
        taken = np.zeros(len(points), dtype=bool)
        for room in rooms:
            taken |= room.contains(points) | (room.distance(points) < radius * (1.0 - 1e-9))
        return float((gaps(pieces, points[taken]) - radius).max(initial=-radius))

    return measured


class Checks(NamedTuple):
    """What is asked of every toolpath."""

    cuts: type[Cuts]
    uncut: Callable[..., float]
    follows: Callable[[Iterable[Action]], None]


@pytest.fixture
def checks(uncut: Callable[..., float], follows: Callable[[Iterable[Action]], None]) -> Checks:
    """What is asked of every toolpath."""
    return Checks(Cuts, uncut, follows)


@pytest.fixture
def follows() -> Callable[[Iterable[Action]], None]:
    """Checks that each way begins where the one before it ended and rapid ways stay above."""

    def check(actions: Iterable[Action], safe: float = 5e-3) -> None:
        place = None
        for action in actions:
            if not isinstance(action, Moving):
                continue
            if place is not None:
                np.testing.assert_array_equal(action.start, place)
            if isinstance(action, Rapid) and place is not None:
                level = (action.start[:2] == action.end[:2]).all()
                assert level or action.start[2] == action.end[2] == safe
            place = action.end

    return check


@pytest.fixture
def proven(follows: Callable[[Iterable[Action]], None]) -> Callable[..., str]:
    """Checks ways against the drawing itself, splines included, and gives their NC program."""

    def check(actions: Sequence[Action], done: Sequence[Done], tolerance: float) -> str:
        follows(actions)
        report = verified(actions, done, tolerance)
        assert report is not None
        assert report.ok, report.text()
        assert report.gouge <= 1e-9
        return write_checked(actions, DIALECTS["linuxcnc"])

    return check
