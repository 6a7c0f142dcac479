"""Areas of offsets where they are known in closed form."""

from math import pi, tan

import numpy as np
import pytest

from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.offset import offset
from splinearm.toolpaths.region import Region

pytestmark = pytest.mark.kernel


def wedge(turn, d):
    """What rounding of a corner that turns by so much adds to both straight strips beside it."""
    return 0.5 * d * d * turn if turn > 0.0 else d * d * tan(0.5 * turn)


def test_areas_of_three_hundred_polygons_before_anything_collapses_are_those_of_steiners_formula():
    rng = np.random.default_rng(7)
    for _ in range(300):
        n = int(rng.integers(3, 40))
        angle = 2.0 * pi * (np.arange(n) + rng.uniform(-0.2, 0.2, n)) / n
        far = rng.uniform(0.6, 1.0, n)
        points = far[:, None] * np.stack((np.cos(angle), np.sin(angle)), 1)
        part = Contour.polyline(points)
        way = np.roll(points, -1, axis=0) - points
        heading = np.arctan2(way[:, 1], way[:, 0])
        turns = (heading - np.roll(heading, 1) + pi) % (2.0 * pi) - pi
        # up to here no side vanishes and no two that are not neighbours meet
        sides = np.hypot(*way.T) / (2.0 * np.abs(np.tan(0.5 * turns)) + 2.0)
        room = min(sides.min(), 0.2 * clearance(points))
        for d in (room, -room):
            sign = np.sign(d)
            added = sign * sum(wedge(sign * turn, abs(d)) for turn in turns)
            wanted = part.area + d * part.length + added
            (result,) = offset(part, d)
            assert result.area == pytest.approx(wanted, rel=1e-12)


def clearance(points):
    """How near sides that are not neighbours come, and how short they are."""
    n, ends = len(points), np.roll(points, -1, axis=0)
    best = np.hypot(*(ends - points).T).min()
    for i in range(n):
        for k in range(n):
            if k in ((i - 1) % n, i):
                continue
            way, off = ends[k] - points[k], points[i] - points[k]
            share = np.clip(off @ way / (way @ way), 0.0, 1.0)
            best = min(best, float(np.hypot(*(off - share * way))))
    return best


def test_areas_of_a_hundred_rounded_rectangles_with_round_islands_are_known():
    rng = np.random.default_rng(8)
    for _ in range(100):
        w, h = rng.uniform(2.0, 4.0, 2)
        r = rng.uniform(0.2, 0.8)
        island = rng.uniform(0.1, 0.3)
        part = Region(
            Contour.rectangle([-0.5 * w, -0.5 * h], [w, h], r), (Contour.circle([0, 0], island),)
        )
        for d in rng.uniform(-0.33, 0.09, 4):
            left = max(0.0, r + d)
            wanted = (w + 2 * d) * (h + 2 * d) - (4.0 - pi) * left**2 - pi * (island - d) ** 2
            (result,) = offset(part, d)
            assert result.area == pytest.approx(wanted, rel=1e-12)


def round_of_chords(n):
    """A circle of n chords, and how far its middle is from them."""
    angle = 2.0 * pi * np.arange(n) / n
    return Contour.polyline(np.stack((np.cos(angle), np.sin(angle)), 1)), np.cos(pi / n)


@pytest.mark.parametrize(("n", "left"), [(240, 1e-4), (240, 1e-6), (600, 1e-7)])
def test_a_region_of_many_sides_is_right_just_before_it_vanishes(n, left):
    outline, room = round_of_chords(n)
    (result,) = offset(outline, -room * (1.0 - left))
    assert result.area == pytest.approx(n * tan(pi / n) * (room * left) ** 2, rel=1e-3)


@pytest.mark.parametrize(
    ("n", "left"), [(400, 1e-8), pytest.param(30_000, 2e-8, marks=pytest.mark.slow)]
)
def test_what_is_left_of_many_sides_vanishes_where_these_are_too_short_to_tell(n, left):
    outline, room = round_of_chords(n)
    assert offset(outline, -room * (1.0 - left)) == ()
