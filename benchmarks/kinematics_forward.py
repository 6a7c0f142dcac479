"""Forward kinematics, Jacobian and inverse dynamics beside Robotics Toolbox and Pinocchio.

Run it on one core, for example ``taskset -c 1 python benchmarks/kinematics_forward.py``. Each
figure is the best of several repeats; what counts is the ratio within one run. A peer that is not
installed is left out, with its reason.
"""

import argparse
import datetime
import importlib
import os
import platform
import timeit
import warnings
from collections.abc import Callable
from math import pi
from types import ModuleType

import numpy as np

from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics import Arm, DHConvention, DHLink, Inertia
from splinearm.kinematics.dynamics import Dynamics

MODELS = {
    # Robotics Toolbox for Python, models.DH.Puma560; Franka Emika's table of the Panda
    "Puma 560": (
        DHConvention.STANDARD,
        [
            (0.0, pi / 2, 0.6718),
            (0.4318, 0.0, 0.0),
            (0.0203, -pi / 2, 0.15005),
            (0.0, pi / 2, 0.4318),
            (0.0, -pi / 2, 0.0),
            (0.0, 0.0, 0.0),
        ],
    ),
    "Panda": (
        DHConvention.MODIFIED,
        [
            (0.0, 0.0, 0.333),
            (0.0, -pi / 2, 0.0),
            (0.0, pi / 2, 0.316),
            (0.0825, pi / 2, 0.0),
            (-0.0825, -pi / 2, 0.384),
            (0.0, pi / 2, 0.0),
            (0.088, pi / 2, 0.0),
        ],
    ),
}


def arm_of(name: str) -> Arm:
    """Give an arm with made-up but possible inertias."""
    convention, table = MODELS[name]
    rng = np.random.default_rng(0)
    rows = [DHLink(f"joint{i + 1}", *row, theta=0.0) for i, row in enumerate(table)]
    n = len(rows)
    inertias = []
    for _ in rows:
        points = rng.uniform(-0.1, 0.1, (6, 3))
        r = points - points.mean(axis=0)
        tensor = 0.3 * ((r * r).sum() * np.eye(3) - r.T @ r)
        inertias.append(Inertia(1.8, points.mean(axis=0), tensor))
    limits = JointLimits(
        names=tuple(row.name for row in rows),
        kinds=(JointKind.REVOLUTE,) * n,
        q_min=np.full(n, -pi),
        q_max=np.full(n, pi),
        qd_max=np.ones(n),
        qdd_max=np.ones(n),
    )
    return Arm.from_dh(name, rows, convention, limits, inertias=inertias)


def imported(name: str) -> ModuleType | None:
    """Give a peer, or say why not."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        print(f"left out: {name} ({error})")
        return None


def shortest(*works: Callable[[], object], number: int, rounds: int) -> list[float]:
    """Give the shortest time of each of some works, s.

    They take turns, so that a machine that is slow for a while is slow for all of them.
    """
    for work in works:
        work()
    times = [[timeit.timeit(work, number=number) for work in works] for _ in range(rounds)]
    return [min(series) / number for series in zip(*times, strict=True)]


def pinocchio_of(pin: ModuleType, arm: Arm) -> tuple[object, object]:
    """Give the arm as Pinocchio has it, joint frames being ours, and the index of its tool."""
    from splinearm.kinematics.body import moved

    model = pin.Model()
    model.gravity.linear = np.array([0.0, 0.0, -9.81])
    fixed, parent = arm.packed.fixed, 0
    for k, link in enumerate(arm.links):
        parent = model.addJoint(parent, pin.JointModelRZ(), pin.SE3(fixed[k]), link.name)
        body = moved(link.inertia, link.T_joint_link)
        inertia = pin.Inertia(body.mass, body.com, body.tensor)
        model.appendBodyToJoint(parent, inertia, pin.SE3.Identity())
    frame = pin.Frame("tool", parent, 0, pin.SE3(fixed[-1]), pin.FrameType.OP_FRAME)
    return model, model.addFrame(frame)


def toolbox_of(rtb: ModuleType, arm: Arm) -> object:
    """Give the arm as Robotics Toolbox has it: its elementary transforms."""
    convention, table = MODELS[arm.name]
    kind = rtb.RevoluteDH if convention is DHConvention.STANDARD else rtb.RevoluteMDH
    return rtb.DHRobot([kind(a=a, alpha=alpha, d=d) for a, alpha, d in table]).ets()


def row(what: str, ours: float, peer: str, theirs: float, want: str) -> None:
    """Print one comparison: ``>=`` of rates, where more is better, ``<=`` of times."""
    ratio, unit = ours / theirs, "M/s" if want[0] == ">" else "us"
    met = ratio >= float(want[2:]) if want[0] == ">" else ratio <= float(want[2:])
    print(
        f"{what:42} {ours:7.2f} {unit:3} {peer:34} {theirs:6.2f} {unit:3} "
        f"{ratio:6.2f}x  want {want:6} {'met' if met else 'NOT MET'}"
    )


def compare_with_toolbox(rtb: ModuleType, arm: Arm, m: int) -> None:
    """Print batches of forward kinematics beside Robotics Toolbox."""
    Q = np.random.default_rng(1).uniform(-3, 3, (m, arm.n))
    poses = np.empty((m, 4, 4))
    ets = toolbox_of(rtb, arm)
    np.testing.assert_allclose(arm.fk(Q[:100]), ets.eval(Q[:100]), atol=1e-12)
    works = (lambda: ets.eval(Q), lambda: arm.fk(Q), lambda: arm.fk(Q, out=poses))
    rates = [m / 1e6 / time for time in shortest(*works, number=1, rounds=9)]
    for way, rate in zip(("", ", out="), rates[1:], strict=True):
        row(f"{arm.name}: {m} FK{way}", rate, "rtb ets.eval", rates[0], ">=20")


def compare_batches(pin: ModuleType, arm: Arm, m: int) -> None:
    """Print batches of Jacobians and inverse dynamics beside Pinocchio."""
    n = arm.n
    Q, Qd, Qdd = np.random.default_rng(1).uniform(-3, 3, (3, m, n))
    dynamics = Dynamics(arm)
    jacobians, torques = np.empty((m, 6, n)), np.empty((m, n))
    model, tool = pinocchio_of(pin, arm)
    data = model.createData()
    aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    few = Q[: m // 20]

    def looped() -> object:
        return [pin.computeFrameJacobian(model, data, q, tool, aligned) for q in few]

    works = (looped, lambda: arm.jacobian(Q), lambda: arm.jacobian(Q, out=jacobians))
    times = shortest(*works, number=1, rounds=15)
    for way, time in zip(("", ", out="), times[1:], strict=True):
        theirs = len(few) / 1e6 / times[0]
        what = f"{arm.name}: {m} Jacobians{way}"
        row(what, m / 1e6 / time, "Pinocchio in a loop", theirs, ">=6")
    if not hasattr(pin, "rneaInParallel"):
        print("left out: pinocchio.rneaInParallel (not in this build of Pinocchio)")
        return
    pool = pin.ModelPool(model, 1)
    columns = [np.asfortranarray(rows.T) for rows in (Q, Qd, Qdd)]
    works = (
        lambda: pin.rneaInParallel(1, pool, *columns),
        lambda: dynamics.inverse(Q, Qd, Qdd),
        lambda: dynamics.inverse(Q, Qd, Qdd, out=torques),
    )
    rates = [m / 1e6 / time for time in shortest(*works, number=1, rounds=9)]
    for way, rate in zip(("", ", out="), rates[1:], strict=True):
        what = f"{arm.name}: {m} inverse dynamics{way}"
        row(what, rate, "Pinocchio rneaInParallel, 1 thread", rates[0], ">=4")


def compare_with_frax(frax: ModuleType, arm: Arm, m: int) -> None:
    """Print batches of Jacobians beside JAX, in portions of a thousand, where it is quickest.

    Its Panda holds a tool of its own, which costs it nothing.
    """
    jax = importlib.import_module("jax")
    Q = np.random.default_rng(1).uniform(-3, 3, (m, arm.n))
    robot = importlib.import_module(f"{frax.__name__}.robots.franka_panda").load_panda()
    theirs = jax.jit(jax.vmap(robot.ee_jacobian))
    few = jax.numpy.asarray(Q[:1000])
    jacobians = np.empty((m, 6, arm.n))
    works = (lambda: theirs(few).block_until_ready(), lambda: arm.jacobian(Q, out=jacobians))
    peer, ours = shortest(*works, number=1, rounds=25)
    kind = f"frax, JAX on {jax.default_backend()}, {few.dtype}"
    row(f"{arm.name}: {m} Jacobians, out=", m / 1e6 / ours, kind, len(few) / 1e6 / peer, ">=6")


def compare_single(pin: ModuleType, arm: Arm) -> None:
    """Print single calls beside Pinocchio: checked, with ``out=``, and bare."""
    q, qd, qdd = np.random.default_rng(1).uniform(-3, 3, (3, arm.n))
    dynamics, bare = Dynamics(arm), arm.bare()
    bare_inverse = dynamics.bare_inverse()
    T, J, tau = np.empty((4, 4)), np.empty((6, arm.n)), np.empty(arm.n)
    model, tool = pinocchio_of(pin, arm)
    data = model.createData()
    aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED

    def pose() -> object:
        pin.framesForwardKinematics(model, data, q)
        return data.oMf[tool].homogeneous

    def quick_pose() -> object:
        pin.forwardKinematics(model, data, q)
        return pin.updateFramePlacement(model, data, tool).homogeneous

    def jacobian() -> object:
        return pin.computeFrameJacobian(model, data, q, tool, aligned)

    def inverse() -> object:
        return pin.rnea(model, data, q, qd, qdd)

    np.testing.assert_allclose(arm.fk(q), pose(), atol=1e-12)
    np.testing.assert_allclose(arm.jacobian(q), jacobian(), atol=1e-12)
    np.testing.assert_allclose(dynamics.inverse(q, qd, qdd), inverse(), atol=1e-11)
    poses = (lambda: arm.fk(q), lambda: arm.fk(q, out=T), lambda: bare.fk(q, T))
    jacobians = (
        lambda: arm.jacobian(q),
        lambda: arm.jacobian(q, out=J),
        lambda: bare.jacobian(q, J),
    )
    torques = (
        lambda: dynamics.inverse(q, qd, qdd),
        lambda: dynamics.inverse(q, qd, qdd, out=tau),
        lambda: bare_inverse(q, qd, qdd, tau),
    )
    for what, ours, peer, theirs, wants in (
        ("FK", poses, "Pinocchio, oMf[i].homogeneous", pose, ("<=1.0", "<=0.5", "<=0.5")),
        ("FK", poses, "Pinocchio, one frame only", quick_pose, ("<=1.0", "<=0.5", "<=0.5")),
        ("Jacobian", jacobians, "Pinocchio", jacobian, ("<=1.3", "<=0.8", "<=0.8")),
        ("inverse dynamics", torques, "Pinocchio", inverse, ("<=1.3", "<=0.8", "<=0.8")),
    ):
        times = [1e6 * time for time in shortest(theirs, *ours, number=1000, rounds=40)]
        for way, mine, want in zip(("checked", "out=", "bare"), times[1:], wants, strict=True):
            row(f"{arm.name}: one {what}, {way}", mine, peer, times[0], want)


def main() -> None:
    """Print where and when, then a table for each arm."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--batch", type=int, default=100_000, help="joint vectors a batch")
    batch = parser.parse_args().batch
    print(f"{datetime.datetime.now(tz=datetime.UTC):%Y-%m-%d %H:%M} UTC, {platform.platform()}")
    print(f"{processor()}, cores {sorted(os.sched_getaffinity(0))}, numpy {np.__version__}")
    os.environ |= {"JAX_ENABLE_X64": "1", "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false"}
    warnings.filterwarnings("ignore", module="frax")  # advice on settings
    rtb, pin, frax = (imported(name) for name in ("roboticstoolbox", "pinocchio", "frax"))
    for name in MODELS:
        arm = arm_of(name).compiled()
        if rtb is not None:
            compare_with_toolbox(rtb, arm, batch)
        if pin is not None:
            compare_batches(pin, arm, batch)
            compare_single(pin, arm)
        if frax is not None and arm.name == "Panda":
            compare_with_frax(frax, arm, batch)


def processor() -> str:
    """Give the name of the processor, where the system tells it."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:  # noqa: PTH123 - not a path of ours
            names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    except OSError:
        return platform.processor()
    return names[0] if names else platform.processor()


if __name__ == "__main__":
    main()
