"""The order of ways that leads to the shortest travel."""

from itertools import permutations

import numpy as np
import pytest

from splinearm.toolpaths.order import shortest_order, travel


def test_every_way_is_done_once():
    rng = np.random.default_rng(1)
    starts, ends = rng.uniform(size=(2, 60, 2))
    order = shortest_order(starts, ends, turnable=[True] * 60)
    assert sorted(i for i, _ in order) == list(range(60))
    assert shortest_order(np.empty((0, 2))) == ()


@pytest.mark.parametrize("seed", range(6))
def test_the_order_of_few_points_is_nearly_the_shortest(seed):
    points = np.random.default_rng(seed).uniform(size=(7, 2))
    best = min(
        travel(points, points, [(i, False) for i in p], (0.0, 0.0)) for p in permutations(range(7))
    )
    found = travel(points, points, shortest_order(points), (0.0, 0.0))
    assert best <= found <= 1.1 * best


def test_a_way_that_cannot_be_turned_is_not():
    rng = np.random.default_rng(2)
    starts, ends = rng.uniform(size=(2, 40, 2))
    turnable = [i % 2 == 0 for i in range(40)]
    order = shortest_order(starts, ends, turnable=turnable)
    assert not any(back for i, back in order if i % 2)
    assert any(back for _, back in order)


def test_turning_parts_about_makes_it_shorter():
    # the nearest next leaves one point behind, to which it must come back
    x = np.array([0.0, 1.0, -1.1, 3.0, 7.0, 15.0])
    points = np.stack((x, np.zeros(6)), axis=1)
    nearest = [(0, False), (1, False), (3, False), (2, False), (4, False), (5, False)]
    assert travel(points, points, shortest_order(points), (0, 0)) < travel(
        points, points, nearest, (0, 0)
    )
