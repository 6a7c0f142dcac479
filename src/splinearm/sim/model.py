"""The MuJoCo model of an arm: bodies, joints, inertias, something to look at, and motors.

Body k is the moved frame of joint k, so that the joint turns about or slides along the z axis of
its own body. Between two bodies stands the constant transform of the kinematics: the model's tool
site is where ``Arm.fk`` says. Gravity pulls along -z of the world. There are no contacts.
"""

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointKind
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.link import Inertia

from .motor import Motor

TOOL_SITE = "tool"
"""Name of the site at the tool frame."""

ROD_DENSITY = 1.0
"""Mass per length of a link whose inertia is not known, kg/m. An estimate: two servos and their
brackets on a 0.25 m link of a hobby arm."""

ROD_RADIUS = 0.02
"""Radius of a link whose inertia is not known, m."""

ROD_LENGTH = 0.04
"""Least length of such a link, m: a joint on the spot of the next is still a servo's body."""

SUPPLY = 1.0
"""Supply of the model's motors: duties are voltages of a 1 V motor."""

OVER_SUPPLY = 2.0
"""Highest supply of a motor over its nominal one."""

_SHOWN_RADIUS = 0.012
_RGBA = (0.35, 0.45, 0.6, 1.0)


def build_spec(arm: Arm, motors: Sequence[Motor], *, timestep: float = 1e-3) -> mujoco.MjSpec:
    """Give the model of an arm as a ``mujoco.MjSpec`` without actuators.

    Args:
        arm: The arm. A link without inertia is taken for a rod; see ``rod_inertia``.
        motors: The motor of each joint; their rotors and friction are part of the joints.
        timestep: Time of one step, s.

    Raises:
        ValueError: If there is not one motor a joint, or the timestep is not above zero.
    """
    if len(motors) != arm.n:
        raise ValueError(f"motors: want {arm.n} of them, one a joint, got {len(motors)}")
    if not timestep > 0.0:
        raise ValueError(f"timestep: want a time above zero, got {timestep}")
    spec = mujoco.MjSpec()
    spec.modelname = arm.name
    spec.compiler.degree = False
    spec.option.timestep = timestep
    spec.option.gravity = (0.0, 0.0, -9.81)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    body = spec.worldbody.add_body(name="base", **_placed(arm.T_world_base))
    _show(body, arm.packed.fixed[0][:3, 3])
    for k, motor in enumerate(motors):
        body = _add_link(body, arm, k, motor)
    body.add_site(name=TOOL_SITE, **_placed(arm.packed.fixed[-1]))
    return spec


def add_servos(
    spec: mujoco.MjSpec,
    joint_names: Sequence[str],
    motors: Sequence[Motor],
    gains: Sequence[tuple[float, float]],
) -> None:
    """Add a position servo to each joint; its inputs are position, velocity and torque.

    The servo asks for ``kp (q_wanted - q) + kd (qd_wanted - qd) + torque`` and gets it as long as
    that lies on this side of the motor's line at full duty; beyond it gets what the line gives.

    Args:
        spec: The model.
        joint_names: The joints.
        motors: The motor of each.
        gains: kp (N m/rad) and kd (N m s/rad) of each.
    """
    inputs = mujoco.mjtCtrlInput
    for name, motor, (kp, kd) in zip(joint_names, motors, gains, strict=True):
        actuator = _add_actuator(spec, name, name)
        actuator.set_to_dcmotor(
            **_line(motor),
            controller=(kp, 0.0, kd, 0.0, 0.0, SUPPLY),
            ctrlspec=inputs.mjINPUT_POS | inputs.mjINPUT_VEL | inputs.mjINPUT_FF,
        )


def add_duty_motor(spec: mujoco.MjSpec, name: str, joint: str, motor: Motor, group: int) -> None:
    """Add a motor that is driven by its duty to a joint: -1..1 at the nominal supply.

    Args:
        spec: The model.
        name: What the actuator is called.
        joint: The joint that it drives; others may drive it too.
        motor: The motor.
        group: Its actuator group, by which it can be cut off.
    """
    actuator = _add_actuator(spec, name, joint)
    actuator.set_to_dcmotor(**_line(motor))
    actuator.ctrllimited = True
    actuator.ctrlrange = (-OVER_SUPPLY * SUPPLY, OVER_SUPPLY * SUPPLY)
    actuator.group = group


def compile_model(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """Give the ``mujoco.MjModel`` of a spec.

    Raises:
        ValueError: If MuJoCo refuses it, as it does inertias that no body can have.
    """
    try:
        return spec.compile()
    except ValueError as error:
        raise ValueError(f"arm {spec.modelname!r}: MuJoCo refuses its model: {error}") from error


def rod_inertia(p_joint_end: FloatArray) -> Inertia:
    """Give the inertia of a link of which only the ends are known: a solid round rod between them.

    Args:
        p_joint_end: Where the link ends in its joint's frame, shape (3,), m.
    """
    length = float(np.linalg.norm(p_joint_end))
    along = p_joint_end / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    body = max(length, ROD_LENGTH)
    mass = ROD_DENSITY * body
    # solid cylinder about its centre: m r^2 / 2 along, m (3 r^2 + l^2) / 12 across
    axial = mass * ROD_RADIUS**2 / 2.0
    across = mass * (3.0 * ROD_RADIUS**2 + body**2) / 12.0
    tensor = across * np.eye(3) + (axial - across) * np.outer(along, along)
    return Inertia(mass, p_joint_end / 2.0, tensor)


def _add_link(parent: mujoco.MjsBody, arm: Arm, k: int, motor: Motor) -> mujoco.MjsBody:
    """Add the body of joint k, its joint and its looks."""
    link = arm.links[k]
    turns = link.kind is JointKind.REVOLUTE
    body = parent.add_body(name=link.name, **_placed(arm.packed.fixed[k]))
    body.add_joint(
        name=link.name,
        type=mujoco.mjtJoint.mjJNT_HINGE if turns else mujoco.mjtJoint.mjJNT_SLIDE,
        axis=(0.0, 0.0, 1.0),
        armature=motor.armature,
        frictionloss=motor.friction,
        **_range(arm, k),
    )
    p_joint_end = arm.packed.fixed[k + 1][:3, 3]
    _weigh(body, _joint_inertia(arm, k, p_joint_end))
    _show(body, p_joint_end)
    return body


def _range(arm: Arm, k: int) -> dict[str, Any]:
    """Give a joint's stops; MuJoCo knows none on one side only, so far away stands for nowhere."""
    low, high = float(arm.limits.q_min[k]), float(arm.limits.q_max[k])
    if np.isinf(low) and np.isinf(high):
        return {"limited": mujoco.mjtLimited.mjLIMITED_FALSE}
    return {
        "limited": mujoco.mjtLimited.mjLIMITED_TRUE,
        "range": (max(low, -1e6), min(high, 1e6)),
    }


def _joint_inertia(arm: Arm, k: int, p_joint_end: FloatArray) -> Inertia:
    """Give the inertia of link k in its joint's frame."""
    link = arm.links[k]
    if link.inertia is None:
        return rod_inertia(p_joint_end)
    R, p = link.T_joint_link[:3, :3], link.T_joint_link[:3, 3]
    tensor = R @ link.inertia.tensor @ R.T
    return Inertia(link.inertia.mass, R @ link.inertia.com + p, (tensor + tensor.T) / 2.0)


def _weigh(body: mujoco.MjsBody, inertia: Inertia) -> None:
    """Give a body its mass and inertia."""
    tensor = inertia.tensor
    body.explicitinertial = True
    body.mass = inertia.mass
    body.ipos = inertia.com
    body.fullinertia = (*np.diag(tensor), tensor[0, 1], tensor[0, 2], tensor[1, 2])


def _show(body: mujoco.MjsBody, p_body_end: FloatArray) -> None:
    """Draw a capsule from a body's origin to where the next begins, a ball if that is one spot."""
    looks: dict[str, Any] = {"contype": 0, "conaffinity": 0, "mass": 0.0, "rgba": _RGBA}
    if np.linalg.norm(p_body_end) < _SHOWN_RADIUS:
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=(_SHOWN_RADIUS, 0, 0), **looks)
        return
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CAPSULE,
        size=(_SHOWN_RADIUS, 0, 0),
        fromto=(0.0, 0.0, 0.0, *p_body_end),
        **looks,
    )


def _add_actuator(spec: mujoco.MjSpec, name: str, joint: str) -> mujoco.MjsActuator:
    return spec.add_actuator(name=name, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)


def _line(motor: Motor) -> dict[str, Any]:
    """Give the arguments by which MuJoCo knows a motor's line."""
    return {
        "motorconst": (0.0, 0.0),
        "resistance": 0.0,
        "nominal": (SUPPLY, motor.stall_torque, motor.no_load_speed),
    }


def _placed(T: FloatArray) -> dict[str, Any]:
    """Give a pose as MuJoCo takes it."""
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, np.ascontiguousarray(T[:3, :3]).ravel())
    return {"pos": T[:3, 3], "quat": quat}
