"""Closed-form inverse kinematics beside EAIK (six joints) and geofikpy (Panda, one joint given).

Run it pinned to one core: ``taskset -c 1 python benchmarks/kinematics_closed_form.py``. All peers
are timed in turns in one run and the smallest of the turns counts, so that ratios mean something
on a busy machine. Single calls are the bare ones of each library: a 4x4 matrix in, an array of all
branches out, no limits.
"""

import functools
import platform
import time
from collections.abc import Callable
from datetime import date
from math import pi

import numpy as np

from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics import Arm, DHConvention, DHLink
from splinearm.kinematics.closed_form import ClosedForm, branches

STANDARD = DHConvention.STANDARD
TURNS = 7
POSES = 4000
BATCH = 20_000

# a, alpha in right angles, d; Puma 560 after Corke 2017, UR5 and Panda after their makers
PUMA = ((0, 1, 0.6718), (0.4318, 0, 0), (0.0203, -1, 0.15005), (0, 1, 0.4318), (0, -1, 0),
        (0, 0, 0.1))  # fmt: skip
UR5 = ((0, 1, 0.0892), (-0.425, 0, 0), (-0.39225, 0, 0), (0, 1, 0.10915), (0, -1, 0.09465),
       (0, 0, 0.0823))  # fmt: skip
PANDA = ((0, 0, 0.333), (0, -1, 0), (0, 1, 0.316), (0.0825, 1, 0), (-0.0825, -1, 0.384),
         (0, 1, 0), (0.088, 1, 0.107))  # fmt: skip


def arm_of(name: str, rows: tuple[tuple[float, float, float], ...], how: DHConvention) -> Arm:
    """Give an arm of rows without limits."""
    links = [DHLink(f"joint{i + 1}", a, al * pi / 2, d, 0.0) for i, (a, al, d) in enumerate(rows)]
    n = len(links)
    limits = JointLimits(
        names=tuple(link.name for link in links),
        kinds=(JointKind.REVOLUTE,) * n,
        q_min=np.full(n, -np.inf),
        q_max=np.full(n, np.inf),
        qd_max=np.ones(n),
        qdd_max=np.ones(n),
    )
    return Arm.from_dh(name, links, how, limits)


def race(runs: dict[str, Callable[[], object]], m: int) -> dict[str, float]:
    """Give the best time of each, us a pose, timed in turns."""
    best = dict.fromkeys(runs, float("inf"))
    for run in runs.values():
        run()
    for _ in range(TURNS):
        for name, run in runs.items():
            start = time.perf_counter()
            run()
            best[name] = min(best[name], (time.perf_counter() - start) / m * 1e6)
    return best


def each(call: Callable[..., object], *columns: list[object]) -> Callable[[], None]:
    """Give a run that calls once for every row of the columns."""

    def run() -> None:
        for row in zip(*columns, strict=True):
            call(*row)

    return run


def tell(what: str, best: dict[str, float], peer: str) -> None:
    """Print times and their ratios to a peer."""
    for name, us in best.items():
        ratio = f"{best[peer] / us:6.1f} x" if peer in best else "   -"
        print(f"{what:34s} {name:28s} {us:9.3f} us {1e3 / us:10.1f} k/s {ratio}")


def six_joints(name: str, rows: tuple[tuple[float, float, float], ...]) -> None:
    """Race EAIK on one arm, single and batch."""
    arm = arm_of(name, rows, DHConvention.STANDARD)
    form, seed = ClosedForm.of(arm), np.zeros(6)
    q = np.random.default_rng(0).uniform(-pi, pi, (BATCH, 6))
    T = np.ascontiguousarray(arm.fk(q))
    poses = [np.ascontiguousarray(pose) for pose in T[:POSES]]
    single = {"splinearm": each(form.solve, poses, [seed] * POSES)}
    batch = {"splinearm": lambda: form.solve_batch(T, seed)}
    try:
        from eaik.IK_DH import DhRobot
    except ImportError as error:
        print(f"EAIK is not here: {error}")
    else:
        a, alpha, d = (np.array([float(row[i]) for row in rows]) for i in range(3))
        peer = DhRobot(alpha * pi / 2, a, d)
        single["EAIK"] = each(peer.IK, poses)
        batch["EAIK"] = lambda: peer.IK_batched(T, 1)
    tell(f"{name}: single, all branches", race(single, POSES), "EAIK")
    tell(f"{name}: batch of {BATCH}", race(batch, BATCH), "EAIK")
    checked = {"splinearm, checked, named": each(lambda p: branches(arm, p), poses[:200])}
    tell(f"{name}: single, checked", race(checked, 200), "EAIK")
    found, count = form.solve_batch(T, seed)
    hit = (np.abs(np.sin(0.5 * (found - q[:, None]))).max(axis=2) < 1e-6).any(axis=1).mean()
    there = ~np.isnan(found[..., 0])
    worst = np.abs(arm.fk(found[there]) - np.repeat(T, count.astype(int), axis=0)).max()
    print(f"{name}: own joints found in {100 * hit:.3f} %, worst branch off by {worst:.1e}\n")


def seven_joints() -> None:
    """Race geofikpy on the Panda with its last joint given."""
    arm = arm_of("Panda", PANDA, DHConvention.MODIFIED)
    form, seed = ClosedForm.of(arm, given="joint7"), np.zeros(7)
    q = np.random.default_rng(1).uniform(-2.5, 2.5, (POSES, 7))
    poses, last = [np.ascontiguousarray(T) for T in arm.fk(q)], [float(x) for x in q[:, 6]]
    runs = {"splinearm": each(form.solve, poses, [seed] * POSES, last)}
    try:
        import geofikpy
    except ImportError as error:
        print(f"geofikpy is not here: {error}")
    else:
        hands = [np.asarray(geofikpy.franka_fk(x, "E")) for x in q]
        places = [T[:3, 3].copy() for T in hands]
        turns = [T[:3, :3].ravel() for T in hands]
        runs["geofikpy"] = each(geofikpy.franka_ik_q7, places, turns, last)
        mine = np.mean([len(form.solve(T, seed, x)[0]) for T, x in zip(poses, last, strict=True)])
        theirs = np.mean(
            [geofikpy.franka_ik_q7(p, R, x)[1] for p, R, x in zip(places, turns, last, strict=True)]
        )
        print(f"Panda: branches a pose: splinearm {mine:.2f}, geofikpy {theirs:.2f}")
    tell("Panda: joint 7 given", race(runs, POSES), "geofikpy")


def without_peer() -> None:
    """Time what no peer here solves: any six joints, a Panda's first joint or its swivel given."""
    rng = np.random.default_rng(2)
    rows = rng.uniform((-0.3, -2.0, -0.3), (0.3, 2.0, 0.3), (6, 3))
    arm = arm_of("any", tuple((float(a), float(al), float(d)) for a, al, d in rows), STANDARD)
    panda = arm_of("Panda", PANDA, DHConvention.MODIFIED)
    for what, form in (
        ("six joints of any kind", ClosedForm.of(arm)),
        ("Panda: joint 1 given", ClosedForm.of(panda, given="joint1")),
        ("Panda: swivel given", ClosedForm.of(panda, given="swivel")),
    ):
        n = form.arm.n
        q = rng.uniform(-2.5, 2.5, (300, n))
        q[:, 0] = 0.4
        T = form.arm.fk(q)
        given = (0.4,) if form.takes else ()
        run = functools.partial(form.solve_batch, T, np.zeros(n), *given)
        runs: dict[str, Callable[[], object]] = {"splinearm, batch": run}
        tell(what, race(runs, 300), "none")


if __name__ == "__main__":
    print(f"{date.today()}  {platform.processor() or platform.machine()}  numpy {np.__version__}")
    six_joints("Puma 560", PUMA)
    six_joints("UR5", UR5)
    seven_joints()
    without_peer()
