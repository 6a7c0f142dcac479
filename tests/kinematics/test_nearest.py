import numpy as np
import pytest

from splinearm.kinematics import Pose, quaternion
from splinearm.kinematics.nearest import nearest_pose


@pytest.mark.kernel
def test_a_pose_within_reach_is_its_own_nearest(widowx):
    target = Pose.from_matrix(widowx.fk(np.full(6, 0.3)))
    found = nearest_pose(widowx, target)
    assert found.reason == ""
    np.testing.assert_allclose(found.pose.matrix(), target.matrix(), atol=3e-6)


@pytest.mark.kernel
def test_the_nearest_position_is_on_the_edge_of_reach(planar):
    found = nearest_pose(planar, [0.0, 0.8, 0.06])
    np.testing.assert_allclose(found.pose.p, [0.0, 0.55, 0.06], atol=1e-6)
    assert found.position_error == pytest.approx(0.25, abs=1e-6)
    assert found.reason.startswith("out of reach by 250 mm")


@pytest.mark.kernel
def test_the_rate_of_exchange_moves_the_nearest_pose_between_place_and_direction(widowx):
    target = Pose([0.6, 0.2, 0.1], [0.0, 1.0, 0.0, 0.0])
    found = [nearest_pose(widowx, target, radian_length=length) for length in (None, 0.05, 0.3, 2)]
    assert found[0].position_error <= 1e-6
    places = [nearest.position_error for nearest in found]
    turns = [nearest.orientation_error for nearest in found]
    assert places == sorted(places)
    assert turns == sorted(turns, reverse=True)
    for nearest in found:
        T = widowx.fk(nearest.q)
        np.testing.assert_allclose(T, nearest.pose.matrix(), atol=1e-12)
        assert nearest.position_error == pytest.approx(np.linalg.norm(T[:3, 3] - target.p))
        assert (nearest.q >= widowx.limits.q_min).all()
        assert (nearest.q <= widowx.limits.q_max).all()


def test_nothing_that_can_be_reached_is_nearer(widowx, joints_inside):
    rng = np.random.default_rng(1)
    length = 0.2
    T = widowx.fk(joints_inside(widowx, rng, 20_000))
    for _ in range(5):
        target = Pose(rng.uniform(-0.9, 0.9, 3), quaternion.normalize(rng.normal(size=4)))
        found = nearest_pose(widowx, target, radian_length=length)
        cost = (found.position_error / length) ** 2 + found.orientation_error**2
        off = np.linalg.norm(T[:, :3, 3] - target.p, axis=1) / length
        turned = quaternion.angle_between(quaternion.from_matrix(T[:, :3, :3]), target.quat)
        assert cost <= (off**2 + turned**2).min() + 1e-6


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"target": [0.0, np.nan, 0.0]}, "target: want finite numbers"),
        ({"radian_length": 0.0}, "radian_length: want a finite length above zero, got 0"),
        ({"position_tolerance": np.nan}, "position_tolerance: want a finite number"),
    ],
)
@pytest.mark.kernel
def test_arguments_that_are_none_are_refused(planar, arguments, message):
    with pytest.raises(ValueError, match=message):
        nearest_pose(planar, **{"target": [0.4, 0.1, 0.06], **arguments})
