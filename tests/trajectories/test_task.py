import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.kinematics import quaternion
from splinearm.trajectories import task
from splinearm.trajectories.path import TURN_ARM, ToolState


def states(arm, q, turns=None, *, free=False):
    """Where the tool is at joint positions, turned on by rotation vectors."""
    T = arm.fk(q)
    rows = 3 if free else 6
    still = np.zeros((len(q), rows))
    if free:
        return ToolState(T[:, :3, 3], None, still, still)
    quat = quaternion.from_matrix(T[:, :3, :3])
    if turns is not None:
        quat = quaternion.multiply(quaternion.exp(turns), quat)
    return ToolState(T[:, :3, 3], quat, still, still)


@pytest.mark.property
@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 9999), size=st.sampled_from([0.0, 1e-12, 1e-5, 0.3, 1.5, 1.6, 3.1]))
def test_misses_of_orientation_are_the_turns_that_lead_there(arm_6, seed, size):
    rng = np.random.default_rng(seed)
    turns = rng.normal(size=(5, 3))
    turns *= size / np.linalg.norm(turns, axis=1, keepdims=True)
    q = rng.uniform(-1.5, 1.5, (5, 6))
    miss = task.misses(arm_6, q, states(arm_6, q, turns))
    assert np.allclose(miss[:, :3], 0.0, atol=1e-15)
    assert np.allclose(miss[:, 3:] / TURN_ARM, turns, atol=2e-15 + 1e-14 * size)


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 9999), free=st.booleans())
def test_joint_positions_near_the_way_are_moved_onto_it(arm_6, seed, free):
    rng = np.random.default_rng(seed)
    wrist = rng.uniform(0.3, 1.2, 8) * rng.choice([-1.0, 1.0], 8)
    q = np.column_stack((rng.uniform(-0.6, 0.6, (8, 4)), wrist, rng.uniform(-1.0, 1.0, 8)))
    wanted = states(arm_6, q, free=free)
    found = task.correct(arm_6, q + rng.normal(scale=0.01, size=q.shape), wanted)
    assert found.position_error.max() < 1e-14
    assert found.orientation_error.max() < 1e-13
    if not free:
        assert np.allclose(found.q, q, atol=1e-10)


def test_a_place_out_of_reach_beside_one_within_keeps_its_miss(arm_2r):
    q = np.array([[0.3, 0.4], [0.3, 0.4]])
    wanted = states(arm_2r, q, free=True)
    above = np.array([[0.0, 0.0, 0.02], [0.0, 0.0, 0.0]])
    found = task.correct(arm_2r, q + 0.01, wanted._replace(p=wanted.p + above))
    miss = wanted.p + above - arm_2r.fk(found.q)[:, :3, 3]
    assert np.allclose(found.position_error, np.linalg.norm(miss, axis=1), atol=1e-15)
    assert found.position_error[0] >= 0.02
    assert found.position_error[1] < 1e-15


def test_where_the_arm_loses_a_direction_joints_move_as_little_as_they_can(arm_2r):
    # stretched out along x: the tool can move along y only
    q = np.zeros((1, 2))
    wanted = states(arm_2r, q, free=True)._replace(slope=np.array([[1.0, 0.0, 0.0]]))
    assert np.allclose(task.slopes(arm_2r, q, wanted), 0.0, atol=1e-9)
    across = wanted._replace(slope=np.array([[0.0, 1.0, 0.0]]))
    reach = np.array([0.55, 0.25])
    assert np.allclose(task.slopes(arm_2r, q, across), reach / (reach @ reach), atol=1e-12)
