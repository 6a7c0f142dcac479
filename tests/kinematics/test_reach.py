import numpy as np
import pytest

from splinearm.kinematics import Pose, quaternion, search
from splinearm.kinematics.reach import reach_map


def test_a_planar_arm_reaches_a_ring(planar):
    found = reach_map(planar, spacing=0.05)
    r = np.linalg.norm(found.points[:, :2], axis=-1)
    assert np.ptp(found.points[:, 2]) < 1e-12
    assert not found.reached[r > 0.5501].any()
    inner = np.hypot(0.3 + 0.25 * np.cos(2.6), 0.25 * np.sin(2.6))
    assert not found.reached[r < inner - 1e-9].any()
    # in front of the arm, where no limit of the shoulder is in the way, all between is reached
    ahead = (r > inner + 1e-9) & (r < 0.5499) & (found.points[:, 0] > 0.0)
    assert found.reached[ahead].all()
    # best where the elbow is at a right angle
    best = r[np.argmax(found.manipulability)]
    assert best == pytest.approx(np.hypot(0.3, 0.25), abs=0.05)
    assert np.isnan(found.fraction).all()
    assert found.volume == pytest.approx(found.reached.sum() * 0.05**2)
    assert found.farthest <= np.hypot(0.5501, 0.06)


def test_a_map_says_what_the_search_says_of_each_pose(widowx):
    points = [[0.3, 0.0, 0.2], [0.2, 0.2, 0.3], [1.5, 0.0, 0.0]]
    shares = []
    found = reach_map(widowx, points=points, orientations=10, progress=shares.append)
    assert found.reached.tolist() == [True, True, False]
    for p, fraction in zip(points[:2], found.fraction, strict=False):
        met = [search(widowx, Pose(np.array(p), quat)).reached for quat in found.quats]
        assert fraction == np.mean(met)
    assert found.fraction[2] == 0.0
    assert found.manipulability[2] == 0.0
    assert shares[-1] == 1.0


def test_processes_share_the_work_and_give_the_same(widowx):
    points = np.random.default_rng(1).uniform(-0.5, 0.5, (150, 3))
    alone = reach_map(widowx, points=points)
    shared = reach_map(widowx, points=points, processes=2)
    np.testing.assert_array_equal(shared.reached, alone.reached)
    np.testing.assert_allclose(shared.manipulability, alone.manipulability, rtol=1e-9)


def test_orientations_are_spread_evenly():
    quats = quaternion.spread(2000)
    np.testing.assert_allclose(np.linalg.norm(quats, axis=-1), 1.0, atol=1e-15)
    images = quaternion.rotate(quats, [0.0, 0.0, 1.0])
    np.testing.assert_allclose(images.mean(axis=0), 0.0, atol=0.01)
    np.testing.assert_allclose(images.T @ images / 2000, np.eye(3) / 3.0, atol=0.01)


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({"spacing": 0.0}, "spacing: want a length above zero"),
        ({"spacing": 1e-5}, "want at most 2000000"),
        ({"orientations": -1}, "orientations"),
        ({"processes": 0}, "processes"),
        ({"points": [[np.nan, 0, 0]]}, "finite"),
    ],
)
def test_what_makes_no_map_is_refused(widowx, more, says):
    with pytest.raises(ValueError, match=says):
        reach_map(widowx, **more)
