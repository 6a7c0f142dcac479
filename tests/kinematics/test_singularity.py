"""Nearness to a singularity, and the joints that bring it about."""

from math import pi

import numpy as np
import pytest

from splinearm.kinematics import DHConvention, DHLink
from splinearm.kinematics.singularity import nearest_singularity, reach

# an elbow arm with spherical wrist: a, alpha, d
ROWS = {
    "waist": (0.0, pi / 2, 0.4),
    "shoulder": (0.4, 0.0, 0.0),
    "elbow": (0.0, pi / 2, 0.0),
    "forearm": (0.0, -pi / 2, 0.4),
    "wrist": (0.0, pi / 2, 0.0),
    "flange": (0.0, 0.0, 0.1),
}
# elbow angle at which the forearm continues the upper arm
STRAIGHT = pi / 2


@pytest.fixture(scope="module")
def elbow_arm(dh_arm):
    rows = [DHLink(name, *row, theta=0.0) for name, row in ROWS.items()]
    return dh_arm(rows, DHConvention.STANDARD)


def test_a_straight_wrist_is_found(elbow_arm):
    found = nearest_singularity(elbow_arm, [0.3, 0.5, 0.4, 0.7, 0.0, 0.2])
    assert found.nearness < 1e-12
    assert found.causes == ("wrist",)
    assert found.opposed == ("forearm", "flange")
    text = "smallest singular value"
    assert text in str(found)
    assert "forearm, flange nearly undo each other, because of the position of wrist" in str(found)


def test_a_straight_elbow_is_found(elbow_arm):
    found = nearest_singularity(elbow_arm, [0.3, 0.5, STRAIGHT, 0.7, 0.9, 0.2])
    assert found.nearness < 1e-12
    assert found.causes == ("elbow",)
    assert "shoulder" in found.opposed
    assert "elbow" in found.opposed


def test_a_wrist_above_the_shoulder_is_found(elbow_arm):
    upper = 0.9
    # the forearm's end above the base: 0.4 cos(upper) + 0.4 sin(upper + elbow) = 0
    elbow = pi - np.arcsin(-np.cos(upper)) - upper
    found = nearest_singularity(elbow_arm, [0.3, upper, elbow, 0.7, 0.9, 0.2])
    assert found.nearness < 1e-12
    assert set(found.causes) == {"shoulder", "elbow"}
    assert "waist" in found.opposed


def test_the_lost_direction_is_the_one_the_joints_cannot_give(elbow_arm):
    q = [0.3, 0.5, STRAIGHT, 0.7, 0.9, 0.2]
    found = nearest_singularity(elbow_arm, q)
    size = reach(elbow_arm)
    scaled = np.array([1 / size] * 3 + [1] * 3)
    np.testing.assert_allclose(
        found.direction @ (scaled[:, None] * elbow_arm.jacobian(q)), 0, atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.norm(found.direction), 1.0, rtol=1e-12)


def test_nearness_grows_away_from_it(elbow_arm):
    near = [
        nearest_singularity(elbow_arm, [0.3, 0.5, 0.4, 0.7, wrist, 0.2]).nearness
        for wrist in (0.0, 0.01, 0.05, 0.1, 0.3)
    ]
    assert np.all(np.diff(near) > 0.0)
    assert nearest_singularity(elbow_arm, [0.3, 0.5, 0.4, 0.7, 0.05, 0.2]).causes == ("wrist",)


def test_it_does_not_depend_on_the_unit_of_length(dh_arm):
    def arm_of(size):
        rows = [
            DHLink(name, a * size, alpha, d * size, 0.0) for name, (a, alpha, d) in ROWS.items()
        ]
        return dh_arm(rows, DHConvention.STANDARD)

    q = [0.3, 0.5, 0.4, 0.7, 0.6, 0.2]
    one, thousand = (nearest_singularity(arm_of(size), q) for size in (1.0, 1000.0))
    assert one.nearness == pytest.approx(thousand.nearness, rel=1e-12)
    assert one.causes == thousand.causes


def test_an_arm_of_two_joints_is_singular_where_they_act_alike(dh_arm):
    rows = [DHLink("turn", 0.0, 0.0, 0.1, 0.0), DHLink("spin", 0.0, pi / 2, 0.0, 0.0)]
    arm = dh_arm(rows, DHConvention.STANDARD)
    found = nearest_singularity(arm, [0.2, 0.3])
    assert found.nearness < 1e-12
    assert found.opposed == ("turn", "spin")
    assert found.causes == ()
    assert "no joint" in str(found)


def test_a_redundant_arm_and_sliding_joints_are_no_trouble(random_arm):
    for seed in range(20):
        arm = random_arm(seed, 2 + seed % 7, DHConvention.STANDARD)
        q = np.random.default_rng(seed).uniform(-1, 1, arm.n)
        found = nearest_singularity(arm, q)
        assert np.isfinite(found.nearness)
        assert set(found.opposed) <= set(arm.joint_names)
        assert found.opposed


def test_many_postures_at_once_are_refused(elbow_arm):
    with pytest.raises(ValueError, match=r"q: want shape \(6,\), got \(2, 6\)"):
        nearest_singularity(elbow_arm, np.zeros((2, 6)))
