"""What it costs to pause, resume, slow down, hurry and stop a motion on its path.

No other library does this, so there is no peer beside it; the figure wanted is 100 us a call. The
motions are those of ``trajectories_jerk.py``: 7 joints, limits of velocity, acceleration and jerk.
Printed are the calls, what they use of each limit, and how long stops take.
"""

import datetime
import platform
import time

import numpy as np
from kinematics_forward import processor

from splinearm.curves.interpolation import interpolate
from splinearm.joints import JointKind, JointLimits
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.pace import PacedMotion
from splinearm.trajectories.section import Section
from splinearm.trajectories.smooth_timing import quickest_smooth
from splinearm.trajectories.trajectory import JointTrajectory

QD_MAX = np.array([2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61])
QDD_MAX = np.array([15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0])
PERIOD = 0.004


def motion_of(seed: int) -> JointTrajectory:
    """Give a jerk-limited motion through random places."""
    n = len(QD_MAX)
    limits = JointLimits(
        names=tuple(f"joint{i + 1}" for i in range(n)),
        kinds=(JointKind.REVOLUTE,) * n,
        q_min=np.full(n, -np.inf),
        q_max=np.full(n, np.inf),
        qd_max=QD_MAX,
        qdd_max=QDD_MAX,
        qddd_max=10.0 * QDD_MAX,
    )
    points = np.random.default_rng(seed).uniform(-2.0, 2.0, (8, n))
    path = JointPath(interpolate(points, degree=5, parameters="uniform"))
    law = quickest_smooth(path, limits)
    return JointTrajectory((Section(path, law),), path.at(path.domain[0])[0], limits)


def shares(motion: JointTrajectory, qd: np.ndarray, qdd: np.ndarray, jerk: np.ndarray) -> list:
    """Give the largest shares of the limits of velocity, acceleration and jerk."""
    limits = motion.limits
    pairs = ((qd, limits.qd_max), (qdd, limits.qdd_max), (jerk, limits.qddd_max))
    return [float(np.abs(values / most).max()) for values, most in pairs]


def steps(motion: JointTrajectory, seed: int) -> tuple[np.ndarray, list[float]]:
    """Carry a motion out with changes of pace; give the time of each step and the shares used."""
    rng = np.random.default_rng(seed)
    paced, times, found = PacedMotion(motion, PERIOD), [], []
    k = 0
    while not paced.finished:
        if k % 100 == 50:
            paced.ask(float(rng.choice([0.2, 0.5, 1.0, 1.5])) if k < 3000 else 1.0)
        begun = time.perf_counter()
        setpoint = paced.step()
        times.append(time.perf_counter() - begun)
        found.append((setpoint.qd, setpoint.qdd))
        k += 1
    qd, qdd = (np.array(column) for column in zip(*found, strict=True))
    jerk = np.diff(qdd, axis=0) / PERIOD
    return np.array(times), shares(motion, qd, qdd, jerk)


def stops(motion: JointTrajectory) -> tuple[np.ndarray, np.ndarray, list[float]]:
    """Stop from many moments; give the time of each call, of each stop, and the shares used."""
    motion.stop_from(0.5 * motion.duration)  # looks at the motion once
    calls, durations, worst = [], [], [0.0, 0.0, 0.0]
    for t in np.linspace(0.05, 0.95, 60) * motion.duration:
        begun = time.perf_counter()
        stop = motion.stop_from(float(t))
        calls.append(time.perf_counter() - begun)
        durations.append(stop.duration)
        ts = np.linspace(0.0, stop.duration * (1.0 - 1e-9), 4001)
        _, qd, qdd = stop.sample(ts)
        worst = list(np.maximum(worst, shares(motion, qd, qdd, stop.jerk(ts))))
    return np.array(calls), np.array(durations), worst


def main() -> None:
    """Print where and when, then a row a motion."""
    print(f"{datetime.datetime.now(tz=datetime.UTC):%Y-%m-%d %H:%M} UTC, {platform.platform()}")
    print(processor())
    for seed in range(5):
        motion = motion_of(seed)
        times, used = steps(motion, seed)
        calls, durations, stopping = stops(motion)
        print(
            f"path {seed}, {motion.duration:5.2f} s:  a step at a changing pace "
            f"{1e6 * np.median(times):5.1f} us ({1e4 * np.median(times):.2f} of 100 us), "
            f"99 % below {1e6 * np.percentile(times, 99):5.1f}; uses v {used[0]:.6f} "
            f"a {used[1]:.6f} j {used[2]:.6f}"
        )
        print(
            f"{'':16}  a stop {1e6 * np.median(calls):5.0f} us "
            f"({1e4 * np.median(calls):.2f} of 100 us), takes {np.median(durations):.2f} s in the "
            f"median, {durations.max():.2f} s at most; uses v {stopping[0]:.6f} "
            f"a {stopping[1]:.6f} j {stopping[2]:.6f}"
        )


if __name__ == "__main__":
    main()
