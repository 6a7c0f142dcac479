import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.joints import JointKind
from splinearm.kinematics import DHConvention, screw

seeds = st.integers(0, 100_000)


@pytest.mark.property
@given(seeds, st.integers(1, 8), st.sampled_from(["base", "tool"]))
@settings(deadline=None, max_examples=50)
def test_an_arm_and_its_screws_say_the_same(random_arm, joints_inside, seed, n, frame):
    arm = random_arm(seed, n, DHConvention.STANDARD)
    q = joints_inside(arm, np.random.default_rng(seed), 5)
    home = arm.fk(np.zeros(n))
    in_base = screw.screws_of(arm)
    np.testing.assert_allclose(screw.product(in_base, home, q), arm.fk(q), atol=1e-13)
    screws = screw.screws_of(arm, frame)
    back = screw.from_screws("back", screws, home, arm.limits, frame=frame)
    np.testing.assert_allclose(back.fk(q), arm.fk(q), atol=1e-13)
    np.testing.assert_allclose(back.jacobian(q), arm.jacobian(q), atol=1e-13)
    np.testing.assert_allclose(screw.screws_of(back), in_base, atol=1e-14)


def test_screws_of_a_planar_arm_are_those_of_the_book(planar):
    screws = screw.screws_of(planar)
    np.testing.assert_allclose(screws, [[0, 0, 0, 0, 0, 1], [0, -0.3, 0, 0, 0, 1]], atol=1e-15)


def test_the_angular_part_may_stand_first_at_the_border():
    twist = np.arange(6.0)
    np.testing.assert_array_equal(screw.to_angular_first(twist), [3, 4, 5, 0, 1, 2])
    np.testing.assert_array_equal(screw.from_angular_first(screw.to_angular_first(twist)), twist)


@pytest.mark.parametrize(
    ("change", "kind", "says"),
    [
        ([0, 0, 0, 0, 0, 2], "revolute", "angular part of length 1"),
        ([0, 0, 0.1, 0, 0, 1], "revolute", "turns without sliding"),
        ([0, 0, 0, 0, 0, 1], "prismatic", "linear part of length 1"),
        ([0, 0, 1, 0, 0, 1], "prismatic", "slides without turning"),
        ([0, 0, np.nan, 0, 0, 1], "revolute", "finite"),
    ],
)
def test_what_is_no_screw_of_a_joint_is_refused(limits_of, change, kind, says):
    limits = limits_of(["one"], [JointKind(kind)], [-1.0], [1.0])
    with pytest.raises(ValueError, match=says):
        screw.from_screws("bad", [change], np.eye(4), limits)


def test_another_frame_is_refused(planar):
    with pytest.raises(ValueError, match="'base' or 'tool', got 'world'"):
        screw.screws_of(planar, "world")
