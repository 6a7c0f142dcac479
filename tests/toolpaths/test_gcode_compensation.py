"""Cutter compensation: beside the whole contour by the radius, and never into it."""

from math import pi

import numpy as np
import pytest

from splinearm.errors import GcodeError, GougeError
from splinearm.toolpaths.action import ArcFeed, Feed
from splinearm.toolpaths.gcode_compensation import compensate
from splinearm.toolpaths.gcode_interpreter import run_gcode_text

pytestmark = pytest.mark.kernel

MM = 1e-3


def cut(text):
    return compensate(run_gcode_text("G21 G90 F600\n" + text))


def ends(compensated):
    return np.array([a.end for a in compensated.actions if hasattr(a, "end")]) / MM


def test_a_square_is_gone_around_outside_with_arcs_at_its_corners():
    found = cut("G0 X-20 Y-10\nG41.1 D6 G1 X0 Y-5\nY30\nX30\nY0\nX-5\nG40 X-20 Y-10\n")
    wanted = [
        (-20, -10), (-3, -5), (-3, 30), (0, 33), (30, 33), (33, 30), (33, 0), (30, -3), (-5, -3),
        (-20, -10),
    ]  # fmt: skip
    np.testing.assert_allclose(ends(found)[:, :2], wanted, atol=1e-9)
    arcs = [a for a in found.actions if isinstance(a, ArcFeed)]
    assert [arc.turn for arc in arcs] == [pytest.approx(-pi / 2)] * 3
    assert all(arc.side == 0 and arc.feed == pytest.approx(0.01) for arc in arcs)
    assert found.unreached == ()


def test_ways_in_and_out_on_arcs_touch_the_contour():
    text = "G0 X-30 Y15\nG41.1 D6 G1 X-10 Y5\nG3 X0 Y15 R10\nG1 Y30\nX30\nY0\nX0\nY15\n"
    found = cut(text + "G3 X-10 Y25 R10\nG40 G1 X-30 Y15\n")
    arcs = [a for a in found.actions if isinstance(a, ArcFeed)]
    assert [round(arc.radius_at_start / MM, 9) for arc in arcs] == [7, 3, 3, 3, 3, 7]
    np.testing.assert_allclose(arcs[0].end[:2] / MM, (-3, 15), atol=1e-9)
    np.testing.assert_allclose(arcs[-1].start[:2] / MM, (-3, 15), atol=1e-9)
    assert found.unreached == ()
    with pytest.raises(GougeError, match="larger than the tool"):
        cut(text.replace("D6", "D22") + "G3 X-10 Y25 R10\nG40 G1 X-30 Y15\n")


def test_inside_corners_stay_sharp():
    found = cut("G0 X15 Y15\nG42.1 D6 G1 X0 Y15\nY30\nX30\nY0\nX0\nY15\nG40 X15\n")
    wanted = [(15, 15), (3, 15), (3, 27), (27, 27), (27, 3), (3, 3), (3, 15), (15, 15)]
    np.testing.assert_allclose(ends(found)[:, :2], wanted, atol=1e-9)


def test_every_place_is_at_the_radius_from_the_contour():
    text = "G0 X0 Y30\nG41.1 D4 G1 Y20\nG3 X10 Y10 R10\nG1 X20\nG2 X30 Y20 R10\nG1 Y40\nG40 X20\n"
    found = cut(text)
    raw = [a for a in run_gcode_text("G21 F600\n" + text) if isinstance(a, Feed | ArcFeed)][1:-1]
    source = np.vstack([place(a) for a in raw])
    for action in [a for a in found.actions if isinstance(a, Feed | ArcFeed)][1:-1]:
        gaps = np.linalg.norm(place(action)[:, None] - source, axis=2).min(axis=1)
        np.testing.assert_allclose(gaps, 2 * MM, atol=2e-6)


def place(action):
    x = np.linspace(0, 1, 2001)
    if isinstance(action, ArcFeed):
        return action.at(x)
    return action.start + x[:, None] * (action.end - action.start)


def test_a_notch_that_is_too_narrow_is_left_out_and_told():
    notch = "G0 X-10 Y9\nG41.1 D6 G1 X0 Y5\nX20\nY0\nX24\nY5\nX50\nG40 Y20\n"
    found = cut(notch)
    assert [u.line for u in found.unreached] == [5, 6, 7]
    x, y = found.unreached[1].where
    assert (x / MM, y / MM) == (pytest.approx(22), pytest.approx(0))
    assert found.unreached[1].left == pytest.approx((8 - 3) * MM, abs=1.5e-3)
    assert ends(found)[:, 1].min() > 7


def test_plunges_stay_where_the_tool_is():
    found = cut("G0 X-9 Y0 Z5\nG41.1 D6 G1 X0 Y0\nZ-1\nX20\nG40 Y10\n")
    np.testing.assert_allclose(
        ends(found), [(-9, 0, 5), (0, 3, 5), (0, 3, -1), (20, 3, -1), (20, 10, -1)], atol=1e-9
    )


def test_what_is_not_marked_is_left_as_it_is():
    actions = run_gcode_text("F100\nG0 X1\nG1 Y2\nG2 X3 Y2 R1\nG4 P1\nM2")
    assert compensate(actions).actions == actions


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("G41.1 D2 G2 X2 Y0 I1\nG1 X5", "a line must lead"),
        ("G41.1 D2 G1 X2\nG40 X5", "no contour follows"),
        ("G41.1 D2 G1 X2\nX5 Z-1\nG40 X9", "rises beside"),
        ("G41.1 D2 G1 X2\nG5 X5 I1 J1 P1 Q1\nG40 G1 X9", "write lines and arcs"),
    ],
)
def test_what_is_no_contour_is_refused_with_its_line(text, reason):
    with pytest.raises(GcodeError, match=reason) as caught:
        cut(text)
    assert caught.value.line >= 2


def test_a_way_to_the_contour_that_cuts_it_is_refused():
    with pytest.raises(GougeError, match="begin farther off"):
        cut("G0 X10 Y-20\nG41.1 D6 G1 X0 Y0\nX20\nG40 Y10\n")


def test_a_tool_that_does_not_fit_is_refused():
    with pytest.raises(GougeError, match="smaller one"):
        cut("G0 X5 Y30\nG41.1 D12 G1 X5 Y20\nX0\nY0\nX10\nY20\nX5.5\nG40 Y30\n")
