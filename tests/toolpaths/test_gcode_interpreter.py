"""NC programs with their meaning: places, offsets, arcs, splines, cycles, and what is refused."""

from math import inf, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.errors import GcodeError
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
from splinearm.toolpaths.gcode_interpreter import run_gcode, run_gcode_text
from splinearm.toolpaths.gcode_machine import NcMachine, NcTool

MM = 1e-3
MOVES = (Rapid, Feed, ArcFeed, SplineFeed)


def moves(text, machine=None):
    return [a for a in run_gcode_text(text, machine) if isinstance(a, MOVES)]


def ends(text, machine=None):
    return np.array([move.end for move in moves(text, machine)]) / MM


def close(actual, wanted, atol=1e-12):
    np.testing.assert_allclose(actual, np.asarray(wanted), atol=atol)


def test_places_and_ways_in_both_units():
    close(ends("G21 G0 X10 Y5\nZ-2\nG91 X1 Z1"), [[10, 5, 0], [10, 5, -2], [11, 5, -1]])
    close(ends("G20 G0 X1\nG21 X1"), [[25.4, 0, 0], [1, 0, 0]])
    close(ends("G0 X1", NcMachine(inches=True)), [[25.4, 0, 0]])


def test_moves_are_joined_and_know_their_lines():
    first, second = moves("G0 X1\n\nG1 F600 Y2")
    assert (first.end == second.start).all()
    assert (first.line, second.line) == (1, 3)
    assert isinstance(second, Feed)
    assert second.feed == pytest.approx(10 * MM)


def test_feeds_per_minute_per_turn_and_by_time():
    assert moves("G20\nG1 F60 X1")[0].feed == pytest.approx(25.4 * MM)
    assert moves("G95 S120 M3 G1 F0.5 X1")[0].feed == pytest.approx(0.5 * MM * 2)
    by_time = moves("G93 G1 F2 X1")[0]
    assert by_time.feed is None
    assert by_time.time == pytest.approx(30.0)


def test_a_feed_beside_a_change_of_the_unit_is_told():
    for new, feed in ((False, 60 * MM), (True, 60 * 25.4 * MM)):
        actions = run_gcode_text("G20 G1 F60 X1", NcMachine(feed_in_new_unit=new))
        assert "F60 stands beside a change of the unit" in actions[0].text
        assert actions[1].feed == pytest.approx(feed / 60)
    assert isinstance(run_gcode_text("G21 G1 F60 X1")[0], Feed)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("G1 X1", "F: is missing"),
        ("G95 G1 F1 X1", "S: is missing"),
        ("G93 G1 F2 X1\nX2", "F: is missing"),
        ("G93 F2\nG94 G1 X1", "F: is missing"),
    ],
)
def test_a_way_that_cuts_wants_a_feed(text, reason):
    with pytest.raises(GcodeError, match=reason):
        run_gcode_text(text)


def test_offsets_add_up_and_are_taken_back():
    text = """
    G10 L2 P2 X100 Y10
    G55 G0 X1 Y1
    G92 X0
    G0 X5
    G92.2
    G0 X5
    G92.3
    G0 X0
    G92.1
    G54 G0 X0 Y0
    G52 X3
    G0 X0
    G53 G0 X0
    G10 L20 P1 X7
    G0 X0"""
    close(ends(text)[:, 0], [101, 106, 105, 101, 0, 3, 0, -7])


def test_the_tool_length_lifts_the_tip():
    machine = NcMachine(tools={3: NcTool(diameter=6 * MM, length=50 * MM)})
    close(ends("T3 M6\nG43\nG0 Z10\nG49\nG0 Z10", machine)[:, 2], [60, 10])
    close(ends("G43 H3 G0 Z1\nG43.1 Z5\nG0 Z1", machine)[:, 2], [51, 6])
    with pytest.raises(GcodeError, match="tool 9 is not in the machine's table; there are 3"):
        run_gcode_text("G43 H9", machine)


def test_homes_are_kept_and_gone_to():
    text = "G0 X5 Y5\nG28.1\nG0 X9\nG28\nG30 X1"
    close(ends(text), [[5, 5, 0], [9, 5, 0], [5, 5, 0], [1, 5, 0], [0, 5, 0]])


@pytest.mark.parametrize(
    ("text", "turn", "centre"),
    [
        ("G2 X2 Y0 I1", -pi, (1, 0, 0)),
        ("G3 X2 Y0 I1", pi, (1, 0, 0)),
        ("G3 I1", 2 * pi, (1, 0, 0)),
        ("G2 I1 P3", -6 * pi, (1, 0, 0)),
        ("G2 X1 Y1 I1", -pi / 2, (1, 0, 0)),
        ("G3 X1 Y1 I1", 3 * pi / 2, (1, 0, 0)),
        ("G2 X1 Y1 R1", -pi / 2, (1, 0, 0)),
        ("G2 X1 Y1 R-1", -3 * pi / 2, (0, 1, 0)),
        ("G3 X1 Y1 R1", pi / 2, (0, 1, 0)),
        ("G90.1 G2 X2 Y0 I1 J0", -pi, (1, 0, 0)),
        ("G18 G2 X2 Z0 I1", -pi, (1, 0, 0)),
        ("G18 G3 X1 Z1 I1", pi / 2, (1, 0, 0)),
        ("G19 G3 Y1 Z1 J1", 3 * pi / 2, (0, 1, 0)),
        ("G3 X2 I1 Z5", pi, (1, 0, 0)),
    ],
)
def test_arcs_turn_as_they_say(text, turn, centre):
    (arc,) = moves("F100 " + text)
    assert isinstance(arc, ArcFeed)
    assert arc.turn == pytest.approx(turn)
    close(arc.centre / MM, centre)
    close(arc.at(np.array([0.0, 1.0])), [arc.start, arc.end], 1e-15)


@pytest.mark.property
@given(
    st.floats(-5, 5), st.floats(-5, 5), st.floats(0.1, 3), st.floats(0.1, 6), st.booleans(),
    st.sampled_from([17, 18, 19]),
)  # fmt: skip
def test_an_arc_by_its_radius_is_the_one_by_its_centre(x, y, radius, angle, clockwise, plane):
    a, b, i, j = {17: "XYIJ", 18: "ZXKI", 19: "YZJK"}[plane]
    turn = -angle if clockwise else angle
    start = np.array([radius, 0.0])
    end = radius * np.array([np.cos(turn), np.sin(turn)])
    code = "G2" if clockwise else "G3"
    sign = -1 if angle > pi else 1
    ahead = f"G{plane} F1 G0 {a}{x + start[0]:.9f} {b}{y:.9f}\n"
    goal = f"{code} {a}{x + end[0]:.9f} {b}{y + end[1]:.9f} "
    by_radius = moves(f"{ahead}{goal} R{sign * radius:.9f}")[-1]
    by_centre = moves(f"{ahead}{goal} {i}{-radius:.9f} {j}0")[-1]
    assert by_centre.turn == pytest.approx(turn, abs=1e-6)
    # near a half turn the centre is as the square root of rounding
    assert by_radius.turn == pytest.approx(by_centre.turn, abs=2e-3)
    close(by_radius.centre / MM, by_centre.centre / MM, 5e-3)


def test_splines_are_those_of_their_control_points():
    cubic, next_cubic, quadratic = moves(
        "F1 G5 X4 Y0 I1 J2 P-1 Q2\nG5 X8 Y0 P-1 Q-2\nG5.1 X10 Y0 I1 J3"
    )
    close(cubic.curve.points[:, :2] / MM, [[0, 0], [1, 2], [3, 2], [4, 0]])
    close(next_cubic.curve.points[:, :2] / MM, [[4, 0], [5, -2], [7, -2], [8, 0]])
    close(quadratic.curve.points[:, :2] / MM, [[8, 0], [9, 3], [10, 0]])
    (nurbs,) = moves("F10 G5.2 P1 L3\nX0 Y1 P1\nX2 Y2 P1\nX2 Y0 P1\nX0 Y0 P2\nG5.3")
    assert nurbs.curve.degree == 2
    close(nurbs.curve.points[:, :2] / MM, [[0, 0], [0, 1], [2, 2], [2, 0], [0, 0]])
    close(nurbs.curve.weights, [1, 1, 1, 1, 2])


def test_a_drilling_cycle_goes_in_and_out_at_every_place():
    text = "G0 Z10\nG99 G81 X1 Y2 Z-3 R1 F60\nX4\nG98 X6\nG80"
    found = moves(text)
    heights = [round(float(m.end[2]) / MM, 6) for m in found]
    assert heights == [10, 10, 1, -3, 1, 1, -3, 1, 10, 10, 1, -3, 10]
    assert [isinstance(m, Feed) for m in found].count(True) == 3
    close(found[5].end[:2] / MM, [4, 2])


def test_pecks_back_off_and_dwells_rest():
    deep = ends("G83 X0 Z-2.5 R0 Q1 F60")[:, 2]
    close(deep, [-1, 0, -0.746, -2, 0, -1.746, -2.5, 0])
    chips = ends("G73 X0 Z-2.5 R0 Q1 F60")[:, 2]
    close(chips, [-1, -0.746, -2, -1.746, -2.5, 0])
    rests = [a.time for a in run_gcode_text("G82 X0 Z-1 R0 P0.5 F60") if isinstance(a, Dwell)]
    assert rests == [0.5]
    assert len(moves("G91 G81 X1 Z-1 R1 L3 F60")) == 3 * 3 + 1


def test_what_is_switched_comes_in_order():
    actions = run_gcode_text("(MSG, go)\nS60 M3 M8 T2 M6\nG4 P1.5\nM1\nM9 M5\nM30\nG0 X1")
    kinds = [type(action) for action in actions]
    assert kinds == [Message, ToolChange, Spindle, Switch, Dwell, Pause, Spindle, Switch, Pause]
    assert actions[0].text == "go"
    assert actions[2].speed == pytest.approx(2 * pi)
    assert actions[-1].code == "M30"


def test_modes_are_kept_and_brought_back():
    close(ends("M70 G20 G91\nG0 X1\nM72\nG0 X1")[:, 0], [25.4, 1])
    with pytest.raises(GcodeError, match="M70"):
        run_gcode_text("M72")


def test_how_corners_are_taken_is_known():
    found = moves("F1 G1 X1\nG61 X2\nG64 P0.1 X3\nG64 X4")
    assert [m.blend for m in found] == [inf, None, pytest.approx(0.1 * MM), inf]


def test_a_tool_beside_its_way_is_marked():
    machine = NcMachine(tools={1: NcTool(diameter=6 * MM)})
    found = moves("F1 T1 M6\nG41 D1 G1 X1\nY1\nG40 Y2\nG42.1 D4 X5", machine)
    assert [(m.side, m.radius / MM) for m in found] == [(1, 3), (1, 3), (0, 0), (-1, 2)]


def test_lines_to_leave_out_are_left_out_if_asked():
    text = "/G0 X1\nG0 X2"
    assert len(moves(text)) == 2
    assert len(moves(text, NcMachine(block_delete=True))) == 1


def test_parameters_of_the_machine_can_be_read():
    text = "G10 L2 P1 X5\nG0 X[#5221+1]\nG0 Y[#5420+#<_x>]\nG20\nG0 Z[#5420]"
    close(ends(text), [[11, 0, 0], [11, 12, 0], [11, 12, 6]])


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("G0 X1\nG47", "2: g47: there is no code G47"),
        ("G0 G1 X1", "goes not together with G0"),
        ("G0 X1 X2", "two X words"),
        ("X1", "no motion is in force"),
        ("G0 X1 A5", "axes other than"),
        ("G0 X1 K5", "means nothing"),
        ("G80 X1", "no motion is in force"),
        ("F1 G2 X1 Y1", "no centre"),
        ("F1 G2 X3 Y0 R1", "more than two radii"),
        ("F1 G2 X0 Y0 R1", "must not end where it begins"),
        ("F1 G2 X10 Y10 I1 J1", "from its centre"),
        ("F1 G2 X1 Y1 I0 J0", "no radius"),
        ("F1 G2 X1 R1 I1", "not both"),
        ("F1 G5 X1 Y1 P0 Q0", "I and J"),
        ("F1 G18 G5 X1 I1 J1 P1 Q1", "G17"),
        ("F1 G5.2 P1\nX1 Y1", "has no G5.3"),
        ("F1 G5.2 P1 L4\nX1 Y1\nG5.3", "wants 4 control points"),
        ("F1 G5.2 P0\nX1 Y1\nG5.3", "weight above 0"),
        ("F1 G5.3", "no G5.2"),
        ("F1 G5.2\nG0 X1", "between G5.2 and G5.3"),
        ("F1 G81 X1 Z-1", "R: is missing"),
        ("F1 G81 X1 Z1 R0", "below the bottom"),
        ("F1 G83 X1 Z-1 R0 Q0", "above 0"),
        ("F1 G86 X1 Z-1 R0 P0", "spindle that turns"),
        ("G53 G2 X1 I1 F1", "G0 and G1 only"),
        ("G91 G53 G0 X1", "G90"),
        ("G92", "wants the coordinates"),
        ("G10 L3 P1", "G10 has"),
        ("G10 L2 P12 X1", "from 1 to 9"),
        ("G4", "wants P"),
        ("G38.2 Z1", "probing"),
        ("M98 P1", "O word"),
        ("T1.5", "whole number"),
        ("F-1", "at least 0"),
        ("G0 X[1/0]", "division by zero"),
        ("G0 X#<none>", "never set"),
        ("#5420=1", "only be read"),
        ("F1 G41.1 D2 G1 X1\nG55", "beside its way"),
    ],
)
def test_what_cannot_be_done_names_line_and_word(text, reason):
    with pytest.raises(GcodeError, match=reason) as caught:
        run_gcode_text(text)
    assert "\n" not in str(caught.value)
    assert caught.value.line >= 1


def test_a_program_is_read_from_its_file_with_its_neighbours(tmp_path):
    (tmp_path / "step.ngc").write_text("o<step> sub\nG91 G0 X#1\no<step> endsub\n")
    (tmp_path / "part.ngc").write_text("%\no<step> call [5]\nM2\n%\n")
    (move,) = (a for a in run_gcode(tmp_path / "part.ngc") if isinstance(a, Rapid))
    close(move.end / MM, [5, 0, 0])
    with pytest.raises(GcodeError, match=r"none\.ngc"):
        run_gcode(tmp_path / "none.ngc")
