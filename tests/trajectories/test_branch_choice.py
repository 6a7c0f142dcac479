import numpy as np
import pytest

from splinearm.errors import UnreachableError
from splinearm.kinematics import quaternion, search_path
from splinearm.kinematics.pose import Pose
from splinearm.trajectories import branch_choice
from splinearm.trajectories.path import ToolPlaces, spline_path


def path_from(arm, q, step, *, free=False):
    T = arm.fk(q)
    p = T[:3, 3] + np.linspace(0.0, 1.0, 3)[:, None] * np.asarray(step)
    quats = None if free else np.tile(quaternion.from_matrix(T[:3, :3]), (3, 1))
    return spline_path(ToolPlaces(p, quats))


def _samples(path):
    state = path.state(np.linspace(*path.domain, 50))
    if state.quat is None:
        return state.p
    return [Pose(*place) for place in zip(state.p, state.quat, strict=True)]


@pytest.mark.parametrize("free", [False, True])
def test_a_configuration_that_can_follow_is_chosen_and_a_near_one_kept(arm_6, q_6, free):
    path = path_from(arm_6, q_6, [0.0, -0.1, 0.02], free=free)
    choice = branch_choice.choose(arm_6, [path], q_6)
    assert choice.q is not None
    assert np.allclose(arm_6.fk(choice.q)[:3, 3], path.at(0.0)[0], atol=1e-5)
    joints = search_path(arm_6, _samples(path), choice.q)
    assert joints.followed
    if not free:
        assert np.abs(choice.q - q_6).max() < 1e-5


def test_ways_one_after_the_other_are_followed_as_one(arm_6):
    q = np.array([-0.1, -0.8, 0.4, -1.5, -0.1, 0.1])
    whole = path_from(arm_6, q, [-0.03, 0.03, 0.1])
    halves = [path_from(arm_6, q, [-0.015, 0.015, 0.05])]
    halves.append(
        spline_path(
            ToolPlaces(
                halves[0].at(halves[0].domain[1])[0]
                + np.linspace(0, 1, 3)[:, None] * [-0.015, 0.015, 0.05],
                np.tile(whole.at(0.0)[1], (3, 1)),
            )
        )
    )
    one, two = (branch_choice.choose(arm_6, ways, q) for ways in ([whole], halves))
    assert np.allclose(one.q, two.q, atol=1e-5)
    assert np.abs(one.q - q).max() > 0.1


def test_nothing_is_said_where_ways_are_of_different_kinds_or_out_of_reach(arm_6, q_6):
    ways = [path_from(arm_6, q_6, [0.0, 0.05, 0.0], free=free) for free in (True, False)]
    assert branch_choice.choose(arm_6, ways, q_6) is branch_choice.UNKNOWN
    far = path_from(arm_6, q_6, [2.0, 0.0, 0.0])
    assert branch_choice.choose(arm_6, [far], q_6) is branch_choice.UNKNOWN


def test_a_refusal_keeps_its_facts_and_says_what_another_start_would_do(arm_6, q_6):
    error = UnreachableError(0.01, 0.02, "elbow", "it is too far", "waypoint 3")
    told = branch_choice.explained(arm_6, error, branch_choice.Choice(q_6, is_known=True))
    assert (told.position_error, told.orientation_error, told.joint) == (0.01, 0.02, "elbow")
    assert "waypoint 3 is out of reach by 10 mm" in str(told)
    assert str(told).endswith(
        "it is too far; it can be followed if the arm starts in another configuration: "
        "waist 11.46 deg, shoulder -17.19 deg, elbow 22.92 deg, forearm_roll 17.19 deg, "
        "wrist_angle 34.38 deg, wrist_rotate 5.73 deg"
    )
    none = branch_choice.explained(arm_6, error, branch_choice.NONE)
    assert str(none).endswith(
        "no other configuration at the start was found that can follow either"
    )
    assert branch_choice.explained(arm_6, error, branch_choice.UNKNOWN) is error
