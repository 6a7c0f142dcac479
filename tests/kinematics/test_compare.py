from dataclasses import replace
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.joints import JointKind
from splinearm.kinematics import DHConvention, DHLink, Inertia, Pose, screw, se3, space
from splinearm.kinematics.compare import compare
from splinearm.kinematics.dh_conversion import to_dh
from splinearm.kinematics.urdf import read_urdf, write_urdf

seeds = st.integers(0, 100_000)

# UR5, from ros-industrial/universal_robot ur_description, BSD: a, alpha, d
UR5 = [
    (0.0, pi / 2, 0.089159),
    (-0.425, 0.0, 0.0),
    (-0.39225, 0.0, 0.0),
    (0.0, pi / 2, 0.10915),
    (0.0, -pi / 2, 0.09465),
    (0.0, 0.0, 0.0823),
]


def remodelled(arm, signs, offsets, base, tool):
    """Give the arm that is at q_b = signs q_a + offsets where the other is at q_a."""
    home = -np.asarray(signs) * offsets
    T = base @ arm.fk(home) @ tool
    jacobian = arm.jacobian(home)  # the screws there, moved from the tool point to the base's
    p = arm.fk(home)[:3, 3]
    linear = jacobian[:3].T + np.cross(p, jacobian[3:].T)
    screws = np.concatenate((linear, jacobian[3:].T), axis=-1) * np.asarray(signs)[:, None]
    ends = np.sort([signs * arm.limits.q_min + offsets, signs * arm.limits.q_max + offsets], 0)
    limits = replace(arm.limits, q_min=ends[0], q_max=ends[1])
    return screw.from_screws("other", screws @ se3.adjoint(base).T, T, limits)


def some_pose(rng):
    quat = rng.normal(size=4)
    return Pose(rng.uniform(-0.5, 0.5, 3), quat / np.linalg.norm(quat)).matrix()


@pytest.mark.property
@given(seeds, st.integers(2, 8))
@settings(deadline=None, max_examples=100)
def test_base_tool_signs_and_offsets_explain_all_of_a_remodelled_arm(random_arm, seed, n):
    rng = np.random.default_rng(seed)
    arm = random_arm(seed, n, DHConvention.STANDARD, slides=False)
    signs, offsets = rng.choice([-1.0, 1.0], n), rng.uniform(-2.0, 2.0, n)
    other = remodelled(arm, signs, offsets, some_pose(rng), some_pose(rng))
    found = compare(arm, other)
    assert found.same_motion, found.differences
    assert not [text for text in found.differences if text.startswith(("link", "motion"))]
    q = rng.uniform(-pi, pi, (5, n))
    wanted = found.T_base_b_base_a @ arm.fk(q) @ found.T_tool_a_tool_b
    np.testing.assert_allclose(other.fk(found.q_b(q)), wanted, atol=1e-9)


@pytest.mark.property
@given(seeds, st.integers(1, 8), st.sampled_from(list(DHConvention)))
@settings(deadline=None, max_examples=60)
def test_an_arm_is_the_same_as_itself_however_described(random_arm, seed, n, convention):
    arm = random_arm(seed, n, convention)
    for other in (arm, to_dh(arm, DHConvention.STANDARD), read_urdf(write_urdf(arm)).arm):
        assert compare(arm, other).differences == ()
        assert compare(other, arm).same


def test_a_ur5_with_its_base_turned_is_found_out(dh_arm):
    rows = [DHLink(f"j{i + 1}", *row, 0.0) for i, row in enumerate(UR5)]
    one = dh_arm(rows, DHConvention.STANDARD)
    turned = dh_arm(rows, DHConvention.STANDARD, T_base_first=space.rotation_z(pi))
    (says,) = compare(one, turned).differences
    assert "base" in says
    assert "turned by 180 deg about its z axis" in says
    assert "j1 counts from elsewhere" in says


def test_signs_offsets_and_lengths_are_told_apart(dh_arm):
    rows = [DHLink(f"j{i + 1}", *row, 0.0) for i, row in enumerate(UR5)]
    one = dh_arm(rows, DHConvention.STANDARD)
    other = [*rows]
    other[1] = DHLink("j2", -0.4263, 0.0, 0.0, pi / 2)
    other[3] = DHLink("j4", 0.0, pi / 2, 0.1, 0.0)
    found = compare(one, dh_arm(other, DHConvention.STANDARD))
    text = "\n".join(found.differences)
    assert "j2: offset: q_B = q_A - 90 deg" in text
    assert "link from j2 to j3: the distance of the axes (a) is 425 mm in A and 426.3 mm" in text
    assert "109.15 mm in A and 100 mm in B" in text
    assert "motion: by these links the tools come apart by up to 9.2" in text
    assert len(found.differences) == 4
    assert not found.same_motion


def test_an_arm_whose_axes_are_hardly_off_parallel_is_still_seen_as_the_same_kind(dh_arm):
    rows = [DHLink(f"j{i + 1}", *row, 0.0) for i, row in enumerate(UR5)]
    one = dh_arm(rows, DHConvention.STANDARD)
    bent = [*rows]
    bent[1] = DHLink("j2", -0.425, 1e-3, 0.0, 0.0)
    found = compare(one, dh_arm(bent, DHConvention.STANDARD))
    assert any("alpha" in text and "0.05729578 deg in B" in text for text in found.differences)
    assert not any("along the axis" in text for text in found.differences)


def test_tool_limits_names_and_masses_are_named(planar):
    links = tuple(
        replace(link, inertia=Inertia(1.0, [0, 0, 0], np.eye(3) * 1e-3)) for link in planar.links
    )
    one = replace(planar, links=links, dh=None)
    heavier = replace(links[1], inertia=Inertia(1.5, [0.01, 0, 0], np.eye(3) * 1e-3), name="bend")
    limits = replace(
        planar.limits,
        names=("shoulder", "bend"),
        q_max=np.array([2.7, 2.0]),
        qd_max=np.array([1.0, 2.0]),
    )
    other = replace(
        one,
        links=(links[0], heavier),
        limits=limits,
        T_flange_tool=space.translation([0.0, 0.0, 0.02]),
    )
    text = "\n".join(compare(one, other).differences)
    assert "joint 2 is called 'elbow' in A and 'bend' in B" in text
    assert "tool: B's tool, seen from A's, is moved by 20 mm along z" in text
    assert "elbow: limit: the highest position is 148.969 deg in A and 114.5916 deg in B" in text
    assert "elbow: limit: speed 57.2958 deg/s in A and 114.592 deg/s in B" in text
    assert "elbow: mass: its link has 1 kg in A and 1.5 kg in B" in text
    assert "elbow: mass: the centre of its link's mass is 10 mm away in B" in text


def test_limits_are_the_same_where_sign_and_offset_explain_them(planar):
    other = remodelled(planar, np.array([1.0, -1.0]), np.array([0.0, 0.3]), np.eye(4), np.eye(4))
    found = compare(planar, other)
    assert not any("limit" in text for text in found.differences)
    assert any("elbow: sign" in text for text in found.differences)


def test_arms_that_cannot_be_compared_are_refused(planar, widowx, dh_arm):
    with pytest.raises(ValueError, match="2 of 'test arm' and 6"):
        compare(planar, widowx)
    slide = dh_arm(
        [planar.dh[0], DHLink("elbow", 0.1, 0, 0, 0, JointKind.PRISMATIC)], DHConvention.STANDARD
    )
    with pytest.raises(ValueError, match="joint 2 is revolute"):
        compare(planar, slide)
