"""Limits of the tool and of torques in a time law, beside those of the joints."""

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure
from motion import track
from style import BLUE, GREEN, RED, WIDTH, draw_limit, legend_below, save, styled

from splinearm import JointTrajectory, MotionLimits, load_cell
from splinearm.curves import interpolate
from splinearm.kinematics.dynamics import Dynamics
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.section import Section
from splinearm.trajectories.timing import quickest

PLACES = np.array(
    [
        (-1.0, 0.2, -0.2, 0.0, 0.3, 0.0), (-0.4, 0.5, -0.4, 0.4, 0.4, 0.5),
        (0.1, 0.1, 0.1, 0.2, 0.0, 0.0), (0.8, 0.6, -0.3, -0.3, 0.4, 0.4),
    ]
)  # fmt: skip


@styled
def draw() -> Figure:
    """Draw the tool's speed and the share of torques for three sets of limits."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    arm = load_cell("wx250s").arm
    joints = replace(arm.limits, torque_max=0.42 * arm.limits.torque_max)
    dynamics = Dynamics(arm)
    path = JointPath(interpolate(PLACES, degree=5))
    for label, colour, limits in (
        ("joints", RED, joints),
        ("joints, torques", BLUE, MotionLimits(joints=joints, dynamics=dynamics)),
        (
            "joints, tool",
            GREEN,
            MotionLimits(joints=joints, arm=arm, tool_speed=0.4, tool_acceleration=2.0),
        ),
    ):
        law = quickest(path, limits)
        motion = JointTrajectory((Section(path, law),), PLACES[0], joints)
        tool = track(arm, motion, 300)
        left.plot(tool.t, tool.speed * 1e3, color=colour, linewidth=1.3, label=label)
        torque = dynamics.inverse(*motion.sample(tool.t)) / joints.torque_max
        right.plot(tool.t, 100.0 * np.abs(torque).max(axis=1), color=colour, linewidth=1.3)
    left.set(xlabel="t / s", ylabel="speed of the tool / (mm/s)", ylim=(0.0, None))
    draw_limit(left, 400.0, "400 mm/s")
    right.set(xlabel="t / s", ylabel="torque of the worst joint / %", ylim=(0.0, None))
    draw_limit(right, 100.0, "")
    legend_below(left)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
