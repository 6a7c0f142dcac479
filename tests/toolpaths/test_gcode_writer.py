"""NC programs that are written: they mean what was planned, in every dialect."""

from math import inf, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.curves.conic import arc
from splinearm.errors import GcodeError, ToolpathError
from splinearm.toolpaths.action import (
    ArcFeed,
    Dwell,
    Feed,
    Message,
    Pause,
    Rapid,
    Spindle,
    SplineFeed,
    Switch,
    ToolChange,
)  # fmt: skip
from splinearm.toolpaths.gcode_check import require_same, write_checked
from splinearm.toolpaths.gcode_dialect import DIALECTS, dialect_of
from splinearm.toolpaths.gcode_interpreter import run_gcode_text
from splinearm.toolpaths.gcode_writer import write_gcode

MM = 1e-3
LINUXCNC, GRBL = DIALECTS["linuxcnc"], DIALECTS["grbl"]
CUT = {"feed": 0.01, "blend": inf}


def mm(*values):
    return np.array(values, dtype=float) * MM


def rapid(start, end):
    return Rapid(start=mm(*start), end=mm(*end))


def feed(start, end, **cut):
    return Feed(start=mm(*start), end=mm(*end), **(CUT | cut))


def level(points, weights=None, degree=3):
    """Give a spline in the plane z = -1 mm."""
    flat = np.column_stack((np.array(points, dtype=float), np.full(len(points), -1.0))) * MM
    inner = np.arange(1, len(points) - degree)
    knots = np.concatenate((np.zeros(degree + 1), inner, np.full(degree + 1, len(points) - degree)))
    return BSpline(knots, flat, degree, weights)


@st.composite
def plans(draw):
    """Give a way of lines, arcs about all axes and rapids, each beginning where the last ended."""
    number = st.floats(-200, 200).map(lambda x: round(x, 3))
    place = np.array([0.0, 0.0, 0.0])
    actions = []
    for _ in range(draw(st.integers(1, 8))):
        kind = draw(st.sampled_from(["rapid", "feed", "arc"]))
        if kind == "arc" and actions:
            axis = draw(st.integers(0, 2))
            radius, begin = draw(st.floats(0.5, 300)), draw(st.floats(-pi, pi))
            turn = draw(st.floats(0.05, 4 * pi)) * draw(st.sampled_from([-1, 1]))
            rise = draw(st.sampled_from([0.0, -2.0]))
            a, b = (axis + 1) % 3, (axis + 2) % 3
            centre = place.copy()
            centre[a] -= radius * np.cos(begin)
            centre[b] -= radius * np.sin(begin)
            end = centre.copy()
            end[a] += radius * np.cos(begin + turn)
            end[b] += radius * np.sin(begin + turn)
            end[axis] += rise
            way = ArcFeed(
                start=place * MM, end=end * MM, centre=centre * MM, axis=axis, turn=turn, **CUT
            )
        else:
            end = np.array([draw(number) for _ in range(3)])
            way = (rapid if kind != "feed" else feed)(place, end)
        actions.append(way)
        place = end
    return actions


@pytest.mark.property
@pytest.mark.parametrize("dialect", DIALECTS.values(), ids=DIALECTS)
@given(plan=plans())
def test_what_is_written_reads_as_it_was_planned(dialect, plan):
    text = write_checked(plan, dialect, "a plan")
    assert max(map(len, text.splitlines())) <= dialect.longest_line
    ends = [a.end for a in run_gcode_text(text) if isinstance(a, Rapid | Feed | ArcFeed)]
    if ends:
        np.testing.assert_allclose(ends[-1], plan[-1].end, atol=dialect.resolution)


def test_words_that_hold_are_left_out():
    plan = [rapid((0, 0, 0), (1, 0, 0)), rapid((1, 0, 0), (1, 2, 0)), feed((1, 2, 0), (1, 2, -1))]
    lines = write_gcode(plan, GRBL).splitlines()
    assert lines == ["G17 G21 G90 G94", "G0 X1 Y0 Z0", "Y2", "G1 Z-1 F600", "M2"]


def test_what_is_switched_is_written_for_the_controller():
    plan = [
        ToolChange(tool=2), Spindle(speed=100 * pi), Message(text="up (now)"), Switch(code="M8"),
        rapid((0, 0, 0), (0, 0, 5)), Dwell(time=0.25), Spindle(speed=0.0), Pause(code="M30"),
    ]  # fmt: skip
    linuxcnc, grbl = write_checked(plan, LINUXCNC), write_checked(plan, GRBL)
    for words in ("T2 M6", "G43 H2", "S3000 M3", "(MSG, up [now])", "M8", "G4 P0.25", "M5", "M30"):
        assert words in linuxcnc.splitlines()
    assert linuxcnc.splitlines()[0] == linuxcnc.splitlines()[-1] == "%"
    assert "M6" not in grbl
    assert "(change to tool 2)\nM0" in grbl


def test_cubics_are_written_as_such_and_rationals_with_their_weights():
    start = feed((0, 0, 0), (0, 0, -1))
    cubic = level([(0, 0), (1, 2), (3, 2), (4, 0), (5, -3), (9, 0)])
    round_ = arc(5 * MM, 0.0, pi / 2)
    quarter = BSpline(
        round_.knots,
        np.column_stack((round_.points - round_.points[0] + mm(9, 0), np.full(3, -MM))),
        2,
        round_.weights,
    )
    plan = [
        start,
        SplineFeed(start=cubic.points[0], end=cubic.points[-1], curve=cubic, **CUT),
        SplineFeed(start=quarter.points[0], end=quarter.points[-1], curve=quarter, **CUT),
    ]
    text = write_checked(plan, LINUXCNC)
    assert text.count("G5 X") == 3
    assert "G5.2 P1 L3" in text
    assert "P0.707106781" in text
    with pytest.raises(GcodeError, match="grbl has no splines"):
        write_gcode(plan, GRBL)
    with pytest.raises(GcodeError, match="begins with a line"):
        write_gcode(plan[1:], LINUXCNC)


def test_an_arc_so_large_that_it_is_a_line_is_written_as_one():
    def bent(radius):
        turn = 10 * MM / radius
        end = np.array([radius * np.sin(turn), radius * (1 - np.cos(turn)), 0.0])
        centre = np.array([0.0, radius, 0.0])
        way = ArcFeed(start=mm(0, 0, 0), end=end, centre=centre, axis=2, turn=turn, **CUT)
        return [rapid((0, 0, 1), (0, 0, 0)), way]

    assert "G3" in write_gcode(bent(5.0), GRBL)
    assert "G3" not in write_gcode(bent(1e5), GRBL)
    with pytest.raises(GcodeError, match="bends by"):
        write_gcode(bent(15.0), GRBL)


def test_how_corners_are_taken_is_said():
    plan = [
        feed((0, 0, 0), (1, 0, 0), blend=None),
        feed((1, 0, 0), (2, 0, 0), blend=0.05 * MM),
        feed((2, 0, 0), (3, 0, 0)),
    ]
    text = write_gcode(plan, LINUXCNC).splitlines()
    assert [line for line in text if line.startswith("G6")] == ["G61", "G64 P0.05", "G64"]


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (("X20", "X21"), "beside the plan"),
        (("F600", "F700"), "another feed"),
        (("G1", "G0"), "cuts where it must not|cannot be read"),
        (("X20", "Q20"), "cannot be read"),
        (("M2", "X30"), "3 ways, 2 planned"),
    ],
)
def test_a_program_that_is_another_than_the_plan_is_refused(change, reason):
    plan = [rapid((0, 0, 0), (1, 1, 0)), feed((1, 1, 0), (20, 1, 0))]
    text = write_gcode(plan, GRBL)
    require_same(plan, text, GRBL)
    with pytest.raises(ToolpathError, match=reason):
        require_same(plan, text.replace(*change), GRBL)


@pytest.mark.parametrize("wrong", [0.0, -1.0, inf, None, 1e-9])
def test_a_feed_that_cannot_be_written_is_refused(wrong):
    with pytest.raises(GcodeError, match="F: "):
        write_gcode([feed((0, 0, 0), (1, 0, 0), feed=wrong)], GRBL)


def test_there_are_only_the_dialects_that_there_are():
    with pytest.raises(ValueError, match="linuxcnc, grbl"):
        dialect_of("fanuc")
