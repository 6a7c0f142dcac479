from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.segment import Line
from splinearm.errors import UnreachableError
from splinearm.kinematics import quaternion
from splinearm.trajectories import task
from splinearm.trajectories.path import ToolPlaces, course_path, spline_path
from splinearm.trajectories.reach import PathLabels
from splinearm.trajectories.resolve import Tolerance, resolve

TOLERANCE = Tolerance(position=2e-5)
LABELS = PathLabels([f"place {i}" for i in range(20)])


def line(*p):
    places = ToolPlaces(np.array(p), None)
    ways = [Line(*ends) for ends in pairwise(places.p)]
    return course_path(places, ways, np.zeros(len(p)), LABELS.names)


def off_by(arm, path, joints, count=4000):
    """Largest misses of position and orientation at many places between the nodes."""
    s = np.linspace(*path.domain, count)
    position, orientation = task.errors(task.misses(arm, joints.sample(s)[0], path.state(s)))
    return position.max(), orientation.max()


def wavy(arm, q_start, *, turn):
    T = arm.fk(q_start)
    a = np.linspace(0.0, 2.0 * np.pi, 13)[:-1]
    p = T[:3, 3] + np.stack(
        (0.03 * np.sin(2 * a), 0.08 * (np.cos(a) - 1), 0.06 * np.sin(a)), axis=1
    )
    if not turn:
        return ToolPlaces(p, None)
    v = np.stack((0.3 * np.sin(a), 0.2 * np.sin(2 * a), 0.3 * (np.cos(a) - 1)), axis=1)
    start = quaternion.from_matrix(T[:3, :3])
    return ToolPlaces(p, quaternion.multiply(start, quaternion.exp(v)))


@pytest.mark.parametrize("turn", [True, False])
def test_a_six_joint_arm_stays_on_the_path_between_the_nodes(arm_6, q_6, turn):
    path = spline_path(wavy(arm_6, q_6, turn=turn), closed=True)
    joints = resolve(arm_6, path, q_6, TOLERANCE, LABELS)
    position, orientation = off_by(arm_6, path, joints)
    assert position < TOLERANCE.position
    assert orientation < TOLERANCE.orientation
    assert np.allclose(joints.at(0.0)[0], q_6, atol=1e-9)
    if turn:
        assert np.allclose(joints.at(path.domain[1])[0], q_6, atol=1e-6), "the same branch"


def test_a_planar_arm_stays_on_the_path_between_the_nodes(arm_2r, heart):
    path = spline_path(ToolPlaces(heart, None), closed=True)
    q = np.array([-0.6, 1.7])
    q = task.correct(arm_2r, q[None], path.state(np.zeros(1))).q[0]
    joints = resolve(arm_2r, path, q, TOLERANCE, LABELS)
    assert off_by(arm_2r, path, joints)[0] < TOLERANCE.position
    assert joints.curve.degree == 5


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-8])
def test_the_tolerance_decides_how_many_nodes_there_are(arm_6, q_6, tolerance):
    path = spline_path(wavy(arm_6, q_6, turn=True), closed=True)
    joints = resolve(arm_6, path, q_6, Tolerance(position=tolerance), LABELS)
    assert off_by(arm_6, path, joints)[0] < tolerance
    assert len(joints.breaks) < 500


@pytest.mark.parametrize("turn", [True, False])
def test_the_joints_move_smoothly(arm_6, q_6, turn):
    path = spline_path(wavy(arm_6, q_6, turn=turn), closed=True)
    joints = resolve(arm_6, path, q_6, TOLERANCE, LABELS)
    inner = joints.breaks[1:-1]
    for order in (0, 1, 2):
        before, behind = (joints.curve.at(inner + d, order) for d in (-1e-10, 1e-10))
        scale = 1.0 + np.abs(behind).max()
        assert np.allclose(before, behind, atol=1e-5 * scale)


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 999), rows=st.sampled_from([3, 6]))
def test_slopes_and_bends_are_those_of_the_way_of_the_joints(arm_6, q_6, seed, rows):
    # along any way q(s) of the joints that moves as little as it must, slopes come back
    rng = np.random.default_rng(seed)
    places = wavy(arm_6, q_6 + 0.1 * rng.normal(size=6), turn=rows == 6)
    path = spline_path(places)
    q = q_6[None]
    step = 1e-4
    q = task.correct(arm_6, q + 0.0, path.state(np.zeros(1))).q
    ways = [q]
    for i in range(40):  # a fine Runge-Kutta walk
        s = i * step / 10
        k1 = task.slopes(arm_6, ways[-1], path.state(np.array([s])))
        k2 = task.slopes(
            arm_6, ways[-1] + 0.5 * step / 10 * k1, path.state(np.array([s + step / 20]))
        )
        ways.append(ways[-1] + step / 10 * k2)
    at = path.state(np.array([2.0 * step]))
    slope, bend = task.slopes_and_bends(arm_6, ways[20], at)
    scale = max(1.0, np.abs(bend).max())
    assert np.allclose((ways[30] - ways[10]) / (2 * step), slope, atol=1e-4 * scale)
    assert np.allclose((ways[30] - 2 * ways[20] + ways[10]) / step**2, bend, atol=0.01 * scale)


def test_a_place_beyond_reach_is_named_with_its_miss(arm_2r):
    q = np.array([0.0, 1.0])
    p = arm_2r.fk(q)[:3, 3]
    with pytest.raises(UnreachableError, match="place 1 is out of reach by 50 mm") as caught:
        resolve(arm_2r, line(p, [0.6, 0.0, 0.06]), q, TOLERANCE, LABELS)
    assert caught.value.position_error == pytest.approx(0.05, abs=1e-6)


def test_a_way_out_of_the_plane_is_refused(arm_2r):
    q = np.array([0.0, 1.0])
    p = arm_2r.fk(q)[:3, 3]
    with pytest.raises(UnreachableError, match="place 1 is out of reach by 10 mm"):
        resolve(arm_2r, line(p, p + np.array([0.0, 0.05, 0.01])), q, TOLERANCE, LABELS)


def test_a_way_through_the_hole_in_the_middle_is_refused_where_it_is(arm_2r):
    q = np.array([0.2, 2.4])
    p = arm_2r.fk(q)[:3, 3]
    mirrored = p * [-1.0, -1.0, 1.0]
    with pytest.raises(UnreachableError, match=r"the way from place 0 to place 1, .* mm along it"):
        resolve(arm_2r, line(p, mirrored), q, TOLERANCE, LABELS)


def test_a_joint_limit_on_the_way_is_named(arm_2r):
    q = np.array([2.5, 0.8])
    p = arm_2r.fk(q)[:3, 3]
    target = arm_2r.fk(np.array([2.9, 0.8]))[:3, 3]
    with pytest.raises(
        UnreachableError, match=r"joint 'shoulder' would have to pass its limit by"
    ) as caught:
        resolve(arm_2r, line(p, target), q, TOLERANCE, LABELS)
    assert caught.value.joint == "shoulder"
    assert caught.value.position_error > 0.05
    assert "place 1" in caught.value.what


@pytest.mark.parametrize("room", [-1e-6, 1e-6])
def test_a_limit_is_held_between_the_nodes_too(arm_2r, room):
    q = np.array([0.4, 1.2])
    p = arm_2r.fk(q)[:3, 3]
    path = line(p, p + np.array([-0.06, -0.08, 0.0]))
    free = resolve(arm_2r, path, q, TOLERANCE, LABELS)
    reached = free.sample(np.linspace(*path.domain, 100_001))[0]
    # one joint turns back on the way: its limit is put just beyond or just below that
    j = int(np.argmax(reached.max(axis=0) - np.maximum(reached[0], reached[-1])))
    q_max = arm_2r.limits.q_max.copy()
    q_max[j] = reached[:, j].max() + room
    arm = replace(arm_2r, limits=replace(arm_2r.limits, q_max=q_max))
    if room > 0.0:
        assert resolve(arm, path, q, TOLERANCE, LABELS).domain == path.domain
    else:
        with pytest.raises(UnreachableError, match=arm.joint_names[j]):
            resolve(arm, path, q, TOLERANCE, LABELS)


def test_another_branch_is_never_jumped_to(arm_2r):
    # stretched out, the elbow is between its two branches: the way back to the middle begins there
    q = np.array([0.3, 0.0])
    p = arm_2r.fk(q)[:3, 3]
    with pytest.raises(UnreachableError, match="the arm would have to jump there"):
        resolve(arm_2r, line(p, p * [0.7, 0.7, 1.0]), q, TOLERANCE, LABELS)


def test_an_arm_that_is_not_at_the_start_is_refused(arm_2r):
    p = arm_2r.fk(np.array([0.0, 1.0]))[:3, 3]
    with pytest.raises(UnreachableError):
        resolve(
            arm_2r,
            line(p, p + np.array([0.05, 0.0, 0.0])),
            np.array([0.0, -1.0]),
            TOLERANCE,
            LABELS,
        )
