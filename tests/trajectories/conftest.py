"""Arms, limits and curves that the tests of this room share."""

from collections.abc import Callable

import numpy as np
import pytest

from splinearm.curves.interpolation import interpolate
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics import quaternion
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.dh import DHConvention, DHLink
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.leg import straight_path
from splinearm.trajectories.section import Section
from splinearm.trajectories.timing import quickest
from splinearm.trajectories.trajectory import JointTrajectory


def _limits(qd_max, qdd_max, q_max=None, names=None) -> JointLimits:
    n = len(qd_max)
    q_max = np.full(n, np.inf) if q_max is None else np.asarray(q_max)
    return JointLimits(
        names=tuple(f"joint{i}" for i in range(n)) if names is None else names,
        kinds=(JointKind.REVOLUTE,) * n,
        q_min=-q_max,
        q_max=q_max,
        qd_max=qd_max,
        qdd_max=qdd_max,
    )


@pytest.fixture(scope="session")
def make_limits() -> Callable[..., JointLimits]:
    return _limits


@pytest.fixture(scope="session")
def arm_2r() -> Arm:
    links = [DHLink("shoulder", 0.3, 0.0, 0.0, 0.0), DHLink("elbow", 0.25, 0.0, 0.06, 0.0)]
    limits = _limits([2.0, 3.0], [8.0, 12.0], [2.7, 2.6], ("shoulder", "elbow"))
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
