"""Limits choose the law, and plans keep all of them together."""

from dataclasses import replace

import numpy as np
import pytest

from splinearm.kinematics.dynamics import Dynamics
from splinearm.kinematics.link import Inertia
from splinearm.trajectories.law_choice import quickest_law
from splinearm.trajectories.leg import straight_path
from splinearm.trajectories.limit import MotionLimits
from splinearm.trajectories.plan import plan
from splinearm.trajectories.smooth_law import SmoothLaw
from splinearm.trajectories.time_law import TimeLaw
from splinearm.trajectories.waypoint import Move, Waypoint


def test_a_limit_of_jerk_makes_the_law_smooth(make_limits):
    limits = make_limits([1.0, 1.0], [2.0, 2.0])
    path = straight_path(np.zeros(2), np.ones(2))
    smooth = replace(limits, qddd_max=np.full(2, 10.0))
    for given in (limits, MotionLimits(joints=limits)):
        assert type(quickest_law(path, given)) is TimeLaw
    for given in (smooth, MotionLimits(joints=smooth)):
        law = quickest_law(path, given)
        assert type(law) is SmoothLaw
        # v / a + a / j + s / v
        assert law.duration == pytest.approx(0.5 + 0.2 + 1.0, rel=1e-12)


@pytest.mark.parametrize("move", [Move.JOINT, Move.BSPLINE])
def test_a_plan_keeps_torques_the_tool_and_jerks_together(move, arm_6, q_6):
    body = Inertia(0.5, np.array([0.02, 0.0, 0.03]), 1e-3 * np.eye(3))
    arm = replace(arm_6, links=tuple(replace(link, inertia=body) for link in arm_6.links))
    joints = replace(
        arm.limits, qddd_max=np.full(6, 100.0), torque_max=[8.0, 8.0, 8.0, 4.0, 3.0, 3.0]
    )
    limits = MotionLimits(joints=joints, dynamics=Dynamics(arm), tool_acceleration=2.0)
    here = arm.fk(q_6)
    if move is Move.JOINT:
        points = [Waypoint(q=q_6 + 0.4 * np.array([1.0, 1.0, -1.0, 0.5, -0.5, 0.3]), move=move)]
    else:
        steps = np.array([[0.05, 0.05, 0.0], [0.1, 0.0, 0.05], [0.05, -0.1, 0.05]])
        points = [Waypoint(position=here[:3, 3] + step, move=move) for step in steps]
    motion = plan(arm, points, q_6, limits=limits).trajectory
    ts = np.linspace(0.0, motion.duration, 5001)
    q, qd, qdd = motion.sample(ts)
    assert (np.abs(motion.jerk(ts)) <= 100.0 * (1.0 + 1e-5)).all()
    torque = limits.dynamics.inverse(q, qd, qdd)
    assert (np.abs(torque) <= joints.torque_max * (1.0 + 1e-5)).all()
    v = np.einsum("mij,mj->mi", arm.jacobian(q), qd)[:, :3]
    change = np.linalg.norm(np.diff(v, axis=0), axis=1) / ts[1]
    assert 1.9 < change.max() <= 2.0 * (1.0 + 1e-4)
