"""The same arms in MuJoCo and in Pinocchio: poses, Jacobians and dynamics agree to 1e-12."""

from math import pi

import mujoco
import numpy as np
import pytest

from splinearm.joints import JointKind
from splinearm.kinematics import DHConvention, DHLink, Inertia, differential
from splinearm.kinematics.body import moved
from splinearm.kinematics.dynamics import Dynamics
from splinearm.kinematics.quaternion import from_matrix

AGREEMENT = 1e-12

# Robotics Toolbox for Python 1.5 (MIT), models.DH.Puma560: a, alpha, d
PUMA_560 = [
    (0.0, pi / 2, 0.6718),
    (0.4318, 0.0, 0.0),
    (0.0203, -pi / 2, 0.15005),
    (0.0, pi / 2, 0.4318),
    (0.0, -pi / 2, 0.0),
    (0.0, 0.0, 0.0),
]
# Universal Robots, "DH parameters for calculations of kinematics and dynamics", UR5
UR5 = [
    (0.0, pi / 2, 0.089159),
    (-0.425, 0.0, 0.0),
    (-0.39225, 0.0, 0.0),
    (0.0, pi / 2, 0.10915),
    (0.0, -pi / 2, 0.09465),
    (0.0, 0.0, 0.0823),
]
# Franka Emika, "Denavit-Hartenberg parameters" of the robot arm (Craig's convention)
PANDA = [
    (0.0, 0.0, 0.333),
    (0.0, -pi / 2, 0.0),
    (0.0, pi / 2, 0.316),
    (0.0825, pi / 2, 0.0),
    (-0.0825, -pi / 2, 0.384),
    (0.0, pi / 2, 0.0),
    (0.088, pi / 2, 0.0),
]
KNOWN = {
    "puma_560": (PUMA_560, DHConvention.STANDARD),
    "ur5": (UR5, DHConvention.STANDARD),
    "panda": (PANDA, DHConvention.MODIFIED),
}


def random_inertia(rng):
    """Give the inertia of six point masses, which is that of a body that can be."""
    masses, points = rng.uniform(0.05, 0.5, 6), rng.uniform(-0.15, 0.15, (6, 3))
    com = masses @ points / masses.sum()
    r = points - com
    squares = (r * r).sum(axis=1)
    tensor = np.einsum("i,i,jk->jk", masses, squares, np.eye(3)) - np.einsum(
        "i,ij,ik->jk", masses, r, r
    )
    return Inertia(float(masses.sum()), com, tensor)


@pytest.fixture(scope="module")
def with_inertias():
    from dataclasses import replace

    def give(arm, seed):
        rng = np.random.default_rng(seed)
        links = [replace(link, inertia=random_inertia(rng)) for link in arm.links]
        return replace(arm, links=tuple(links))

    return give


@pytest.fixture(scope="module")
def arms(dh_arm, random_arm, with_inertias):
    found = []
    for rows, convention in KNOWN.values():
        links = [DHLink(f"j{i}", *row, theta=0.0) for i, row in enumerate(rows)]
        found.append(dh_arm(links, convention, q_min=-3.0, q_max=3.0))
    conventions = (DHConvention.STANDARD, DHConvention.MODIFIED)
    found += [random_arm(seed, 2 + seed % 7, conventions[seed % 2]) for seed in range(200)]
    return [with_inertias(arm, seed) for seed, arm in enumerate(found)]


def numbers(values):
    return " ".join(repr(float(value)) for value in np.ravel(values))


def placed(T):
    return f'pos="{numbers(T[:3, 3])}" quat="{numbers(from_matrix(T[:3, :3]))}"'


def mujoco_model(arm):
    """Give the arm as MuJoCo has it: a body a joint, in its moved joint frame."""
    fixed = arm.packed.fixed
    opened = ""
    for k, link in enumerate(arm.links):
        body = moved(link.inertia, link.T_joint_link)
        I = body.tensor
        kind = "hinge" if link.kind is JointKind.REVOLUTE else "slide"
        full = numbers([I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]])
        opened += (
            f"<body {placed(fixed[k])}>"
            f'<joint type="{kind}" axis="0 0 1" limited="false"/>'
            f'<inertial pos="{numbers(body.com)}" mass="{body.mass!r}" fullinertia="{full}"/>'
        )
    tool = placed(fixed[-1])
    closed = "</body>" * arm.n
    return mujoco.MjModel.from_xml_string(
        '<mujoco><compiler angle="radian"/><option gravity="0 0 -9.81"><flag contact="disable"/>'
        f"</option><worldbody>{opened}<site name='tool' {tool}/>{closed}</worldbody></mujoco>"
    )


def states(arm, seed):
    rng = np.random.default_rng(seed)
    return rng.uniform(-2, 2, (3, arm.n))


def agree(ours, theirs, what):
    scale = max(1.0, float(np.abs(theirs).max()))
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=AGREEMENT * scale, err_msg=what)


@pytest.mark.sim
def test_mujoco_agrees(arms):
    for seed, arm in enumerate(arms):
        model = mujoco_model(arm)
        data = mujoco.MjData(model)
        q, qd, qdd = states(arm, seed)
        data.qpos[:], data.qvel[:], data.qacc[:] = q, qd, qdd
        mujoco.mj_inverse(model, data)
        torque = data.qfrc_inverse.copy()
        J, J_rate = np.zeros((6, arm.n)), np.zeros((6, arm.n))
        mujoco.mj_jacSite(model, data, J[:3], J[3:], 0)
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = data.site_xmat[0].reshape(3, 3), data.site_xpos[0]
        where = data.site_xpos[0].copy()
        mujoco.mj_jacDot(model, data, J_rate[:3], J_rate[3:], where, arm.n)
        dynamics = Dynamics(arm)
        agree(arm.fk(q), T, "pose")
        agree(arm.jacobian(q), J, "Jacobian")
        agree(differential.jacobian_rate(arm, q, qd), J_rate, "its rate")
        agree(dynamics.inverse(q, qd, qdd), torque, "inverse dynamics")
        agree(dynamics.inverse(np.array([q, q]), qd, qdd)[1], torque, "in a batch")
        agree(dynamics.gravity_torque(q) + dynamics.coriolis_torque(q, qd), data.qfrc_bias, "bias")


def pinocchio_model(pin, arm):
    model = pin.Model()
    model.gravity.linear = np.array([0.0, 0.0, -9.81])
    fixed = arm.packed.fixed
    parent = 0
    for k, link in enumerate(arm.links):
        turns = link.kind is JointKind.REVOLUTE
        joint = pin.JointModelRZ() if turns else pin.JointModelPZ()
        parent = model.addJoint(parent, joint, pin.SE3(fixed[k]), link.name)
        body = moved(link.inertia, link.T_joint_link)
        inertia = pin.Inertia(body.mass, body.com, body.tensor)
        model.appendBodyToJoint(parent, inertia, pin.SE3.Identity())
    frame = pin.Frame("tool", parent, 0, pin.SE3(fixed[-1]), pin.FrameType.OP_FRAME)
    return model, model.addFrame(frame)


def test_pinocchio_agrees(arms):
    pin = pytest.importorskip("pinocchio", reason="Pinocchio is not installed (pip install pin)")
    for seed, arm in enumerate(arms):
        model, tool = pinocchio_model(pin, arm)
        data = model.createData()
        q, qd, qdd = states(arm, seed)
        dynamics = Dynamics(arm)
        agree(dynamics.inverse(q, qd, qdd), pin.rnea(model, data, q, qd, qdd), "inverse dynamics")
        agree(dynamics.gravity_torque(q), pin.computeGeneralizedGravity(model, data, q), "gravity")
        upper = np.triu(pin.crba(model, data, q))
        agree(dynamics.mass_matrix(q), upper + np.triu(upper, 1).T, "mass matrix")
        C = pin.computeCoriolisMatrix(model, data, q, qd)
        agree(dynamics.coriolis_torque(q, qd), C @ qd, "Coriolis torque")
        pin.computeJointJacobiansTimeVariation(model, data, q, qd)
        pin.framesForwardKinematics(model, data, q)
        for frame, reference in (
            ("base", pin.ReferenceFrame.LOCAL_WORLD_ALIGNED),
            ("tool", pin.ReferenceFrame.LOCAL),
        ):
            J = pin.getFrameJacobian(model, data, tool, reference)
            agree(arm.jacobian(q, frame=frame), J, f"Jacobian in {frame}")
        agree(arm.fk(q), data.oMf[tool].homogeneous, "pose")
        tau = dynamics.inverse(q, qd, qdd)
        M = dynamics.mass_matrix(q)
        accelerations = dynamics.forward(q, qd, tau)
        np.testing.assert_allclose(M @ (accelerations - qdd), 0, atol=1e-11 * np.abs(tau).max())
