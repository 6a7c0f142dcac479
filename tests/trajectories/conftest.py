"""Arms, limits and curves that the tests of this room share."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from splinearm.curves.interpolation import interpolate
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics import quaternion
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.dh import DHConvention, DHLink
from splinearm.kinematics.differential import jacobian_rate
from splinearm.kinematics.dynamics import Drives, Dynamics
from splinearm.kinematics.link import Inertia
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.leg import straight_path
from splinearm.trajectories.limit import MotionLimits
from splinearm.trajectories.plan import Plan
from splinearm.trajectories.section import Law, Section
from splinearm.trajectories.timing import quickest
from splinearm.trajectories.trajectory import JointTrajectory


def _limits(qd_max, qdd_max, qddd_max=None, *, q_max=None, names=None) -> JointLimits:
    n = len(qd_max)
    q_max = np.full(n, np.inf) if q_max is None else np.asarray(q_max)
    return JointLimits(
        names=tuple(f"joint{i}" for i in range(n)) if names is None else names,
        kinds=(JointKind.REVOLUTE,) * n,
        q_min=-q_max,
        q_max=q_max,
        qd_max=qd_max,
        qdd_max=qdd_max,
        qddd_max=qddd_max,
    )


@pytest.fixture(scope="session")
def make_limits() -> Callable[..., JointLimits]:
    return _limits


@pytest.fixture(scope="session")
def arm_2r() -> Arm:
    links = [DHLink("shoulder", 0.3, 0.0, 0.0, 0.0), DHLink("elbow", 0.25, 0.0, 0.06, 0.0)]
    names = ("shoulder", "elbow")
    limits = _limits([2.0, 3.0], [8.0, 12.0], q_max=[2.7, 2.6], names=names)
    return Arm.from_dh("2R", links, DHConvention.STANDARD, limits)


@pytest.fixture(scope="session")
def arm_6() -> Arm:
    # Trossen WidowX-250 6DOF, modified DH: alpha, a, d, theta
    rows = [
        (0.0, 0.0, 0.11065, 0.0),
        (-np.pi / 2, 0.0, 0.0, -1.37436249005686),
        (0.0, 0.254902064526751, 0.0, -0.196433836738036),
        (-np.pi / 2, 0.0, 0.25, 0.0),
        (np.pi / 2, 0.0, 0.0, 0.0),
        (-np.pi / 2, 0.0, 0.158575, 0.0),
    ]
    names = ("waist", "shoulder", "elbow", "forearm_roll", "wrist_angle", "wrist_rotate")
    links = [
        DHLink(name, a=a, alpha=alpha, d=d, theta=theta)
        for name, (alpha, a, d, theta) in zip(names, rows, strict=True)
    ]
    limits = JointLimits(
        names=names,
        kinds=(JointKind.REVOLUTE,) * 6,
        q_min=[-3.14, -1.885, -2.147, -3.14, -1.745, -3.14],
        q_max=[3.14, 1.99, 1.606, 3.14, 2.147, 3.14],
        qd_max=[3.14] * 6,
        qdd_max=[10.0] * 6,
    )
    return Arm.from_dh("WX250s", links, DHConvention.MODIFIED, limits)


@pytest.fixture(scope="session")
def loaded_6() -> tuple[Arm, JointLimits]:
    """An arm of the size and weight of a UR5, and limits with torques."""
    # a, alpha, d, mass: Universal Robots, DH parameters of the UR5
    rows = [
        (0.0, np.pi / 2, 0.089159, 3.7),
        (-0.425, 0.0, 0.0, 8.393),
        (-0.39225, 0.0, 0.0, 2.275),
        (0.0, np.pi / 2, 0.10915, 1.219),
        (0.0, -np.pi / 2, 0.09465, 1.219),
        (0.0, 0.0, 0.0823, 0.1879),
    ]
    links = [
        DHLink(f"joint{i}", a=a, alpha=b, d=d, theta=0.0) for i, (a, b, d, _) in enumerate(rows)
    ]
    inertias = [
        Inertia(m, np.array([-0.5 * a, 0.0, -0.5 * d]), m * (0.01 + a * a / 12.0) * np.eye(3))
        for a, _, d, m in rows
    ]
    limits = _limits([3.15] * 6, [20.0] * 6)
    arm = Arm.from_dh("UR5 size", links, DHConvention.STANDARD, limits, inertias=inertias)
    return arm, replace(limits, torque_max=[150.0, 150.0, 150.0, 28.0, 28.0, 28.0])


@pytest.fixture(scope="session")
def limits_2r() -> MotionLimits:
    """Limits of a small arm with masses, friction and motors whose torque falls with speed."""
    joints = replace(_limits([3.0, 3.0], [20.0, 20.0]), torque_max=[18.0, 8.0])
    links = [DHLink(f"joint{i}", a=0.4, alpha=1.0, d=0.0, theta=0.0) for i in range(2)]
    bodies = [Inertia(1.5, np.array([-0.2, 0.0, 0.0]), 0.02 * np.eye(3))] * 2
    arm = Arm.from_dh("2R", links, DHConvention.STANDARD, joints, inertias=bodies)
    drives = Drives(viscous=np.full(2, 0.5), coulomb=np.full(2, 0.2))
    dynamics = Dynamics(arm, drives=drives)
    return MotionLimits(joints=joints, dynamics=dynamics, no_load_speed=np.full(2, 5.0))


class MotorLine(NamedTuple):
    """One joint about a vertical axis whose motor's torque falls with its speed."""

    limits: MotionLimits
    way: float
    steady: float
    """The speed at which the motor's torque is that of friction, rad/s."""
    duration: float
    """How long the way takes at the least, s."""


@pytest.fixture(scope="session")
def motor_line() -> MotorLine:
    # torque full (1 - qd / qd0) = inertia qdd + viscous qd
    full, no_load, inertia, viscous, way = 10.0, 4.0, 2.0, 1.0, 40.0
    joints = replace(_limits([100.0], [1e3]), torque_max=[full])
    body = Inertia(1.0, np.zeros(3), np.diag([1.0, 1.0, inertia]))
    links = [DHLink("joint0", a=0.0, alpha=0.0, d=0.0, theta=0.0)]
    arm = Arm.from_dh("1R", links, DHConvention.STANDARD, joints, inertias=[body])
    dynamics = Dynamics(arm, drives=Drives(viscous=np.array([viscous])))
    limits = MotionLimits(joints=joints, dynamics=dynamics, no_load_speed=np.array([no_load]))
    # it speeds up as 1 - exp(-t / tau) and brakes with friction's help
    steady = full / (full / no_load + viscous)
    tau = inertia / (full / no_load + viscous)
    braking = inertia / viscous * np.log1p(viscous * steady / full)
    braked = inertia / viscous * (steady - full / viscous * np.log1p(viscous * steady / full))
    return MotorLine(limits, way, steady, tau + braking + (way - braked) / steady)


@pytest.fixture(scope="session")
def limit_uses() -> Callable[..., dict[str, float]]:
    """Gives the largest share of each limit that a law uses at many moments, by quantity."""

    def uses(
        path: JointPath, law: Law, limits: JointLimits | MotionLimits, count: int = 10_001
    ) -> dict[str, float]:
        ts = np.linspace(0.0, law.duration, count)
        limits = MotionLimits(joints=limits) if isinstance(limits, JointLimits) else limits
        section, joints = Section(path, law), limits.joints
        q, qd, qdd = section.sample(ts)
        found = {
            "velocity": np.abs(qd) / joints.qd_max,
            "acceleration": np.abs(qdd) / joints.qdd_max,
        }
        if joints.qddd_max is not None:
            found["jerk"] = np.abs(section.jerk(ts)) / joints.qddd_max
        if limits.dynamics is not None:
            torque = limits.dynamics.inverse(q, qd, qdd)
            no_load = np.inf if limits.no_load_speed is None else limits.no_load_speed
            line = np.where(torque * qd > 0.0, np.abs(qd) / no_load, 0.0)
            found["torque"] = np.abs(torque) / joints.torque_max + line
        arm = limits.arm
        if arm is not None:
            J = arm.jacobian(q)
            v = np.einsum("mij,mj->mi", J, qd)
            a = np.einsum("mij,mj->mi", J, qdd)
            a += np.einsum("mij,mj->mi", jacobian_rate(arm, q, qd), qd)
            for name, of in (
                ("tool_speed", v[:, :3]),
                ("tool_turn_rate", v[:, 3:]),
                ("tool_acceleration", a[:, :3]),
                ("tool_turn_acceleration", a[:, 3:]),
            ):
                if (most := getattr(limits, name)) is not None:
                    found[name] = np.linalg.norm(of, axis=1) / most
        return {name: float(share.max()) for name, share in found.items()}

    return uses


@pytest.fixture(scope="session")
def q_2r() -> np.ndarray:
    return np.array([-0.3, 1.4])


@pytest.fixture(scope="session")
def q_6() -> np.ndarray:
    return np.array([0.2, -0.3, 0.4, 0.3, 0.6, 0.1])


@pytest.fixture(scope="session")
def heart() -> np.ndarray:
    """Twelve points of a closed figure in the plane of the 2R arm."""
    a = np.linspace(0.0, 2.0 * np.pi, 13)[:-1]
    x = 16.0 * np.sin(a) ** 3
    y = 13.0 * np.cos(a) - 5.0 * np.cos(2 * a) - 2.0 * np.cos(3 * a) - np.cos(4 * a)
    return np.stack((x, y, 0.0 * a), axis=1) * 0.005 + [0.33, 0.05, 0.06]


@pytest.fixture(scope="session")
def worst_use() -> Callable[[JointTrajectory, int], float]:
    """Gives the largest share of a velocity or acceleration limit at many moments."""

    def use(trajectory: JointTrajectory, count: int) -> float:
        _, qd, qdd = trajectory.sample(np.linspace(0.0, trajectory.duration, count))
        limits = trajectory.limits
        velocity = np.abs(qd) / limits.qd_max
        return float(max(velocity.max(), (np.abs(qdd) / limits.qdd_max).max()))

    return use


@pytest.fixture(scope="session")
def make_motion() -> Callable[..., JointTrajectory]:
    """Gives motions of a curved section, a rest, and a straight section back."""

    def motion(seed: int, dwell: float = 0.0, n: int = 4) -> JointTrajectory:
        rng = np.random.default_rng(seed)
        limits = _limits(rng.uniform(0.5, 3.0, n), rng.uniform(1.0, 15.0, n))
        path = JointPath(interpolate(rng.uniform(-2.0, 2.0, (6, n)), parameters="uniform"))
        back = straight_path(path.at(path.domain[1])[0], path.at(path.domain[0])[0])
        sections = (
            Section(path, quickest(path, limits), dwell),
            Section(back, quickest(back, limits)),
        )
        return JointTrajectory(sections, path.at(path.domain[0])[0], limits)

    return motion


@pytest.fixture(scope="session")
def orientation_differences() -> Callable[..., tuple[np.ndarray, np.ndarray]]:
    """Gives angular velocity and acceleration by differences of sixth order of orientations."""
    # Fornberg, Math. Comp. 51 (1988) 699, tables 1 and 2
    first = np.array((-1 / 60, 3 / 20, -3 / 4, 0.0, 3 / 4, -3 / 20, 1 / 60))
    second = np.array((1 / 90, -3 / 20, 3 / 2, -49 / 18, 3 / 2, -3 / 20, 1 / 90))

    def rates(curve, u: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
        around = np.stack([curve.at(u + k * step).quat for k in range(-3, 4)])
        apart = quaternion.multiply(around, quaternion.conjugate(around[3]))
        vectors = quaternion.log(apart)
        return (
            np.einsum("k,kmi->mi", first, vectors) / step,
            np.einsum("k,kmi->mi", second, vectors) / step**2,
        )

    return rates


@pytest.fixture(scope="session")
def make_chain() -> Callable[..., tuple[np.ndarray, np.ndarray]]:
    """Gives m + 1 rising parameters and m orientations, neighbours so far apart, rad."""

    def make(seed: int, m: int, apart: float) -> tuple[np.ndarray, np.ndarray]:
        rng = np.random.default_rng(seed)
        turns = rng.normal(size=(m, 3))
        turns *= apart / np.linalg.norm(turns, axis=1, keepdims=True)
        quats = [quaternion.random(rng)]
        for turn in turns[1:]:
            quats.append(quaternion.multiply(quats[-1], quaternion.exp(turn)))
        u = np.concatenate(([0.0], np.cumsum(rng.uniform(0.4, 1.2, m))))
        return u, np.array(quats) * rng.choice([-1.0, 1.0], m)[:, None]

    return make


@pytest.fixture(scope="session")
def tool() -> Callable[[Arm, np.ndarray], np.ndarray]:
    """Gives where joints carry the tool."""
    return lambda arm, q: arm.fk(q)[..., :3, 3]


@pytest.fixture(scope="session")
def tool_speed() -> Callable[[Arm, np.ndarray, np.ndarray], np.ndarray]:
    """Gives how fast they carry it."""

    def speed(arm: Arm, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
        return np.linalg.norm(np.einsum("mij,mj->mi", arm.jacobian(q)[:, :3], qd), axis=1)

    return speed


@pytest.fixture(scope="session")
def sampled() -> Callable[..., tuple[np.ndarray, ...]]:
    """Gives times of a plan and the joints' positions, velocities and accelerations then."""

    def sample(made: Plan, count: int = 8001) -> tuple[np.ndarray, ...]:
        ts = np.linspace(0.0, made.trajectory.duration, count)
        return ts, *made.trajectory.sample(ts)

    return sample
