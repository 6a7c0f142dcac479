"""A motion from state to state as a motion along a path, which can be stopped, split and kept."""

import numpy as np

from splinearm.curves.hermite import cubic_spline
from splinearm.errors import TrajectoryError

from .joint_path import JointPath
from .profile import JointProfile
from .section import Section
from .time_law import TimeLaw
from .trajectory import JointTrajectory


def trajectory_of_profile(profile: JointProfile) -> JointTrajectory:
    """Give the same motion as a path whose parameter is the time, run through evenly.

    Between two nodes every joint is a cubic of the time, so that nothing is lost.

    Args:
        profile: What ``point_to_point``, ``retarget`` or ``through`` gave.

    Raises:
        TrajectoryError: If it takes no time and yet changes the velocity, which no path can.
    """
    t = profile.nodes()
    ends = profile.phases[:, [0, -1], :]
    if len(t) == 1:
        if np.abs(ends[:, 0, 2]).max() > 0.0:
            raise TrajectoryError("the motion takes no time and does not rest")
        return JointTrajectory((), profile.q_start, profile.limits)
    q, qd, _ = profile.sample(t)
    q[[0, -1]], qd[[0, -1]] = ends[:, :, 1].T, ends[:, :, 2].T
    path = JointPath(cubic_spline(t, q, qd))
    law = TimeLaw(t[[0, -1]], np.ones(2))
    return JointTrajectory((Section(path, law),), profile.q_start, profile.limits)
