from dataclasses import replace
from math import inf

import mujoco
import numpy as np
import pytest

from splinearm.errors import ConfigError
from splinearm.kinematics import DHConvention, Inertia
from splinearm.kinematics.mjcf import read_mjcf, write_mjcf

MJCF = """
<mujoco model="bench">
  <compiler angle="degree" eulerseq="zyx"/>
  <default>
    <joint axis="0 1 0" range="-90 45"/>
    <default class="slider"><joint type="slide" axis="1 0 0" range="-0.1 0.3"/></default>
    <default class="hand"><site pos="0 0 0.1"/></default>
  </default>
  <worldbody>
    <light pos="0 0 3"/>
    <body name="stand" pos="0.5 0 0.1" euler="30 20 10">
      <geom size="0.1"/>
      <frame pos="0 0 0.2" axisangle="0 0 1 45">
        <body name="arm" pos="0.1 0 0" quat="0.5 0.5 0.5 0.5">
          <inertial pos="0.01 0.02 0.03" mass="0.7" diaginertia="0.003 0.002 0.0015"
             quat="0.8 0.2 0.1 0"/>
          <joint name="lift" pos="0.02 0 0.01"/>
          <joint name="swing" axis="0 0 1" range="-170 170" ref="20"/>
          <body name="sled" childclass="slider" pos="0 0.2 0" xyaxes="0 1 0 -1 0.1 0">
            <inertial pos="0 0 0" mass="0.3" fullinertia="0.001 0.002 0.0015 1e-5 2e-5 3e-5"/>
            <joint name="slide" ref="0.05" actuatorfrcrange="-12 10"/>
            <body name="hand" zaxis="1 1 0.2">
              <inertial pos="0 0 0" mass="0.1" diaginertia="1e-4 1e-4 1e-4"/>
              <joint name="spin" type="hinge" limited="false"/>
              <site name="grip" class="hand" euler="0 90 0"/>
              <body name="finger" pos="0 0.01 0">
                <inertial pos="0 0 0" mass="0.02" diaginertia="1e-5 1e-5 1e-5"/>
                <joint name="finger"/></body>
            </body>
          </body>
        </body>
      </frame>
    </body>
  </worldbody>
  <equality><joint joint1="finger" joint2="spin" polycoef="0.1 -2 0 0 0"/></equality>
</mujoco>
"""


def mujoco_tool(text, arm, q, site):
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    for name, value in zip(arm.joint_names, q, strict=True):
        data.qpos[model.joint(name).qposadr[0]] = value
    mujoco.mj_forward(model, data)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = data.site(site).xmat.reshape(3, 3), data.site(site).xpos
    return model, T


@pytest.mark.sim
@pytest.mark.parametrize("seed", range(4))
def test_mujoco_reads_the_file_as_we_do(seed):
    arm = read_mjcf(MJCF).arm
    q = np.random.default_rng(seed).uniform(-1, 1, 4)
    model, T = mujoco_tool(MJCF, arm, q, "grip")
    np.testing.assert_allclose(arm.T_world_base @ arm.fk(q), T, atol=1e-14)
    for i in range(4):
        limited = model.jnt_limited[i]
        want = model.jnt_range[i] if limited else (-inf, inf)
        np.testing.assert_allclose((arm.limits.q_min[i], arm.limits.q_max[i]), want, rtol=1e-15)


def test_what_the_file_says_is_what_is_read():
    found = read_mjcf(MJCF)
    assert found.arm.joint_names == ("lift", "swing", "slide", "spin")
    assert (found.arm.name, found.base, found.tip) == ("bench", "stand", "grip")
    assert found.arm.links[0].inertia is None  # the second joint of the same body carries it
    assert found.arm.links[1].inertia.mass == pytest.approx(0.7)
    assert found.arm.links[3].inertia.mass == pytest.approx(0.12)
    (finger,) = found.side_joints
    assert (finger.mimics, finger.multiplier, finger.offset) == ("spin", -2.0, 0.1)


@pytest.mark.sim
@pytest.mark.parametrize("seed", range(5))
def test_mujoco_reads_what_is_written(random_arm, joints_inside, seed):
    arm = random_arm(seed, 2 + seed, DHConvention.STANDARD)
    q = joints_inside(arm, np.random.default_rng(seed))
    model, T = mujoco_tool(write_mjcf(arm), arm, q, "tool")
    np.testing.assert_allclose(T, arm.T_world_base @ arm.fk(q), atol=1e-14)
    np.testing.assert_allclose(model.jnt_range[:, 0], arm.limits.q_min, rtol=1e-15)


@pytest.mark.sim
def test_mujoco_finds_the_masses_that_are_written():
    arm = read_mjcf(MJCF).arm
    model, _ = mujoco_tool(write_mjcf(arm), arm, np.zeros(4), "tool")
    read, _ = mujoco_tool(MJCF, arm, np.zeros(4), "grip")
    moving = read.body_mass.sum() - read.body("stand").mass[0]
    assert model.body_mass.sum() == pytest.approx(moving, abs=1e-5)
    data, other = mujoco.MjData(model), mujoco.MjData(read)
    other.qpos[:4] = 0.0
    mujoco.mj_inverse(model, data)
    mujoco.mj_forward(read, other)
    mujoco.mj_forward(model, data)
    # read lists the finger last: its torque is none of the arm's
    np.testing.assert_allclose(data.qfrc_bias, other.qfrc_bias[:4], atol=1e-5)


@pytest.mark.sim
@pytest.mark.parametrize("moments", [(0, 0, 0), (0, 1e-3, 1e-3), (1e-3, 1e-3, 5e-3)])
def test_mujoco_takes_inertias_that_no_body_has_and_they_come_back(
    planar, assert_same_arm, moments
):
    odd = Inertia(0.2, [0.1, 0.0, 0.0], np.diag(np.array(moments, dtype=float)))
    arm = replace(planar, links=tuple(replace(link, inertia=odd) for link in planar.links), dh=None)
    text = write_mjcf(arm)
    mujoco_tool(text, arm, np.zeros(2), "tool")
    assert_same_arm(read_mjcf(text).arm, arm)


@pytest.mark.parametrize(
    ("old", "new", "tip", "says"),
    [
        ("<light", '<include file="x.xml"/><light', None, "<include>: is not read"),
        ('name="spin" type="hinge"', 'name="spin" type="ball"', None, "'spin'.*type 'ball'"),
        ('"hand" euler', '"head" euler', None, "class: there is no default class 'head'"),
        ('axis="0 0 1" range', 'axis="0 0 0" range', None, "'swing': axis"),
        ('mass="0.7"', 'mass="heavy"', None, "body 'arm' inertial: mass.*'heavy'"),
        ('euler="30 20 10"', 'euler="30 20 10" zaxis="0 0 1"', None, "twice: zaxis and euler"),
        ('eulerseq="zyx"', 'eulerseq="zyy"', None, "eulerseq"),
        ('range="-170 170"', 'range="170 -170"', None, "'swing': its lowest"),
        ('name="swing"', 'name="lift"', None, "joint 'lift': is there twice"),
        ("", "", "nose", "site or body 'nose': is not there"),
        ("", "", "stand", "no moving joint leads"),
        ('polycoef="0.1 -2 0 0 0"', 'polycoef="0 1 2 0 0"', None, "polycoef"),
        ("<compiler ", '<compiler coordinate="global" ', None, "coordinate"),
        ("<compiler ", '<compiler autolimits="false" ', None, "autolimits"),
    ],
)
def test_a_bad_file_is_refused_with_the_element(old, new, tip, says):
    assert old in MJCF
    with pytest.raises(ConfigError, match=says):
        read_mjcf(MJCF.replace(old, new, 1), tip)
