"""How much of its limits a motion uses at moments of it, whatever law it was made by."""

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.differential import jacobian_rate

from .limit import MotionLimits
from .trajectory import JointTrajectory

Rates = dict[str, tuple[FloatArray, FloatArray]]
"""Values and the magnitudes they may have, both of shape (m, n), by quantity."""

_LINEAR, _ANGULAR = slice(0, 3), slice(3, 6)


def joint_rates(trajectory: JointTrajectory, limits: MotionLimits, t: FloatArray) -> Rates:
    """Give velocity, acceleration and, where they are limited, jerk and torque of the joints.

    Args:
        trajectory: The motion.
        limits: What limits it.
        t: Times, shape (m,), s.
    """
    q, qd, qdd = trajectory.sample(t)
    joints = limits.joints
    rates = {"velocity": (qd, joints.qd_max), "acceleration": (qdd, joints.qdd_max)}
    if joints.qddd_max is not None:
        rates["jerk"] = (trajectory.jerk(t), joints.qddd_max)
    if limits.dynamics is not None and joints.torque_max is not None:
        torque = limits.dynamics.inverse(q, qd, qdd)
        rates["torque"] = (torque, _torque_there(limits, joints.torque_max, torque, qd))
    return {
        quantity: (values, np.broadcast_to(most, values.shape))
        for quantity, (values, most) in rates.items()
    }


def tool_shares(
    trajectory: JointTrajectory, limits: MotionLimits, t: FloatArray
) -> dict[str, FloatArray]:
    """Give how much of each limit of the tool is used, shape (m,), by quantity.

    Args:
        trajectory: The motion; it knows where the tool's speed was asked for.
        limits: What limits it.
        t: Times, shape (m,), s.
    """
    shares = {"tool speed": trajectory.tool_share(t)}
    if limits.arm is None or not limits.limits_tool:
        return shares
    twist, change = _tool_motion(limits.arm, *trajectory.sample(t))
    for quantity, rate, rows, most in (
        ("tool speed", twist, _LINEAR, limits.tool_speed),
        ("tool turn rate", twist, _ANGULAR, limits.tool_turn_rate),
        ("tool acceleration", change, _LINEAR, limits.tool_acceleration),
        ("tool turn acceleration", change, _ANGULAR, limits.tool_turn_acceleration),
    ):
        if most is not None:
            used = np.linalg.norm(rate[:, rows], axis=1) / most
            # waypoints may have asked for less speed than that
            shares[quantity] = np.maximum(shares.get(quantity, 0.0), used)
    return shares


def _torque_there(
    limits: MotionLimits, torque_max: FloatArray, torque: FloatArray, qd: FloatArray
) -> FloatArray:
    """Give the torque that is there at each moment: where it drives, that of the motor's line."""
    if limits.no_load_speed is None:
        return torque_max
    line = torque_max * np.maximum(1.0 - np.abs(qd) / limits.no_load_speed, 0.0)
    # on the line itself rounding may leave nothing at all
    left = np.maximum(line, np.finfo(np.float64).tiny)
    there: FloatArray = np.where(torque * qd > 0.0, left, torque_max)
    return there


def _tool_motion(
    arm: Arm, q: FloatArray, qd: FloatArray, qdd: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Give velocity and acceleration of the tool in base, each linear first, shape (m, 6)."""
    J = arm.jacobian(q)
    twist = np.einsum("mij,mj->mi", J, qd)
    change = np.einsum("mij,mj->mi", J, qdd)
    change += np.einsum("mij,mj->mi", jacobian_rate(arm, q, qd), qd)
    return twist, change
