from math import inf, pi

import mujoco
import numpy as np
import pytest

from splinearm.errors import ConfigError
from splinearm.joints import JointKind
from splinearm.kinematics import DHConvention
from splinearm.kinematics.mjcf import read_mjcf, write_mjcf
from splinearm.kinematics.urdf import read_urdf, write_urdf

URDF = """
<robot name="picker">
  <link name="foot"/>
  <link name="post"><inertial><mass value="1.0"/><origin xyz="0 0 0.1"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="bracket"><inertial><mass value="0.5"/><origin xyz="0.1 0 0" rpy="0 0 0.3"/>
    <inertia ixx="0.001" iyy="0.002" izz="0.002" ixy="0.0001" ixz="0" iyz="0"/></inertial></link>
  <link name="boom"/><link name="hand"/><link name="camera"/>
  <link name="left"><inertial><mass value="0.1"/><origin xyz="0 0.01 0"/>
    <inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="right"/>
  <joint name="pan" type="continuous"><parent link="foot"/><child link="post"/>
    <origin xyz="0 0 0.2"/><axis xyz="0 0 2"/></joint>
  <joint name="plate" type="fixed"><parent link="post"/><child link="bracket"/>
    <origin xyz="0 0 0.3" rpy="0.1 0.2 0.3"/></joint>
  <joint name="reach" type="prismatic"><parent link="bracket"/><child link="boom"/>
    <axis xyz="1 0 0"/><limit lower="0.0" upper="0.4" velocity="0.2" effort="50"/></joint>
  <joint name="roll" type="revolute"><parent link="boom"/><child link="hand"/>
    <limit lower="-1.5" upper="2" velocity="0" effort="0" acceleration="7"/></joint>
  <joint name="mount" type="fixed"><parent link="hand"/><child link="camera"/>
    <origin xyz="0.05 0 0.02"/></joint>
  <joint name="grip" type="prismatic"><parent link="hand"/><child link="left"/>
    <origin xyz="0.1 0.02 0"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.03" velocity="0.1" effort="5"/></joint>
  <joint name="grip_too" type="prismatic"><parent link="hand"/><child link="right"/>
    <origin xyz="0.1 -0.02 0"/><axis xyz="0 1 0"/>
    <mimic joint="grip" multiplier="-1" offset="0.001"/>
    <limit lower="-0.03" upper="0.03" velocity="0.1" effort="5"/></joint>
</robot>
"""

COMPILER = '<mujoco><compiler fusestatic="false" boundmass="1e-6" boundinertia="1e-9"/></mujoco>'


def test_what_the_file_says_is_what_the_arm_does():
    found = read_urdf(URDF)
    arm = found.arm
    assert (arm.name, found.base, found.tip) == ("picker", "foot", "camera")
    assert arm.joint_names == ("pan", "reach", "roll")
    assert [kind.value for kind in arm.limits.kinds] == ["revolute", "prismatic", "revolute"]
    np.testing.assert_array_equal(arm.limits.q_min, [-inf, 0.0, -1.5])
    np.testing.assert_array_equal(arm.limits.q_max, [inf, 0.4, 2.0])
    # speeds and accelerations that the file does not give are the stated defaults
    np.testing.assert_array_equal(arm.limits.qd_max, [1.0, 0.2, 1.0])
    np.testing.assert_allclose(arm.limits.qdd_max, [2.0, 0.4, 7.0])
    assert arm.limits.torque_max is None
    # fixed links are carried by the joint before them, fingers as they are at zero
    assert arm.links[0].inertia.mass == pytest.approx(1.5)
    assert arm.links[2].inertia.mass == pytest.approx(0.1)
    assert arm.links[1].inertia is None


def test_fingers_and_mimics_are_kept_as_data():
    found = read_urdf(URDF, "hand")
    grip, too = found.side_joints
    assert (grip.name, grip.parent, grip.mimics, grip.q_max) == ("grip", "roll", "", 0.03)
    assert (too.mimics, too.multiplier, too.offset) == ("grip", -1.0, 0.001)
    assert too.kind is JointKind.PRISMATIC
    np.testing.assert_allclose(
        np.linalg.inv(found.arm.fk(np.zeros(3))) @ too.T_base_joint @ [0, 0, 1, 0],
        [0, 1, 0, 0],
        atol=1e-15,
    )
    assert grip.inertia.mass == pytest.approx(0.1)


@pytest.mark.parametrize(("write", "read"), [(write_urdf, read_urdf), (write_mjcf, read_mjcf)])
def test_side_joints_come_back_as_they_were(write, read, assert_same_arm):
    found = read_urdf(URDF, "hand")
    back = read(write(found.arm, found.side_joints))
    assert_same_arm(back.arm, found.arm)
    assert len(back.side_joints) == 2
    for side, like in zip(back.side_joints, found.side_joints, strict=True):
        for name in ("name", "kind", "parent", "q_min", "q_max", "mimics", "multiplier", "offset"):
            assert getattr(side, name) == getattr(like, name)
        np.testing.assert_allclose(side.T_base_joint, like.T_base_joint, atol=1e-14)
        assert (side.inertia is None) is (like.inertia is None)
        if side.inertia is not None:
            np.testing.assert_allclose(side.inertia.tensor, like.inertia.tensor, atol=1e-15)


@pytest.mark.sim
def test_mujoco_reads_the_urdf_as_we_do():
    arm = read_urdf(URDF, "hand").arm
    model = mujoco.MjModel.from_xml_string(
        URDF.replace('<link name="foot"/>', COMPILER + '<link name="foot"/>')
    )
    data = mujoco.MjData(model)
    q = [0.7, 0.3, -0.9]
    for name, value in zip(arm.joint_names, q, strict=True):
        data.qpos[model.joint(name).qposadr[0]] = value
    mujoco.mj_forward(model, data)
    T = arm.fk(q)
    np.testing.assert_allclose(data.body("hand").xpos, T[:3, 3], atol=1e-15)
    np.testing.assert_allclose(data.body("hand").xmat.reshape(3, 3), T[:3, :3], atol=1e-15)


@pytest.mark.sim
@pytest.mark.parametrize("seed", range(5))
def test_mujoco_reads_what_is_written(random_arm, joints_inside, seed):
    arm = random_arm(seed, 6, DHConvention.MODIFIED)
    text = write_urdf(arm).replace("<link ", COMPILER + "<link ", 1)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:] = q = joints_inside(arm, np.random.default_rng(seed))
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.body("tool").xpos, arm.fk(q)[:3, 3], atol=1e-14)
    np.testing.assert_allclose(data.body("tool").xmat.reshape(3, 3), arm.fk(q)[:3, :3], atol=1e-14)


def test_a_world_link_says_where_the_base_stands(random_arm):
    text = """<robot name="r"><link name="world"/><link name="b"/><link name="l"/>
      <joint name="w" type="fixed"><parent link="world"/><child link="b"/>
        <origin xyz="1 2 3"/></joint>
      <joint name="j" type="revolute"><parent link="b"/><child link="l"/>
        <limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""
    found = read_urdf(text)
    assert found.base == "b"
    np.testing.assert_array_equal(found.arm.T_world_base[:3, 3], [1, 2, 3])
    np.testing.assert_array_equal(found.arm.fk([0.0]), np.eye(4))


def test_a_file_is_read_and_a_base_can_be_chosen(tmp_path):
    file = tmp_path / "picker.urdf"
    file.write_text(URDF, encoding="utf-8")
    found = read_urdf(file, "hand", base="bracket")
    assert found.arm.joint_names == ("reach", "roll")
    np.testing.assert_allclose(found.arm.fk([0.25, 0.0])[:3, 3], [0.25, 0, 0], atol=1e-15)


@pytest.mark.parametrize(
    ("old", "new", "tip", "says"),
    [
        ("", "", "nose", "link 'nose': is not there; the tips are camera, left, right"),
        ('name="camera"/>', 'name="camera"/><link name="lost"/>', None, "one link that hangs"),
        ('<child link="boom"/>', '<child link="bom"/>', None, "joint 'reach': child.*'bom'"),
        ('type="prismatic"><parent link="br', 'type="planar"><parent link="br', None, "'planar'"),
        ('lower="0.0" upper="0.4"', 'lower="0.4" upper="0.4"', None, "'reach': its lowest"),
        ('upper="0.4"', 'upper="wide"', None, "joint 'reach' limit: upper.*'wide'"),
        ('<axis xyz="1 0 0"/>', '<axis xyz="0 0 0"/>', None, "joint 'reach' axis"),
        ('<origin xyz="0 0 0.2"/>', '<origin xyz="0 0"/>', None, "joint 'pan' origin.*3 numbers"),
        ('<mass value="0.5"/>', '<mass value="-1"/>', None, "link 'bracket' inertial: mass"),
        ('<mass value="0.5"/>', "", None, "link 'bracket' inertial: mass and inertia"),
        ("<robot ", "<robt ", None, "no XML"),
        ('<origin xyz="0 0 0.2"/>', '<origin xyz="0 0 inf"/>', None, "xyz: want finite numbers"),
        ('<mass value="0.5"/>', '<mass value="nan"/>', None, "value: want finite numbers"),
        ('joint="grip" mult', "mult", None, "'grip_too' mimic: joint is missing"),
        ("", "", "right", "'grip_too': mimics joint 'grip'"),
        ("", "", "foot", "no moving joint leads"),
        ('link name="left"', 'link name="hand"', None, "'hand': is there twice"),
        ('joint name="roll"', 'joint name="pan"', None, "'pan': is there twice"),
        ('type="revolute"><parent', 'type="revolute"><parnt', None, "parent: want the name"),
        ('<limit lower="-1.5" upper="2"', '<limits lower="-1.5"', None, "limit: is missing"),
        ('velocity="0.2"', 'velocity="-0.2"', None, "velocity: want a number above zero"),
    ],
)
def test_a_bad_file_is_refused_with_the_element(old, new, tip, says):
    assert old in URDF
    text = URDF.replace(old, new, 1)
    with pytest.raises(ConfigError, match=says):
        read_urdf(text, tip)


def test_several_tips_are_named():
    text = URDF.replace(
        '<link name="camera"/>', '<link name="camera"/><link name="lamp"/>'
    ).replace(
        "</robot>",
        '<joint name="m2" type="fixed"><parent link="hand"/><child link="lamp"/></joint></robot>',
    )
    with pytest.raises(ConfigError, match=r"several tips.*camera, lamp, left, right"):
        read_urdf(text)


def test_a_file_that_is_not_there_and_a_ring_are_refused(tmp_path):
    with pytest.raises(ConfigError, match=r"no\.urdf: cannot be read: No such file"):
        read_urdf(tmp_path / "no.urdf")
    ring = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
      <joint name="x" type="fixed"><parent link="b"/><child link="c"/></joint>
      <joint name="y" type="fixed"><parent link="c"/><child link="b"/></joint></robot>"""
    with pytest.raises(ConfigError, match="ring"):
        read_urdf(ring)
    with pytest.raises(ConfigError, match="its root is <mujoco>, not <robot>"):
        read_urdf("<mujoco/>")


def test_a_frame_on_the_base_is_no_tip():
    text = URDF.replace('<link name="foot"/>', '<link name="foot"/><link name="mark"/>').replace(
        "</robot>",
        '<joint name="m" type="fixed"><parent link="foot"/><child link="mark"/></joint></robot>',
    )
    assert read_urdf(text).tip == "camera"


def test_the_hand_that_all_fingers_hang_on_is_the_tip():
    mount = URDF.index('  <joint name="mount"')
    text = URDF[:mount] + URDF[URDF.index('  <joint name="grip"') :]
    assert read_urdf(text.replace('<link name="camera"/>', "")).tip == "hand"


def test_a_half_limited_joint_stays_so(random_arm, limits_of):
    from dataclasses import replace

    arm = random_arm(1, 3, DHConvention.STANDARD, slides=False)
    low, high = np.array([-inf, -pi, -inf]), np.array([1.0, inf, inf])
    arm = replace(arm, limits=limits_of(arm.joint_names, arm.limits.kinds, low, high))
    for back in (read_urdf(write_urdf(arm)), read_mjcf(write_mjcf(arm))):
        np.testing.assert_array_equal(back.arm.limits.q_min, low)
        np.testing.assert_array_equal(back.arm.limits.q_max, high)
