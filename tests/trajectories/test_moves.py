"""Arcs, helices, blends between all of them, and how the tool stands on the way."""

import numpy as np
import pytest

from splinearm.errors import CurveError
from splinearm.kinematics import quaternion
from splinearm.trajectories.plan import plan
from splinearm.trajectories.waypoint import ArcAbout, ArcThrough, Facing, Move, Waypoint


@pytest.fixture(scope="module")
def here(arm_6, q_6):
    """The tool's position at the start."""
    return arm_6.fk(q_6)[:3, 3]


def off(p, x, y, z):
    return p + np.array([x, y, z])


def tool_of(arm, made, count=400):
    q, _, _ = made.trajectory.sample(np.linspace(0.0, made.trajectory.duration, count))
    return arm.fk(q)


def arc_to(p, arc, **asks):
    return Waypoint(position=p, move=Move.ARC, arc=arc, **asks)


def test_a_full_circle_keeps_its_radius_and_the_limits(arm_6, q_6, here, worst_use):
    centre = off(here, 0.0, 0.04, 0.0)
    circle = arc_to(here, ArcAbout(centre, [0, 0, 1]), facing=Facing.KEPT, speed=0.1)
    made = plan(arm_6, [circle], q_6)
    p = tool_of(arm_6, made)[:, :3, 3]
    assert np.abs(np.linalg.norm(p - centre, axis=1) - 0.04).max() <= 2e-5
    assert np.abs(p[:, 2] - here[2]).max() <= 2e-5
    assert made.tool_path.length == pytest.approx(0.08 * np.pi, rel=1e-4)
    assert worst_use(made.trajectory, 2000) <= 1.0 + 1e-6


def test_kept_means_that_the_tool_does_not_turn(arm_6, q_6, here):
    end = off(here, 0.03, 0.03, 0.02)
    made = plan(
        arm_6,
        [
            Waypoint(position=off(here, 0.03, 0, 0), move=Move.LINE, facing=Facing.KEPT),
            arc_to(end, ArcThrough(off(here, 0.04, 0.015, 0.01)), facing=Facing.KEPT),
        ],
        q_6,
    )
    T = tool_of(arm_6, made)
    turned = quaternion.angle_between(
        quaternion.from_matrix(T[:, :3, :3]), quaternion.from_matrix(arm_6.fk(q_6)[:3, :3])
    )
    assert turned.max() <= 2e-4
    assert np.allclose(T[-1, :3, 3], end, atol=2e-5)


def test_tangent_means_that_the_tool_turns_with_the_circle(arm_6, q_6, here):
    quarter = arc_to(
        off(here, 0.04, 0.04, 0.0),
        ArcAbout(off(here, 0, 0.04, 0), [0, 0, 1]),
        facing=Facing.TANGENT,
    )
    T = tool_of(arm_6, plan(arm_6, [quarter], q_6))
    start, end = (quaternion.from_matrix(T[i, :3, :3]) for i in (0, -1))
    turn = quaternion.log(quaternion.multiply(end, quaternion.conjugate(start)))
    assert np.allclose(turn, [0, 0, 0.5 * np.pi], atol=3e-4)


def test_a_helix_rises_evenly(arm_6, q_6, here):
    rise = arc_to(
        off(here, 0, 0, 0.03),
        ArcAbout(off(here, 0, 0.02, 0), [0, 0, 1], turns=1),
        facing=Facing.KEPT,
    )
    made = plan(arm_6, [rise], q_6)
    p = tool_of(arm_6, made)[:, :3, 3]
    turns = np.unwrap(np.arctan2(p[:, 1] - here[1] - 0.02, p[:, 0] - here[0]))
    assert turns[-1] - turns[0] == pytest.approx(4.0 * np.pi, abs=2e-3)
    assert np.allclose(p[:, 2] - here[2], 0.03 * (turns - turns[0]) / (4.0 * np.pi), atol=5e-5)


def test_a_blend_joins_a_line_and_an_arc_without_a_stop(arm_6, q_6, here):
    corner = off(here, 0.05, 0, 0)

    def moves(blend):
        return [
            Waypoint(position=corner, move=Move.LINE, facing=Facing.KEPT, blend=blend),
            arc_to(
                off(here, 0.05, 0.06, 0.0),
                ArcAbout(off(here, 0.05, 0.03, 0), [0, 0, 1]),
                facing=Facing.KEPT,
            ),
        ]

    stopped, blended = (plan(arm_6, moves(blend), q_6) for blend in (0.0, 0.01))
    assert len(stopped.trajectory.sections) == 2
    assert len(blended.trajectory.sections) == 1
    assert blended.trajectory.duration < stopped.trajectory.duration
    ts = np.linspace(0.0, blended.trajectory.duration, 4000)
    _, qd, _ = blended.trajectory.sample(ts[50:-50])
    assert np.abs(qd).max(axis=1).min() > 0.05
    p = tool_of(arm_6, blended)[:, :3, 3]
    assert np.linalg.norm(p - corner, axis=1).min() <= 0.01
    # away from the corner it is the line and the arc themselves
    far = np.linalg.norm(p - corner, axis=1) > 0.0101
    line = far & (p[:, 0] < corner[0]) & (np.arange(len(p)) < 200)
    assert np.abs(p[line, 1] - here[1]).max() <= 2e-5


def test_what_is_no_move_is_refused(arm_6, q_6, here):
    with pytest.raises(CurveError, match="waypoint 1: no arc leads there: three points in line"):
        plan(
            arm_6,
            [arc_to(off(here, 0.1, 0, 0), ArcThrough(off(here, 0.05, 0, 0)), facing=Facing.KEPT)],
            q_6,
        )
    tiny = ArcAbout(off(here, 0.05, 0.0005, 0), [0, 0, 1], turns=20)
    corner = Waypoint(
        position=off(here, 0.05, 0, 0), move=Move.LINE, facing=Facing.KEPT, blend=0.012
    )
    with pytest.raises(CurveError, match=r"waypoint 1: .* too large for how much the way bends"):
        plan(arm_6, [corner, arc_to(off(here, 0.05, 0, 0), tiny, facing=Facing.KEPT)], q_6)
    with pytest.raises(ValueError, match="arc: want one for"):
        Waypoint(position=here, move=Move.ARC)
    with pytest.raises(ValueError, match="arc: want one for"):
        Waypoint(position=here, move=Move.LINE, arc=ArcThrough(here))
    with pytest.raises(ValueError, match=r"facing: .* is for tool moves to a position"):
        Waypoint(q=q_6, facing=Facing.KEPT)
    with pytest.raises(ValueError, match="turns: want 0 or more"):
        ArcAbout(here, [0, 0, 1], turns=-1)
    with pytest.raises(ValueError, match="normal: want a direction"):
        ArcAbout(here, [0, 0, 0])


def test_a_planar_arm_draws_a_circle(arm_2r):
    q = np.array([0.3, 0.9])
    p = arm_2r.fk(q)[:3, 3]
    circle = arc_to(p, ArcAbout(p - [0.05, 0.02, 0], [0, 0, 1]), speed=0.2)
    made = plan(arm_2r, [circle], q)
    drawn = tool_of(arm_2r, made)[:, :3, 3]
    radius = np.hypot(0.05, 0.02)
    assert np.abs(np.linalg.norm(drawn - p + [0.05, 0.02, 0], axis=1) - radius).max() <= 2e-5
