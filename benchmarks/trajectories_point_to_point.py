"""Quickest motions from state to state beside ruckig, and through waypoints.

Run it on one core, for example ``taskset -c 1 python benchmarks/trajectories_point_to_point.py``.
Each figure is the best of several repeats over many random tasks of seven joints; what counts is
the ratio within one run. The peer is left out, with its reason, where it is not installed.
"""

import datetime
import os
import platform
import time
from itertools import pairwise

import numpy as np
from kinematics_forward import imported, processor, shortest

from splinearm.joints import JointKind, JointLimits, JointSetpoint
from splinearm.trajectories.point_to_point import (
    ROWS,
    Synchronisation,
    compiled_motion,
    limit_rows,
    point_to_point,
    state_rows,
)
from splinearm.trajectories.through import through

JOINTS = 7
TASKS = 200
KINDS = ("rest to rest", "moving start", "moving start and goal", "start beyond limits")


def draw(rng: np.random.Generator, kind: str) -> tuple[JointLimits, JointSetpoint, JointSetpoint]:
    """Give random limits and two states from which they can be kept."""
    n = JOINTS
    limits = JointLimits(
        names=tuple(f"joint{i}" for i in range(n)),
        kinds=(JointKind.REVOLUTE,) * n,
        q_min=np.full(n, -np.inf),
        q_max=np.full(n, np.inf),
        qd_max=rng.uniform(0.5, 3, n),
        qdd_max=rng.uniform(0.5, 10, n),
        qddd_max=rng.uniform(1, 100, n),
    )

    def state(share: float) -> JointSetpoint:
        most = np.minimum(limits.qdd_max, 0.999 * np.sqrt(2 * limits.qd_max * limits.qddd_max))
        qdd = rng.uniform(-1, 1, n) * most
        qd = rng.uniform(-1, 1, n) * (limits.qd_max - qdd**2 / (2 * limits.qddd_max))
        return JointSetpoint(t=0.0, q=rng.normal(size=n), qd=share * qd, qdd=share * qdd)

    start = 0.0 if kind == "rest to rest" else 1.5 if kind == "start beyond limits" else 1.0
    return limits, state(start), state(1.0 if kind == "moving start and goal" else 0.0)


def peer_tasks(ruckig: object, tasks: list) -> list:
    """Give the same tasks as the peer takes them."""
    found = []
    for limits, start, goal in tasks:
        one = ruckig.InputParameter(JOINTS)
        one.current_position, one.current_velocity, one.current_acceleration = (
            start.q.tolist(),
            start.qd.tolist(),
            start.qdd.tolist(),
        )
        one.target_position, one.target_velocity, one.target_acceleration = (
            goal.q.tolist(),
            goal.qd.tolist(),
            goal.qdd.tolist(),
        )
        one.max_velocity, one.max_acceleration, one.max_jerk = (
            limits.qd_max.tolist(),
            limits.qdd_max.tolist(),
            limits.qddd_max.tolist(),
        )
        found.append(one)
    return found


def compare(kind: str, ruckig: object | None) -> None:
    """Print what one calculation takes, in us, and how durations differ."""
    rng = np.random.default_rng(KINDS.index(kind))
    tasks = [draw(rng, kind) for _ in range(TASKS)]
    rows = [
        (state_rows(start, JOINTS, ""), state_rows(goal, JOINTS, ""), limit_rows(limits))
        for limits, start, goal in tasks
    ]
    motion = compiled_motion()
    request, report = np.array([np.nan, 1.0]), np.empty(1 + JOINTS)
    phases = np.empty((JOINTS, ROWS, 5))

    def ours() -> None:
        for start, goal, limits in rows:
            motion(start, goal, limits, request, phases, report)

    def door() -> None:
        for limits, start, goal in tasks:
            point_to_point(limits, start, goal)

    if ruckig is None:
        kernel, whole = (t / TASKS * 1e6 for t in shortest(ours, door, number=1, rounds=40))
        print(f"{kind:24s} {kernel:8.2f} {whole:8.1f}")
        return
    otg, there = ruckig.Ruckig(JOINTS), ruckig.Trajectory(JOINTS)
    inputs = peer_tasks(ruckig, tasks)

    def theirs() -> None:
        for one in inputs:
            otg.calculate(one, there)

    times = shortest(ours, door, theirs, number=1, rounds=40)
    kernel, whole, peer = (t / TASKS * 1e6 for t in times)
    worst = 0.0
    for one, task in zip(inputs, tasks, strict=True):
        otg.calculate(one, there)
        worst = max(worst, abs(there.duration - point_to_point(*task).duration))
    figures = f"{kernel:8.2f} {whole:8.1f} {peer:8.2f} {kernel / peer:8.2f} {worst:12.1e}"
    print(f"{kind:24s} {figures}")


def waypoints() -> None:
    """Print what motions through waypoints take and save; the peer needs its service for them."""
    print("\nthrough waypoints, 7 joints        ms   of the duration with stops")
    for count in (1, 2, 5, 10):
        spent, share = [], []
        for seed in range(10):
            rng = np.random.default_rng(seed)
            limits, _, _ = draw(rng, "rest to rest")
            Q = rng.uniform(-2, 2, (count + 2, JOINTS))
            began = time.perf_counter()
            profile, _ = through(limits, Q)
            spent.append(time.perf_counter() - began)
            stops = sum(point_to_point(limits, *pair).duration for pair in pairwise(Q))
            share.append(profile.duration / stops)
        print(f"{count:3d} on the way {np.median(spent) * 1e3:22.2f} {np.mean(share):12.3f}")


def main() -> None:
    """Print the table."""
    ruckig = imported("ruckig")
    print(f"{datetime.datetime.now(datetime.UTC):%Y-%m-%d}, {processor()}, {platform.platform()}")
    print(f"one of {os.cpu_count()} cores; {TASKS} random tasks of {JOINTS} joints, us each")
    print(f"{'':24s} {'kernel':>8s} {'door':>8s} {'ruckig':>8s} {'ratio':>8s} {'durations':>12s}")
    for kind in KINDS:
        compare(kind, ruckig)
    limits, start, goal = draw(np.random.default_rng(9), "rest to rest")
    profile = point_to_point(limits, start, goal)
    ts = np.linspace(0.0, profile.duration, 100_000)

    def straight() -> None:
        point_to_point(limits, start, goal, synchronisation=Synchronisation.PHASE)

    line, one = shortest(straight, lambda: profile.at(0.4), number=100, rounds=20)
    (many,) = shortest(lambda: profile.sample(ts), number=1, rounds=20)
    print(f"\nstraight line, door {line * 1e6:.1f} us; one setpoint {one * 1e6:.1f} us;", end=" ")
    print(f"100 000 samples {many * 1e3:.1f} ms")
    waypoints()


if __name__ == "__main__":
    main()
