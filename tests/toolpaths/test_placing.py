"""A toolpath before an arm, as a motion of its joints."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from splinearm import load_cell
from splinearm.errors import UnreachableError
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics import Arm, DHConvention, DHLink
from splinearm.toolpaths.action import ArcFeed, Feed, Rapid
from splinearm.toolpaths.feed_report import report_feeds
from splinearm.toolpaths.gcode_interpreter import run_gcode, run_gcode_text
from splinearm.toolpaths.placing import place
from splinearm.toolpaths.program import plan_program
from splinearm.toolpaths.setting import Setting
from splinearm.trajectories.limit import MotionLimits

CELL = load_cell("wx250s")
ARM, HOME = CELL.arm, CELL.poses["home"]
ENGRAVE = Path(__file__).parents[2] / "examples" / "engrave.ngc"

PART = """G21 G90 G64 P0.05
T1 M6
M3 S1000
G0 Z5
G0 X10 Y0
G1 Z-1 F300
G1 X40 F1200
G1 Y20
G3 X20 Y40 I-20 J0
G1 X0
G61
G1 Y10
G4 P0.5
G1 X10 Y0
G0 Z5
M5
M2
"""


def at(x, y, z):
    T = np.eye(4)
    T[:3, 3] = np.array([x, y, z]) * 1e-3
    return T


def sampled(plan, step=1e-3):
    t = np.arange(0.0, plan.trajectory.duration, step)
    return t, *plan.trajectory.sample(t)


@pytest.fixture(scope="module")
def part():
    """The part on the six-joint arm, planned."""
    placed = place(run_gcode_text(PART), at(200, -20, 80), ARM, HOME)
    return placed, plan_program(placed)


def test_the_tool_follows_the_program_and_points_down(part):
    placed, (one,) = part
    _, q, _, _ = sampled(one.plan)
    T = ARM.fk(q)
    assert one.plan.tool_path.distance(T[::5, :3, 3]).max() < 2e-5
    assert np.abs(T[:, :3, 0] - [0.0, 0.0, -1.0]).max() < 2e-4
    corners = np.array([(10, 0, -1), (40, 0, -1), (40, 20, -1), (0, 40, -1), (0, 10, -1)]) * 1e-3
    work = corners + placed.setting.T_base_work[:3, 3]
    near = [np.linalg.norm(T[:, :3, 3] - corner, axis=1).min() for corner in work]
    assert max(near) < 0.06e-3  # a corner is cut by 0.05 mm at the most
    assert near[-1] < 2e-5  # but not where the program says G61


def test_the_feed_is_kept_along_lines_and_arcs(part):
    placed, (one,) = part
    way = np.concatenate([stage.edges for stage in placed.itinerary.stages])
    _, q, qd, _ = sampled(one.plan)
    v = np.linalg.norm(np.einsum("tij,tj->ti", ARM.jacobian(q)[:, :3], qd), axis=1)
    p = ARM.fk(q)[:, :3, 3] - placed.setting.T_base_work[:3, 3]
    cut = np.abs(p[:, 2] + 1e-3) < 1e-6
    assert v[cut].max() < 0.02 * 1.001
    # away from corners it is even: where the first line, and where the arc is cut
    line = cut & (np.abs(p[:, 1]) < 1e-6) & (p[:, 0] > 0.015) & (p[:, 0] < 0.035)
    arc = cut & (p[:, 0] > 0.024) & (p[:, 1] > 0.024)
    for some in (line, arc):
        assert some.sum() > 200
        assert np.abs(v[some] / 0.02 - 1.0).max() < 0.01
    assert len(way) > 8


def test_how_well_feeds_are_kept_is_said(part):
    placed, parts = part
    report = report_feeds(placed, parts)
    assert report.length == pytest.approx(
        0.006 + 0.03 + 0.02 + 0.01 * np.pi + 0.02 + 0.03 + 0.0141, abs=2e-4
    )
    assert 0.9 < report.kept < 1.0
    assert report.highest < 1.001
    assert report.slow == ()
    assert report.words.startswith("feed: as programmed over 9")


def test_ways_too_short_for_their_feed_are_named():
    ways = run_gcode_text("G61\nG1 F6000 X10\nY0.2\nX0\nM2")
    placed = place(ways, at(230, 0, 60), ARM, HOME)
    report = report_feeds(placed, plan_program(placed))
    assert "line 3" in [name for name, _ in report.slow]
    assert "too short" in report.words


def test_joints_keep_velocity_acceleration_and_jerk(part):
    _, (one,) = part
    limits = one.plan.limits.joints
    assert limits.qddd_max is not None
    t, q, qd, qdd = sampled(one.plan)
    assert (np.abs(qd) <= limits.qd_max * (1.0 + 1e-6)).all()
    assert (np.abs(qdd) <= limits.qdd_max * (1.0 + 1e-6)).all()
    jerk = np.abs(np.diff(qdd, axis=0)) / np.diff(t)[:, None]
    assert (jerk <= limits.qddd_max * 1.01).all()
    assert (q >= limits.q_min).all()
    assert (q <= limits.q_max).all()


def test_what_is_switched_and_the_rest_have_their_times(part):
    _, (one,) = part
    words = [event.words for event in one.events]
    assert words == [
        "line 2: tool 1",
        "line 3: spindle clockwise at 1000 rpm",
        "line 16: spindle off",
        "line 17: M2",
    ]
    assert one.events[0].t == 0.0
    assert one.events[-1].t == pytest.approx(one.plan.trajectory.duration)
    _, _, qd, _ = sampled(one.plan)
    still = (np.abs(qd) < 1e-12).all(axis=1)
    assert 0.5 <= still.sum() * 1e-3 < 0.6


def test_messages_are_said_on_the_way_without_a_rest():
    program = "G64 P0.1 G1 F600 X10\n(MSG, halfway)\nY10\nM2"
    placed = place(run_gcode_text(program), at(230, 0, 60), ARM, HOME)
    (one,) = plan_program(placed)
    assert len(placed.ways) == 2  # down to the start, and along
    (said,) = [event for event in one.events if event.words == "halfway"]
    corner = placed.setting.T_base_work[:3, 3] + [0.01, 0.0, 0.0]
    there = ARM.fk(one.plan.trajectory.at(said.t).q)[:3, 3]
    assert np.linalg.norm(there - corner) < 0.2e-3


def test_a_rapid_way_takes_no_longer_than_limits_make_it(part):
    placed, (one,) = part
    joints = one.plan.limits.joints
    rapid = next(
        section
        for section, stage in zip(
            (s for s in one.plan.trajectory.sections if s.dwell == 0.0 or s.law.duration > 0.0),
            placed.itinerary.stages,
            strict=False,
        )
        if isinstance(stage.moves[0], Rapid)
    )
    t = np.linspace(0.0, rapid.law.duration, 500)
    _, qd, qdd = rapid.sample(t)
    used = max(
        np.abs(qd / joints.qd_max).max(),
        np.abs(qdd / joints.qdd_max).max(),
        np.abs(rapid.jerk(t[1:-1]) / joints.qddd_max).max(),
    )
    assert used > 0.98


def test_a_kept_turn_is_kept():
    setting = Setting(T_base_work=at(230, 0, 60), turn=0.4)
    placed = place(run_gcode_text("G1 F600 X10\nY10\nM2"), setting, ARM, HOME)
    (one,) = plan_program(placed)
    _, q, _, _ = sampled(one.plan, 0.05)
    R = ARM.fk(q)[:, :3, :3]
    assert np.abs(R - R[0]).max() < 2e-4


def test_a_free_turn_changes_smoothly_where_it_must():
    # half around the arm, farther than the last joint turns with the tool held
    ways = ArcFeed(
        start=np.array([0.2, 0.0, 0.0]),
        end=0.2 * np.array([np.cos(0.9 * np.pi), -np.sin(0.9 * np.pi), 0.0]),
        centre=np.zeros(3), axis=2, turn=-0.9 * np.pi, feed=0.1, blend=1e-4,
    )  # fmt: skip
    placed = place([ways], at(0, 0, 80), ARM, HOME)
    (one,) = plan_program(placed)
    _, q, _, _ = sampled(one.plan, 0.01)
    T = ARM.fk(q)
    assert np.abs(T[:, :3, 0] - [0.0, 0.0, -1.0]).max() < 2e-4
    assert np.ptp(q[:, 0]) > 0.85 * np.pi
    assert (np.abs(np.diff(q, axis=0)) < 0.1).all()


def test_tilted_work_is_met_at_right_angles():
    T = at(230, 0, 120)
    T[:3, :3] = [[np.cos(0.4), 0, np.sin(0.4)], [0, 1, 0], [-np.sin(0.4), 0, np.cos(0.4)]]
    placed = place(run_gcode_text("G1 F600 X20\nY20\nM2"), T, ARM, HOME)
    (one,) = plan_program(placed)
    _, q, _, _ = sampled(one.plan, 0.05)
    assert np.abs(ARM.fk(q)[:, :3, 0] + T[:3, 2]).max() < 2e-4


@pytest.mark.parametrize(
    ("name", "where"),
    [
        ("rx150", (150, -20, 60)),
        ("open_manipulator_x", (150, -20, 60)),
        ("planar_2r", (200, 60, 0)),
    ],
)
def test_arms_of_fewer_joints_cut_and_draw(name, where):
    cell = load_cell(name)
    home = cell.poses["home"]
    placed = place(run_gcode_text(PART), at(*where), cell.arm, home)
    (one,) = plan_program(placed)
    _, q, _, _ = sampled(one.plan, 0.01)
    T = cell.arm.fk(q)
    assert one.plan.tool_path.distance(T[:, :3, 3]).max() < 2e-5
    if name == "planar_2r":
        assert "no height" in placed.itinerary.notes[0]
    else:
        assert np.abs(T[:, :3, 0] - [0.0, 0.0, -1.0]).max() < 3e-4


def test_parts_end_where_a_person_is_needed():
    program = "G1 F600 X10\nM0\nX20\nT2 M6\nX30\nM30"
    first, second, third = plan_program(place(run_gcode_text(program), at(220, 0, 60), ARM, HOME))
    assert first.asks == ()
    assert second.asks[0].code == "M0"
    assert third.asks[0].tool == 2
    for one, other in ((first, second), (second, third)):
        gap = one.plan.trajectory.q_goal - other.plan.trajectory.q_start
        assert np.abs(gap).max() < 1e-9


def test_what_cannot_be_reached_names_line_distance_and_remedy():
    program = "G0 Z5\nG1 F600 X10\nX400\nM2"
    with pytest.raises(UnreachableError) as caught:
        place(run_gcode_text(program), at(220, 0, 60), ARM, HOME)
    message = str(caught.value)
    assert "line 3" in message
    assert caught.value.position_error > 0.0 or caught.value.orientation_error > 0.0
    with pytest.raises(UnreachableError, match=r"move the work by [-+]\d+ mm along x"):
        place(run_gcode_text("G1 F600 X60\nM2"), at(500, 0, 60), ARM, HOME)


def test_the_remedy_helps():
    actions = run_gcode_text("G1 F600 X60\nM2")
    with pytest.raises(UnreachableError) as caught:
        place(actions, at(500, 0, 60), ARM, HOME)
    words = str(caught.value).split("move the work by ")[1].replace("mm along", "").split()
    dx, dy = float(words[0]), float(words[2])
    placed = place(actions, at(500 + dx, dy, 60), ARM, HOME)
    assert len(placed.ways) >= 1


def test_a_flip_is_refused_and_said_to_be_one():
    setting = Setting(T_base_work=at(0, 0, 80), turn=0.0)
    ways = ArcFeed(
        start=np.array([0.2, 0.0, 0.0]), end=np.array([0.2, 0.0, 0.0]), centre=np.zeros(3),
        axis=2, turn=2.0 * np.pi, feed=0.1, blend=1e-4,
    )  # fmt: skip
    with pytest.raises(UnreachableError, match="flip"):
        place([ways], setting, ARM, HOME)


@pytest.mark.parametrize(
    ("words", "match"),
    [
        ({"turns": 0}, "turns"),
        ({"clearance": -1.0}, "clearance"),
        ({"direction": (0.0, 0.0, 0.0)}, "direction"),
        ({"turn": np.nan}, "turn"),
    ],
)
def test_wrong_settings_are_refused(words, match):
    with pytest.raises(ValueError, match=match):
        Setting(T_base_work=np.eye(4), **words)


def test_the_example_is_planned_within_the_limits_of_its_jerk():
    placed = place(run_gcode(ENGRAVE), at(220, -20, 60), ARM, HOME)
    limits = MotionLimits(joints=ARM.limits.with_jerk_time(0.1), arm=ARM)
    (one,) = plan_program(placed, limits)
    t, q, _, qdd = sampled(one.plan)
    jerk = np.abs(np.diff(qdd, axis=0)) / np.diff(t)[:, None]
    assert (jerk <= limits.joints.qddd_max * 1.01).all()
    assert one.plan.tool_path.distance(ARM.fk(q[::20])[:, :3, 3]).max() < 2e-5


def test_a_long_program_of_short_lines_is_planned():
    t = np.linspace(0.0, 2.0 * np.pi, 2001)
    r = 0.03 + 0.008 * np.cos(10.0 * t)
    p = np.stack((r * np.cos(t), r * np.sin(t), np.zeros_like(t)), axis=1)
    ways = [
        Feed(line=i, start=a, end=b, feed=0.02, blend=2e-5) for i, (a, b) in enumerate(pairwise(p))
    ]
    (one,) = plan_program(place(ways, at(250, 0, 80), ARM, HOME))
    _, q, qd, _ = sampled(one.plan)
    v = np.linalg.norm(np.einsum("tij,tj->ti", ARM.jacobian(q)[:, :3], qd), axis=1)
    assert v.max() < 0.02 * 1.01 or one.plan.trajectory.duration > 10.0
    assert one.plan.tool_path.distance(ARM.fk(q[::50])[:, :3, 3]).max() < 2e-5


def made(rows, reach):
    """Give an arm of standard rows (alpha in quarter turns, d, a)."""
    n = len(rows)
    limits = JointLimits(
        names=tuple(f"a{i}" for i in range(1, n + 1)),
        kinds=(JointKind.REVOLUTE,) * n,
        q_min=np.full(n, -reach), q_max=np.full(n, reach),
        qd_max=np.full(n, 2.0), qdd_max=np.full(n, 8.0),
    )  # fmt: skip
    links = [
        DHLink(f"a{i}", a, alpha * 0.5 * np.pi, d, 0.0) for i, (alpha, d, a) in enumerate(rows, 1)
    ]
    return Arm.from_dh("made", links, DHConvention.STANDARD, limits)


@pytest.mark.parametrize(
    ("rows", "home", "where"),
    [
        pytest.param(  # seven joints, as a KUKA iiwa has them
            [(-1, 0.34, 0), (1, 0, 0), (1, 0.4, 0), (-1, 0, 0), (-1, 0.4, 0), (1, 0, 0),
             (0, 0.1, 0)],
            [0.0, 0.4, 0.0, -1.4, 0.0, 1.3, 0.0], (500, -20, 300), id="seven",
        ),
        pytest.param(  # three parallel axes, as a UR has them
            [(1, 0.15, 0), (0, 0, -0.42), (0, 0, -0.39), (1, 0.13, 0), (-1, 0.1, 0), (0, 0.1, 0)],
            [0.0, -1.2, 1.6, -2.0, -1.5, 0.0], (-400, -150, 200), id="parallel",
        ),
        pytest.param(  # no two axes that meet or are parallel
            [(0.8, 0.2, 0.05), (0.1, 0.03, 0.3), (0.9, 0.05, 0.06), (-0.95, 0.3, 0.02),
             (1.05, 0.04, 0.03), (0, 0.1, 0)],
            [0.1, 0.5, 0.2, 0.1, 0.9, 0.0], None, id="general",
        ),
    ],
)  # fmt: skip
def test_other_arms_follow_too(rows, home, where):
    arm = made(rows, 3.0)
    home = np.array(home)
    T = at(*where) if where is not None else np.eye(4)
    direction = (0.0, 0.0, -1.0)
    if where is None:  # where it stands, as it stands
        T[:3, 3] = arm.fk(home)[:3, 3]
        direction = arm.fk(home)[:3, 2]
    setting = Setting(T_base_work=T, direction=direction, tool_axis=(0.0, 0.0, 1.0), clearance=0.0)
    placed = place(
        run_gcode_text("G64 P0.1 G1 F1200 X10\nG3 Y10 J5\nG1 X0\nM2"), setting, arm, home
    )
    (one,) = plan_program(placed)
    _, q, _, _ = sampled(one.plan, 0.01)
    T = arm.fk(q)
    assert one.plan.tool_path.distance(T[:, :3, 3]).max() < 2e-5
    assert np.abs(T[:, :3, 2] - setting.points).max() < 3e-4
