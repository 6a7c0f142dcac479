"""Motions as rows by time, as ROS and spreadsheets have them, and motions made from such rows."""

from typing import NamedTuple

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.curves.hermite import cubic_spline, quintic_spline
from splinearm.curves.interpolation import EndDerivatives, interpolate
from splinearm.joints import JointLimits

from .joint_path import JointPath
from .section import Section
from .time_law import TimeLaw
from .trajectory import JointTrajectory


class Rows(NamedTuple):
    """A motion at some times."""

    t: FloatArray
    """Times, rising, shape (m,), s."""
    q: FloatArray
    """Positions, shape (m, n), rad or m."""
    qd: FloatArray | None
    """Velocities, shape (m, n); None: not said."""
    qdd: FloatArray | None
    """Accelerations, shape (m, n); None: not said."""


def rows_of(trajectory: JointTrajectory, rate: float) -> Rows:
    """Give a motion at an even rate, its end included.

    Args:
        trajectory: The motion.
        rate: Rows a second, Hz.

    Raises:
        ValueError: If the rate is not above 0.
    """
    if not 0.0 < rate < np.inf:
        raise ValueError(f"rate: want a number above 0 Hz, got {rate}")
    count = int(np.ceil(trajectory.duration * rate - 1e-9))
    t = np.append(np.arange(count) / rate, trajectory.duration)
    return Rows(t, *trajectory.sample(t))


def trajectory_of(
    limits: JointLimits,
    t: ArrayInput,
    q: ArrayInput,
    qd: ArrayInput | None = None,
    qdd: ArrayInput | None = None,
) -> JointTrajectory:
    """Give the motion through rows by time.

    With velocities and accelerations it is quintic between rows (C2), with velocities alone cubic
    (C1); with neither it is the C2 cubic through the positions that begins and ends at rest. These
    are the rules of ``trajectory_msgs/JointTrajectory``, but that positions alone make a curve and
    not a chain of straight lines. Nothing is retimed, and limits are not looked at here: what
    carries the motion out does.

    Args:
        limits: The joints and what they may do.
        t: Times, the first one 0, rising, shape (m,), s; at least two.
        q: Positions, shape (m, n), rad or m.
        qd: Velocities, shape (m, n), or None.
        qdd: Accelerations, shape (m, n), or None; they need velocities.

    Raises:
        ValueError: If the numbers do not fit.
    """
    times = frozen_array(t, (None,), "t")
    shape = (len(times), limits.n)
    positions = frozen_array(q, shape, "q")
    if len(times) < 2 or times[0] != 0.0 or (np.diff(times) <= 0.0).any():
        raise ValueError(f"t: want two or more rising times from 0 on, got {times.tolist()}")
    if qd is None:
        if qdd is not None:
            raise ValueError("qdd: accelerations need velocities beside them")
        rest = EndDerivatives(np.zeros((1, limits.n)), np.zeros((1, limits.n)))
        curve = interpolate(positions, degree=3, parameters=times, ends=rest)
    elif qdd is None:
        curve = cubic_spline(times, positions, frozen_array(qd, shape, "qd"))
    else:
        rates = frozen_array(qd, shape, "qd"), frozen_array(qdd, shape, "qdd")
        curve = quintic_spline(times, (positions, *rates))
    # the path's parameter is the time, and time goes on evenly
    law = TimeLaw(times[[0, -1]], np.ones(2))
    return JointTrajectory((Section(JointPath(curve), law),), positions[0], limits)
