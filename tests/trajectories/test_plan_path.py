"""Given ways of the tool as plans."""

import numpy as np
import pytest

from splinearm.curves.bspline import BSpline
from splinearm.curves.surface import BSplineSurface
from splinearm.curves.surface_curve import SurfaceCurve
from splinearm.curves.surface_normal import normal
from splinearm.errors import LimitError, UnreachableError
from splinearm.kinematics import quaternion
from splinearm.trajectories.path import ToolPlaces, spline_path
from splinearm.trajectories.plan import plan
from splinearm.trajectories.plan_path import plan_path
from splinearm.trajectories.surface_path import Heading, surface_path
from splinearm.trajectories.waypoint import Waypoint

TOLERANCE = 2e-5


@pytest.fixture(scope="module")
def shell():
    """A curved patch before the arm, some 0.3 m from its base."""
    x, y = np.meshgrid(np.linspace(0.26, 0.38, 4), np.linspace(-0.08, 0.08, 4), indexing="ij")
    z = 0.06 + 0.03 * np.cos(8.0 * (x - 0.32)) * np.cos(9.0 * y)
    knots = np.repeat([0.0, 1.0], 4)
    return BSplineSurface(knots, knots, np.stack((x, y, z), axis=-1), 3, 3)


def across(shell):
    points = np.array([[0.2, 0.1], [0.4, 0.3], [0.3, 0.7], [0.8, 0.9]])
    return SurfaceCurve(shell, BSpline(np.repeat([0.0, 1.0], 4), points, 3))


def along(arm, made, path, count=2000):
    """The tool while it follows the way, and its distances from it."""
    t = np.linspace(*made.waypoint_times[[0, -1]], count)
    T = arm.fk(made.trajectory.sample(t)[0])
    return T, path.distance(T[:, :3, 3])


@pytest.mark.parametrize("heading", Heading)
def test_an_arm_goes_over_a_surface_and_faces_it(arm_6, q_6, shell, heading, worst_use):
    curve = across(shell)
    path = surface_path(curve, heading=heading)
    made = plan_path(arm_6, path, q_6)
    T, off = along(arm_6, made, path)
    assert off.max() <= TOLERANCE
    # the tool's axis at each place against the normal at the nearest place of the surface
    u, _ = _nearest(shell, T[::50, :3, 3])
    facing = np.sum(T[::50, :3, 2] * normal(shell, *u.T), axis=1)
    assert facing.max() <= -np.cos(3.0 * TOLERANCE / 0.1)
    assert worst_use(made.trajectory, 5001) <= 1.0 + 1e-9
    assert np.array_equal(made.trajectory.q_start, q_6)


def _nearest(shell, points):
    """Places of the patch nearest to points, by Newton's method from a grid."""
    g = np.linspace(0.0, 1.0, 60)
    grid = np.stack(np.meshgrid(g, g, indexing="ij"), axis=-1).reshape(-1, 2)
    on = shell.at(*grid.T)
    uv = grid[np.argmin(np.linalg.norm(points[:, None] - on, axis=2), axis=1)]
    for _ in range(20):
        jets = shell.jet(*uv.T, 1)
        J = np.stack((jets[:, 1, 0], jets[:, 0, 1]), axis=-1)
        step = np.linalg.pinv(J) @ (points - jets[:, 0, 0])[..., None]
        uv = np.clip(uv + step[..., 0], 0.0, 1.0)
    return uv, shell.at(*uv.T)


def test_the_joints_never_jump_between_approach_and_way(arm_6, q_6, shell):
    made = plan_path(arm_6, surface_path(across(shell)), q_6)
    approach, way = made.trajectory.sections
    assert np.allclose(approach.path.at(1e9)[0], way.path.at(0.0)[0], atol=1e-12)
    at_start = made.trajectory.at(made.waypoint_times[0])
    assert np.abs(at_start.qd).max() < 1e-9
    assert made.waypoint_times[0] == pytest.approx(approach.duration)
    assert made.waypoint_times[-1] == pytest.approx(made.trajectory.duration)


def test_a_way_that_waypoints_make_is_planned_as_they_are(arm_6, q_6):
    T = arm_6.fk(q_6)
    p = T[:3, 3] + np.array([[0.0, 0.0, 0.0], [0.02, 0.04, 0.0], [0.0, 0.08, 0.03]])
    path = spline_path(ToolPlaces(p, None))
    made = plan_path(arm_6, path, q_6)
    same = plan(arm_6, [Waypoint(position=x) for x in p[1:]], q_6)
    assert made.trajectory.duration == pytest.approx(same.trajectory.duration, rel=1e-9)
    assert np.allclose(made.waypoint_times[1:], same.waypoint_times, rtol=1e-9)
    assert len(made.trajectory.sections) == 1


def test_the_speed_of_the_tool_is_kept(arm_6, q_6, shell):
    path = surface_path(across(shell))
    made = plan_path(arm_6, path, q_6, speed=0.05)
    t = np.linspace(*made.waypoint_times, 2000)
    q, qd, _ = made.trajectory.sample(t)
    J = arm_6.jacobian(q)[:, :3]
    speed = np.linalg.norm(np.einsum("mij,mj->mi", J, qd), axis=1)
    assert speed.max() <= 0.05 * (1.0 + 1e-6)
    assert np.median(speed) == pytest.approx(0.05, rel=1e-3)


def test_an_arm_at_the_start_in_a_configuration_that_ends_is_told_of_another(arm_6):
    q_there = np.array([-0.1, -0.8, 0.4, -1.5, -0.1, 0.1])
    T = arm_6.fk(q_there)
    quat = quaternion.from_matrix(T[:3, :3])
    p = T[:3, 3] + np.linspace(0.0, 1.0, 3)[:, None] * [-0.03, 0.03, 0.1]
    path = spline_path(ToolPlaces(p, np.tile(quat, (3, 1))))
    made = plan_path(arm_6, path, np.array([-0.7, -0.4, 0.5, 0.1, -0.6, -0.1]))
    begun = made.trajectory.at(made.waypoint_times[0]).q
    T_begun = arm_6.fk(begun)
    assert np.allclose(T_begun, T, atol=1e-9)
    assert along(arm_6, made, path)[1].max() <= TOLERANCE
    assert np.abs(begun - q_there).max() > 0.1
    stuck = _stuck(arm_6, path, begun)
    with pytest.raises(UnreachableError, match="starts in another configuration: waist"):
        plan_path(arm_6, path, stuck)


def _stuck(arm, path, begun):
    """Give joint positions at the start of a way from which it cannot be followed."""
    from splinearm.kinematics import branches
    from splinearm.kinematics.pose import Pose

    for q in branches(arm, Pose(*path.at(0.0))).q:
        if np.abs(q - begun).max() < 0.1 or not (np.abs(q) <= arm.limits.q_max + 1e-9).all():
            continue
        try:
            plan_path(arm, path, q)
        except UnreachableError:
            return q
    raise AssertionError("every configuration follows")


def test_a_way_out_of_reach_is_named(arm_6, q_6, shell):
    beyond = shell.points + np.array([2.0, 0.0, 0.0])
    far = BSplineSurface(shell.knots_u, shell.knots_v, beyond, 3, 3)
    with pytest.raises(UnreachableError, match="the start of the path is out of reach by"):
        plan_path(arm_6, surface_path(across(far)), q_6)


def test_wrong_arguments_are_shown(arm_6, q_6, shell):
    path = surface_path(across(shell))
    with pytest.raises(ValueError, match="position_tolerance: want a length above 0, got 0"):
        plan_path(arm_6, path, q_6, position_tolerance=0.0)
    with pytest.raises(ValueError, match="speed: want a number above 0 m/s, got -1"):
        plan_path(arm_6, path, q_6, speed=-1.0)
    with pytest.raises(ValueError, match="q_start"):
        plan_path(arm_6, path, q_6[:5])
    with pytest.raises(LimitError):
        plan_path(arm_6, path, q_6 + 10.0)
