"""Numeric inverse kinematics against the C++ `ik_LM` of Robotics Toolbox, in one run.

Every target is the tool of joint positions drawn evenly within the limits. An answer is right if it
is within 1e-4 m and 1e-4 rad, by forward kinematics in numpy, and within the limits. Times are
those of the processor, so that others on the machine count little. Run it on one core:
``taskset -c 1 python benchmarks/kinematics_ik.py [targets per arm]``.
"""

import datetime
import platform
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics import Arm, DHConvention, DHLink, Pose, quaternion, search, solver
from splinearm.kinematics.batch_search import search_batch

H = np.pi / 2
# a, alpha, d, theta of each row, and limits, rad
ARMS = {
    "Puma 560": (
        DHConvention.STANDARD,
        [(0, H, 0.6718, 0), (0.4318, 0, 0, 0), (0.0203, -H, 0.15005, 0), (0, H, 0.4318, 0),
         (0, -H, 0, 0), (0, 0, 0, 0)],
        np.radians([-160, -110, -135, -266, -100, -266]),
        np.radians([160, 110, 135, 266, 100, 266]),
    ),
    "Panda": (
        DHConvention.MODIFIED,
        [(0, 0, 0.333, 0), (0, -H, 0, 0), (0, H, 0.316, 0), (0.0825, H, 0, 0),
         (-0.0825, -H, 0.384, 0), (0, H, 0, 0), (0.088, H, 0.107, 0)],
        np.array([-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973]),
        np.array([2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973]),
    ),
    "UR5": (
        DHConvention.STANDARD,
        [(0, H, 0.089159, 0), (-0.425, 0, 0, 0), (-0.39225, 0, 0, 0), (0, H, 0.10915, 0),
         (0, -H, 0.09465, 0), (0, 0, 0.0823, 0)],
        np.full(6, -np.pi),
        np.full(6, np.pi),
    ),
    "WidowX-250": (
        DHConvention.MODIFIED,
        [(0, 0, 0.11065, 0), (0, -H, 0, -1.37436249005686),
         (0.254902064526751, 0, 0, -0.196433836738036), (0, -H, 0.25, 0), (0, H, 0, 0),
         (0, -H, 0.158575, 0)],
        np.array([-np.pi, -1.88495559, -2.14675498, -np.pi, -1.74532925, -np.pi]),
        np.array([np.pi, 1.98967535, 1.60570291, np.pi, 2.14675498, np.pi]),
    ),
}  # fmt: skip


def make(name: str) -> Arm:
    """Give one of the arms."""
    convention, table, low, high = ARMS[name]
    rows = [DHLink(f"j{i}", *row) for i, row in enumerate(table, 1)]
    ones = np.ones(len(rows))
    limits = JointLimits(
        names=tuple(row.name for row in rows),
        kinds=(JointKind.REVOLUTE,) * len(rows),
        q_min=low,
        q_max=high,
        qd_max=ones,
        qdd_max=ones,
    )
    return Arm.from_dh(name, rows, convention, limits)


def toolbox(name: str) -> Any:  # noqa: ANN401 - of a library without types
    """Give the same arm as an elementary transform sequence of Robotics Toolbox."""
    import roboticstoolbox as rtb

    convention, table, low, high = ARMS[name]
    sequence = []
    for i, (a, alpha, d, theta) in enumerate(table):
        turn = [rtb.ET.Rz(theta)] if theta else []
        along = [rtb.ET.tz(d)] if d else []
        across = ([rtb.ET.tx(a)] if a else []), ([rtb.ET.Rx(alpha)] if alpha else [])
        joint = [rtb.ET.Rz(jindex=i)]
        if convention is DHConvention.MODIFIED:
            sequence += [*across[1], *across[0], *turn, *joint, *along]
        else:
            sequence += [*joint, *turn, *along, *across[0], *across[1]]
    ets = rtb.ETS(sequence)
    ets.qlim = np.array([low, high])
    return ets


def timed(ask: Callable[[int], object], m: int) -> tuple[np.ndarray, list[object]]:
    """Give the time of each call, us, and what each gave."""
    times, answers = np.empty(m), []
    for i in range(m):
        begin = time.thread_time()
        answer = ask(i)
        times[i] = time.thread_time() - begin
        answers.append(answer)
    return times * 1e6, answers


def right(arm: Arm, T: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Say which answers are right: place, direction and limits."""
    known = np.isfinite(q).all(axis=1)
    found = arm.fk(np.where(known[:, None], q, 0.0))
    off = np.linalg.norm(found[:, :3, 3] - T[:, :3, 3], axis=1)
    turned = quaternion.angle_between(
        quaternion.from_matrix(found[:, :3, :3]), quaternion.from_matrix(T[:, :3, :3])
    )
    held = ((q >= arm.limits.q_min) & (q <= arm.limits.q_max)).all(axis=1)
    return known & (off < 1e-4) & (turned < 1e-4) & held


def bare(arm: Arm, poses: list[Pose]) -> Callable[[int], object]:
    """Give a call of the kernel with everything prepared, as a loop of one's own would have it."""
    inquiry = solver.inquiry(arm, (1e-6, 1e-6), 200, seeded=False, posed=True)
    q, said = np.empty(arm.n), np.empty(5)
    rests, room = np.empty((inquiry.most, arm.n + 5)), np.empty(inquiry.room)
    of_arm = inquiry.starts, inquiry.tools, solver.how()

    def ask(i: int) -> object:
        pose = poses[i]
        done = inquiry.ask(
            inquiry.bounds, pose.p, pose.quat, inquiry.middle, inquiry.terms, *of_arm,
            rests, room, q, said,
        )  # fmt: skip
        return done and said[0]

    return ask


def row(name: str, times: np.ndarray, good: float, wrong: int, peer: np.ndarray | None) -> None:
    """Print one line of the table."""
    median, p99 = np.median(times), np.quantile(times, 0.99)
    ratios = ""
    if peer is not None:
        ratios = (
            f"{median / np.median(peer):8.2f} {p99 / np.quantile(peer, 0.99):8.2f} "
            f"{times.mean() / peer.mean():8.2f}"
        )
    print(
        f"  {name:30s} {good * 100.0:8.3f} {wrong:6d} {median:9.1f} {p99:9.1f} "
        f"{times.mean():9.1f} {ratios}"
    )


def compare(name: str, m: int) -> None:
    """Print what both say of one arm."""
    arm = make(name)
    low, high = arm.limits.q_min, arm.limits.q_max
    T = arm.fk(np.random.default_rng(7).uniform(low, high, (m, arm.n)))
    peer = None
    print(f"{name}, {m} targets")
    try:
        ets = toolbox(name)
    except ImportError as error:
        print(f"  Robotics Toolbox is not there: {error}")
    else:
        there = ets.fkine(low * 0.3 + high * 0.7).A
        if not np.allclose(there, arm.fk(low * 0.3 + high * 0.7)):
            raise SystemExit(f"{name}: the two models of the arm differ")
        peer, answers = timed(lambda i: ets.ik_LM(T[i], tol=1e-10), m)
        q = np.array([answer.q for answer in answers])
        said = np.array([answer.success for answer in answers])
        good = right(arm, T, q)
        row("rtb ik_LM, tol 1e-10", peer, good.mean(), int((said & ~good).sum()), None)
    poses = [Pose.from_matrix(each) for each in T]
    times, results = timed(lambda i: search(arm, poses[i]), m)
    q = np.array([result.q for result in results])
    said, good = np.array([result.reached for result in results]), right(arm, T, q)
    row("search", times, good.mean(), int((said & ~good).sum()), peer)
    ask = bare(arm, poses)
    ask(0)
    times, results = timed(ask, m)
    row("bare kernel", times, np.mean(results), 0, peer)
    begin = time.thread_time()
    batch = search_batch(arm, T)
    total = time.thread_time() - begin
    good = right(arm, T, batch.q)
    wrong = int((batch.reached & ~good).sum())
    ratio = "" if peer is None else f", {peer.sum() / 1e6 / total:.1f} x the loop of rtb"
    print(
        f"  search_batch: {good.mean() * 100.0:.3f} % right, {wrong} silently wrong, "
        f"{m / total / 1e3:.1f} k targets/s{ratio}"
    )


def main() -> None:
    """Print the tables."""
    m = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    print(datetime.datetime.now(tz=datetime.UTC).isoformat(timespec="seconds"), platform.platform())
    begin = time.thread_time()
    solver.prepare()
    print(f"loading (and compiling, if new) the kernels: {time.thread_time() - begin:.2f} s")
    print(f"  {'':30s} {'right %':>8} {'wrong':>6} {'median us':>9} {'p99 us':>9} {'mean us':>9}"
          f" {'/median':>8} {'/p99':>8} {'/mean':>8}")  # fmt: skip
    for name in ARMS:
        compare(name, m)


if __name__ == "__main__":
    main()
