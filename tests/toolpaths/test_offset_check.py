"""The check of offsets: it lets right ones pass and names what is wrong with others."""

import json
import os
import subprocess
import sys
from math import pi, tan

import numpy as np
import pytest

from splinearm.errors import GougeError, OffsetError
from splinearm.toolpaths.contour import Contour, joined
from splinearm.toolpaths.offset import offset
from splinearm.toolpaths.offset_check import Loops, check_offset

pytestmark = pytest.mark.kernel

ROUNDED = Contour.rectangle([-0.4, -0.3], [0.8, 0.6], 0.1)
D = 0.05


def loops(*contours):
    return Loops(*joined(contours))


def check(result, part=ROUNDED, d=D, **keywords):
    keywords = {"outward": False, "tolerance": 1e-12, **keywords}
    check_offset(loops(*result) if result else nothing(), loops(part), d, **keywords)


def nothing():
    return Loops(np.empty((0, 2)), np.empty(0), np.zeros(1))


def test_a_right_offset_passes():
    check([Contour.rectangle([-0.35, -0.25], [0.7, 0.5], 0.05)])
    grown = Contour.rectangle([-0.45, -0.35], [0.9, 0.7], 0.15)
    check([grown.reversed()], ROUNDED.reversed(), outward=True)


@pytest.mark.parametrize("depth", [1e-10, 1e-6, 1e-3])
def test_a_gouge_is_named_with_its_place_and_depth(depth):
    # the right side is moved outwards
    vertices = np.array(Contour.rectangle([-0.35, -0.25], [0.7, 0.5]).vertices)
    vertices[1:3, 0] += depth
    with pytest.raises(GougeError) as caught:
        check([Contour.polyline(vertices)], Contour.rectangle([-0.4, -0.3], [0.8, 0.6]))
    assert caught.value.depth == pytest.approx(depth, rel=1e-4)
    assert caught.value.where[0] == pytest.approx(0.35 + depth)


@pytest.mark.parametrize("bulge", [0.02, -0.02])
def test_a_gouge_in_the_middle_of_an_arc_is_found(bulge):
    # the part's side is an arc, and so is the wrong result; their ends are far enough from it
    part = Contour.polyline([[-0.4, -0.3], [0.4, -0.3], [0.4, 0.3], [-0.4, 0.3]])
    square = Contour.rectangle([-0.35, -0.25], [0.7, 0.5])
    wrong = Contour(square.vertices, np.array([bulge, 0.0, 0.0, 0.0]))
    error = GougeError if bulge > 0.0 else OffsetError
    with pytest.raises(error):
        check([wrong], part)


@pytest.mark.parametrize("bulge", [0.0, 1e-9, 0.3])
def test_a_way_through_a_wall_is_found(bulge):
    # between two of its corners, which are far from it, the result passes through a thin wall
    comb = Contour.polyline(
        [[-1, -1], [1, -1], [1, 1], [0.01, 1], [0.01, 0], [-0.01, 0], [-0.01, 1], [-1, 1]]
    )
    through = Contour(
        np.array([[-0.9, -0.9], [0.9, -0.9], [0.9, 0.5], [-0.9, 0.5]]), np.array([0, 0, bulge, 0])
    )
    with pytest.raises(GougeError):
        check([through], comb)


def test_what_is_too_far_and_what_is_missing_is_found():
    inner = Contour.rectangle([-0.35, -0.25], [0.7, 0.5], 0.05)
    with pytest.raises(OffsetError, match="too far"):
        check([inner.transformed(scale=0.9)])
    with pytest.raises(OffsetError, match="missing"):
        check([])


def rooms(count):
    """A row of rooms along a corridor too narrow for D: one region a room when shrunk by it."""
    corners = []
    for k in range(count):
        corners += [(k, 0.0), (k + 0.6, 0.0), (k + 0.6, 0.2), (k + 1.0, 0.2)]
    top = [(x, 0.5 - y) for x, y in corners[::-1]]
    return Contour.polyline(np.array(corners + top) * 0.02)


@pytest.mark.parametrize("left_out", range(12))
def test_each_region_that_is_left_out_is_missed_wherever_it_is(left_out):
    part, d = rooms(12), 0.0012
    found = [region.outer for region in offset(part, -d)]
    assert len(found) == 12
    check(found, part, d)
    with pytest.raises(OffsetError, match="missing"):
        check(found[:left_out] + found[left_out + 1 :], part, d)


def test_holes_that_are_left_out_loops_given_twice_and_loops_of_the_other_side_are_found():
    outer = Contour.rectangle([-0.4, -0.4], [0.8, 0.8])
    hole = Contour.circle([0.1, 0.05], 0.1, clockwise=True)
    part = loops(outer, hole)
    right = [
        Contour.rectangle([-0.35, -0.35], [0.7, 0.7]),
        Contour.circle([0.1, 0.05], 0.15, clockwise=True),
    ]

    def ask(*contours):
        check_offset(loops(*contours), part, D, outward=False, tolerance=1e-12)

    ask(*right)
    wrong = [
        right[:1],
        right[1:],
        [*right, right[1]],
        [*right, Contour.circle([0.1, 0.05], 0.05)],
        [*right, Contour.rectangle([-0.45, -0.45], [0.9, 0.9], 0.05).reversed()],
    ]
    for contours in wrong:
        with pytest.raises(OffsetError, match="missing or too much"):
            ask(*contours)


def test_nearly_straight_arcs_are_measured_as_well_as_others():
    for bulge in (1e-3, 1e-5, 1e-7, 1e-9, 1e-12, 1e-15):
        part = Contour(
            np.array([[-0.4, -0.3], [0.4, -0.3], [0.4, 0.3], [-0.4, 0.3]]), np.full(4, bulge)
        )
        (result,) = offset(part, -D)
        check(result.contours, part)
        moved = result.outer.transformed(shift=(1e-9, 0.0))
        with pytest.raises(GougeError):
            check([moved], part)


def test_a_bulging_result_of_half_circles_is_measured():
    circle = Contour.circle([0.0, 0.0], 0.4)
    check([Contour.circle([0.0, 0.0], 0.35)], circle)
    whole = Contour(
        np.array([[0.35, 0.0], [0.35 * np.cos(0.3), 0.35 * np.sin(0.3)]]),
        np.array([tan(0.075), tan((2 * pi - 0.3) / 4)]),
    )
    check([whole], circle)


SAME = """
import json, sys
import numpy as np
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.region import Region
from splinearm.toolpaths.offset import offset, offset_path
rng = np.random.default_rng(3)
t = 2 * np.pi * np.arange(16) / 16
r = rng.uniform(0.7, 1.0, 16)
shape = Contour(np.stack((r * np.cos(t), r * np.sin(t)), 1), rng.uniform(-0.2, 0.2, 16))
part = Region(shape, (Contour.circle([0.1, 0.0], 0.2),))
found = []
for d, corner in ((-0.05, "round"), (-0.2, "round"), (0.1, "mitre"), (0.1, "chamfer")):
    for region in offset(part, d, corner=corner):
        for contour in region.contours:
            found += [contour.vertices.ravel().tolist(), contour.bulges.tolist()]
    found.append(part.distance([[0.3, 0.3], [2.0, 0.0]]).tolist())
    found.append([float(x) for x in part.contains([[0.3, 0.3], [2.0, 0.0]])])
way = Contour.polyline([[0, 0], [1, 0], [1, 1]], closed=False)
found += [c.vertices.ravel().tolist() for c in offset_path(way, 0.1)]
print(json.dumps(found))
"""


def test_compiled_and_plain_kernels_agree():
    def run(jit):
        done = subprocess.run(
            [sys.executable, "-W", "error", "-c", SAME],
            capture_output=True,
            text=True,
            env={**os.environ, "NUMBA_DISABLE_JIT": jit},
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    fast, plain = run("0"), run("1")
    assert len(fast) == len(plain) > 10
    for a, b in zip(fast, plain, strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-12)
