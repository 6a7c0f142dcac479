from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from splinearm.config import load_cell
from splinearm.config.joint import read_joints
from splinearm.config.reader import Table
from splinearm.joints import JointKind
from splinearm.kinematics import DHConvention

LIMITS = {"min_deg": -10, "max_deg": 10, "max_speed_deg_s": 5, "max_acceleration_deg_s2": 5}
UNIT = st.lists(st.floats(-1, 1), min_size=3, max_size=3).filter(lambda v: np.linalg.norm(v) > 0.1)


@pytest.mark.property
@given(
    axis=UNIT, q=st.floats(-3.0, 3.0), rpy=st.lists(st.integers(-180, 180), min_size=3, max_size=3)
)
def test_a_link_by_frames_turns_about_its_axis_in_its_own_frame(axis, q, rpy):
    unit = np.array(axis) / np.linalg.norm(axis)
    values = {
        "name": "j",
        "xyz_mm": [100, -20, 3],
        "rpy_deg": rpy,
        "axis": [Decimal(repr(float(part))) for part in unit],
        **LIMITS,
    }
    (joint,) = read_joints([Table(values, "some.toml", "joint[0]")], None)
    T = joint.row.matrix(q)
    origin = Rotation.from_euler("xyz", rpy, degrees=True)
    np.testing.assert_allclose(
        T[:3, :3], (origin * Rotation.from_rotvec(q * unit)).as_matrix(), atol=1e-13
    )
    np.testing.assert_allclose(T[:3, 3], [0.1, -0.02, 0.003], atol=1e-16)


def test_a_row_says_what_dh_says(arm_text, written):
    arm = load_cell(written(arm_text)).arm
    assert arm.convention is DHConvention.STANDARD
    assert arm.joint_names == ("shoulder", "elbow")
    assert (arm.dh[0].a, arm.dh[0].d) == (0.3, 0.06)
    np.testing.assert_allclose(arm.fk([0.0, np.pi / 2])[:3, 3], [0.3, 0.25, 0.06], atol=1e-15)


def test_limits_come_in_si(arm_text, written):
    limits = load_cell(written(arm_text)).arm.limits
    np.testing.assert_allclose(np.rad2deg(limits.q_min), [-150.0, -140.0])
    np.testing.assert_allclose(np.rad2deg(limits.q_max), [150.0, 140.0])
    np.testing.assert_allclose(np.rad2deg(limits.qd_max), [160.0, 160.0])
    np.testing.assert_allclose(np.rad2deg(limits.qdd_max), [600.0, 600.0])
    assert limits.qddd_max is None


def test_inertias_stand_in_the_link_frame(arm_text, written):
    inertia = load_cell(written(arm_text)).arm.links[0].inertia
    assert inertia.mass == 0.3
    np.testing.assert_array_equal(inertia.com, [-0.15, 0.0, 0.0])
    np.testing.assert_array_equal(np.diag(inertia.tensor), [6e-5, 0.00228, 0.00228])


def test_the_six_numbers_of_an_inertia_are_xx_yy_zz_xy_xz_yz(arm_text, written, edited):
    text = edited(
        arm_text, "[6e-5, 0.00228, 0.00228, 0.0, 0.0, 0.0]", "[4e-3, 5e-3, 6e-3, 1e-4, 2e-4, 3e-4]"
    )
    tensor = load_cell(written(text)).arm.links[0].inertia.tensor
    np.testing.assert_array_equal(
        tensor, [[4e-3, 1e-4, 2e-4], [1e-4, 5e-3, 3e-4], [2e-4, 3e-4, 6e-3]]
    )


def test_an_arm_may_go_without_inertias(arm_text, written):
    lines = [
        line
        for line in arm_text.splitlines()
        if not line.startswith(("mass_kg", "com_mm", "inertia_kg_m2"))
    ]
    arm = load_cell(written("\n".join(lines))).arm
    assert [link.inertia for link in arm.links] == [None, None]


def test_a_sliding_joint_is_in_millimetres_and_newtons(sliding_arm_text, written):
    cell = load_cell(written(sliding_arm_text))
    limits = cell.arm.limits
    assert limits.kinds == (JointKind.REVOLUTE, JointKind.PRISMATIC)
    assert (limits.q_max[1], limits.qd_max[1], limits.qdd_max[1]) == (0.2, 0.15, 0.5)
    np.testing.assert_array_equal(limits.torque_max, [4.0, 20.0])
    np.testing.assert_allclose(cell.poses["home"], [np.pi / 2, 0.12])
    np.testing.assert_allclose(
        cell.arm.fk(cell.poses["home"])[:3, 3], [0.0, 0.12, 0.15], atol=1e-15
    )


def test_a_joint_may_turn_without_end(sliding_arm_text, written, edited):
    text = edited(sliding_arm_text, "min_deg = -180.0\nmax_deg = 180.0", "endless = true")
    limits = load_cell(written(text)).arm.limits
    assert (limits.q_min[0], limits.q_max[0]) == (-np.inf, np.inf)


def test_a_joint_without_end_has_no_limits(sliding_arm_text, edited, refusal):
    text = edited(sliding_arm_text, "min_deg = -180.0", "endless = true")
    refusal(load_cell, text, "joint[0].max_deg", "contradicts endless; take one of them out")


def test_jerk_limits_are_read(sliding_arm_text, written, edited):
    text = edited(sliding_arm_text, "max_torque_nm = 4.0", "max_jerk_deg_s3 = 1800.0")
    text = edited(text, "max_force_n = 20.0", "max_jerk_mm_s3 = 4000.0")
    limits = load_cell(written(text)).arm.limits
    np.testing.assert_allclose(limits.qddd_max, [10.0 * np.pi, 4.0])
    assert limits.torque_max is None


@pytest.mark.parametrize(
    ("change", "key", "remedy"),
    [
        (("a_mm = 300.0\n", ""), "joint[0].a_mm", "is missing; give a number in millimetres"),
        (("a_mm = 300.0", "a_cm = 30.0"), "joint[0].a_cm", "this wants millimetres: a_mm"),
        (("d_mm = 60.0", "d_mm = 60.0\nr_mm = 1"), "joint[0].r_mm", "known|did you mean"),
        (("a_mm = 300.0", "a_mm = nan"), "joint[0].a_mm", "that is finite, got NaN"),
        (("a_mm = 300.0", 'a_mm = "300"'), "joint[0].a_mm", "wants a number in millimetres"),
        (("min_deg = -150.0", "min_deg = 151"), "joint[0].min_deg", "below max_deg; swap"),
        (("= 160.0", "= 0"), "joint[0].max_speed_deg_s", "above 0, got 0"),
        (("mass_kg = 0.3", "mass_kg = 0"), "joint[0].mass_kg", "above 0"),
        (("com_mm = [-150.0, 0.0, 0.0]", "com_mm = [1, 2]"), "joint[0].com_mm", "wants 3 numbers"),
        (("com_mm = [-150.0, 0.0, 0.0]\n", ""), "joint[0].com_mm", "is missing; give 3 numbers"),
        (
            ("[6e-5, 0.00228", "[1.0, 0.00228"),
            "joint[0].inertia_kg_m2",
            "at most the sum.*xx yy zz",
        ),
        (("[6e-5, 0.00228", "[-6e-5, 0.00228"), "joint[0].inertia_kg_m2", "above zero"),
        (('name = "elbow"', 'name = "shoulder"'), "joint[1].name", "also the name of another"),
        (('convention = "dh-standard"', ""), "convention", "is missing; give one of .*dh-modified"),
        (('"dh-standard"', '"dh"'), "convention", 'wants one of "dh-standard"'),
        (('"dh-standard"', '"frames"'), "joint[0].axis", "is missing; give 3 numbers"),
        (('name = "elbow"', 'name = "elbow"\nkind = "sliding"'), "joint[1].kind", '"prismatic"'),
        (('name = "elbow"', 'name = "elbow"\nkind = "prismatic"'), "joint[1].min_deg", "min_mm"),
        (("[[joint]]", "[[joints]]"), "joints", "did you mean 'joint'"),
    ],
)
def test_a_joint_that_cannot_be_used_is_refused(change, key, remedy, arm_text, edited, refusal):
    refusal(load_cell, edited(arm_text, *change), key, remedy)


def test_masses_stand_for_all_joints_or_none(arm_text, written, edited, refusal):
    text = edited(arm_text, "mass_kg = 0.25\ncom_mm = [125.0, 0.0, 0.0]\n", "")
    text = edited(text, "inertia_kg_m2 = [5e-5, 0.0013, 0.0013, 0.0, 0.0, 0.0]\n", "")
    refusal(load_cell, text, "joint[1].mass_kg", "for all or for none")


def test_jerks_stand_for_all_joints_or_none(sliding_arm_text, written, edited, refusal):
    text = edited(sliding_arm_text, "max_torque_nm = 4.0", "max_jerk_deg_s3 = 1800.0")
    refusal(load_cell, text, "joint[1].max_jerk_mm_s3", "for all or for none")


def test_an_arm_has_joints(written, refusal):
    text = 'schema = "splinearm-arm/1"\nname = "x"\ntitle = "X"\nconvention = "frames"\n'
    refusal(load_cell, text, "joint", r"give a \[\[joint\]\] table for each joint")
