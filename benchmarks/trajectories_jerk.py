"""The quickest law of a path within velocity, acceleration and jerk limits, beside copp's TOPP3.

The path is a quintic B-spline through eight random points of seven joints, the limits are the
Panda's with jerks of ten times its accelerations. Times are of the processor, medians of several
rounds. T/T* is the duration over that of a law on a very fine grid, after it was slowed until it
breaks no limit. No peer takes torques together with jerk: they are beside the quickest law without
a limit of jerk, which nothing can beat. Run it on one core, for example
``taskset -c 1 python benchmarks/trajectories_jerk.py``.
"""

import datetime
import os
import platform
import statistics
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from kinematics_forward import imported, processor
from trajectories_timing import TORQUES, ur5_size, way

from splinearm.curves.interpolation import interpolate
from splinearm.joints import JointKind, JointLimits
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.limit import MotionLimits
from splinearm.trajectories.section import Section
from splinearm.trajectories.smooth_law import SmoothLaw
from splinearm.trajectories.smooth_timing import quickest_smooth
from splinearm.trajectories.timing import quickest

N = 7
VELOCITY = np.array([2.175] * 4 + [2.61] * 3)
ACCELERATION = np.array([15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0])
LIMITS = JointLimits(
    names=tuple(f"joint{i}" for i in range(N)),
    kinds=(JointKind.REVOLUTE,) * N,
    q_min=np.full(N, -np.inf),
    q_max=np.full(N, np.inf),
    qd_max=VELOCITY,
    qdd_max=ACCELERATION,
    qddd_max=10.0 * ACCELERATION,
)
PATHS, ROUNDS, FINEST = 5, 15, 6000


def path_of(seed: int) -> JointPath:
    """Give a path of seven joints."""
    points = np.random.default_rng(seed).uniform(-2.0, 2.0, (8, N))
    return JointPath(interpolate(points, degree=5, parameters="uniform"))


def median(call: Callable[[], object], rounds: int) -> float:
    """Give the median time of a call, ms of the processor."""
    times = []
    for _ in range(rounds):
        begun = time.process_time()
        call()
        times.append(time.process_time() - begun)
    return 1e3 * statistics.median(times)


def used(qd: np.ndarray, qdd: np.ndarray, qddd: np.ndarray) -> tuple[float, ...]:
    """Give the largest shares of the limits of velocity, acceleration and jerk."""
    pairs = zip((qd, qdd, qddd), (LIMITS.qd_max, LIMITS.qdd_max, LIMITS.qddd_max), strict=True)
    return tuple(float(np.abs(value / limit).max()) for value, limit in pairs)


def used_by(path: JointPath, law: SmoothLaw, count: int) -> tuple[float, ...]:
    """Give the same of a law at so many times."""
    ts = np.linspace(0.0, law.duration, count)
    section = Section(path, law)
    _, qd, qdd = section.sample(ts)
    return used(qd, qdd, section.jerk(ts))


def slower(use: tuple[float, ...]) -> float:
    """Give by what factor a law must be slowed to break nothing."""
    return max(1.0, use[0], use[1] ** 0.5, use[2] ** (1.0 / 3.0))


def copp_profile(copp: object, path: JointPath, count: int) -> tuple[float, np.ndarray, np.ndarray]:
    """Give duration, x and x'/2 at even nodes by copp's documented recipe, solved once."""
    s = np.linspace(*path.domain, count + 1)
    q, slope, bend = path.sample(s)
    robot = copp.Robot(N, capacity=count + 1)
    robot.append_s(s)
    robot.set_q(q, slope, bend, 0, dddq=path.third(s))
    whole = {"start_idx_s": 0, "length": count + 1}
    robot.add_velocity_limits(VELOCITY, -VELOCITY, **whole)
    robot.add_acceleration_limits(ACCELERATION, -ACCELERATION, **whole)
    robot.add_jerk_limits(10.0 * ACCELERATION, -10.0 * ACCELERATION, **whole)
    second = copp.solver.topp2_ra
    problem = second.Problem(robot.constraints, idx_s_interval=(0, count), a_boundary=(0.0, 0.0))
    a = second.solve(problem, second.Options())
    robot.constraints.amax_substitute(a, 0)
    third = copp.solver.topp3_socp
    profile = third.solve(third.Problem(robot.constraints, a))
    duration, _ = copp.interpolation.s_to_t_topp3(s, profile, 0.0)
    return duration, np.asarray(profile.a), np.asarray(profile.b)


def used_by_profile(path: JointPath, a: np.ndarray, b: np.ndarray) -> tuple[float, ...]:
    """Give what a profile uses, looked at in ten places of all cells but the outer two.

    On a cell d2s/dt2 is linear in s, which is how copp samples its profiles. The outer cells are
    left out: they are copp's stationary ones, on which the jerk of s is even.
    """
    s = np.linspace(*path.domain, len(a))
    h = np.diff(s)[1:-1, None]
    z = h * np.linspace(0.0, 1.0, 11)
    c = np.diff(b)[1:-1, None] / h
    x = np.maximum(a[1:-2, None] + 2.0 * b[1:-2, None] * z + c * z * z, 0.0).ravel()
    u, at = (b[1:-2, None] + c * z).ravel(), (s[1:-2, None] + z).ravel()
    _, slope, bend = path.sample(at)
    v, c, x, u = np.sqrt(x)[:, None], np.repeat(c.ravel(), 11)[:, None], x[:, None], u[:, None]
    jerk = v * (slope * c + 3.0 * bend * u + path.third(at) * x)
    return used(slope * v, slope * u + bend * x, jerk)


def line(name: str, cells: int, ms: list[float], ratio: list[float], use: np.ndarray) -> None:
    """Print a line of the table."""
    peaks = "  ".join(f"{value:9.7f}" for value in use.max(axis=0))
    print(f"{name:22} {cells:6} {statistics.mean(ms):9.2f} {max(ratio):8.4f}   {peaks}")


def main() -> None:
    """Print where and when, then the table."""
    print(f"{datetime.datetime.now(tz=datetime.UTC):%Y-%m-%d %H:%M} UTC, {platform.platform()}")
    print(f"{processor()}, load {os.getloadavg()[0]:.1f}")
    paths = [path_of(seed) for seed in range(PATHS)]
    best = [quickest_smooth(path, LIMITS, cells=FINEST).duration for path in paths]
    print(f"{'':22} {'cells':>6} {'ms':>9} {'T/T*':>8}   peaks of velocity, acceleration, jerk")
    for cells in (100, 200, 1000):
        ms, ratio, use = [], [], []
        for path, shortest in zip(paths, best, strict=True):
            law = quickest_smooth(path, LIMITS, cells=cells)
            ms.append(median(lambda p=path, m=cells: quickest_smooth(p, LIMITS, cells=m), ROUNDS))
            use.append(used_by(path, law, 100_001))
            ratio.append(law.duration * slower(use[-1]) / shortest)
        line("splinearm", cells, ms, ratio, np.array(use))
    with_torques()
    copp = imported("copp_py")
    if copp is None:
        return
    print()
    for cells in (200, 1000):
        ms, ratio, use = [], [], []
        for path, shortest in zip(paths, best, strict=True):
            duration, a, b = copp_profile(copp, path, cells)
            ms.append(median(lambda p=path, m=cells: copp_profile(copp, p, m), 3))
            use.append(used_by_profile(path, a, b))
            ratio.append(duration * slower(use[-1]) / shortest)
        line("copp topp3_socp", cells, ms, ratio, np.array(use))


def with_torques() -> None:
    """Print a table of laws within torques and jerks of an arm of the UR5's size."""
    dynamics, joints = ur5_size()
    joints = replace(joints, qddd_max=10.0 * joints.qdd_max)
    print("\nand torques of an arm of the UR5's size; T/T2 is over the quickest without jerk")
    print(f"{'':22} {'cells':>6} {'ms':>9} {'T/T2':>8}   peaks of velocity ... jerk, torque")
    paths = [way(seed, 6) for seed in range(PATHS)]
    for share in (1.0, 0.6):
        full = share * np.array(TORQUES)
        limits = MotionLimits(joints=replace(joints, torque_max=full), dynamics=dynamics)
        for cells in (200, 1000):
            ms, ratio, use = [], [], []
            for path in paths:
                law = quickest_smooth(path, limits, cells=cells)
                call = partial(quickest_smooth, path, limits, cells=cells)
                ms.append(median(call, ROUNDS))
                ratio.append(law.duration / quickest(path, limits, cells=2000).duration)
                ts = np.linspace(0.0, law.duration, 100_001)
                section = Section(path, law)
                q, qd, qdd = section.sample(ts)
                peaks = (
                    (qd, joints.qd_max),
                    (qdd, joints.qdd_max),
                    (section.jerk(ts), joints.qddd_max),
                    (dynamics.inverse(q, qd, qdd), full),
                )
                use.append([float(np.abs(value / most).max()) for value, most in peaks])
            line(f"splinearm, torque x {share}", cells, ms, ratio, np.array(use))


if __name__ == "__main__":
    main()
