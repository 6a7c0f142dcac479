"""Arms to test with; all fixtures live a session long, so that hypothesis may use them."""

from collections.abc import Callable
from math import inf, pi

import numpy as np
import pytest

from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics import Arm, DHConvention, DHLink, Pose

# Trossen/Interbotix WidowX-250 6DOF, from interbotix_ros_manipulators 0bb2b0e6d0
# wx250s.urdf.xacro, BSD-3-Clause, Copyright (c) 2023 Trossen Robotics: a, alpha, d, theta
WIDOWX = {
    "waist": (0.0, 0.0, 0.11065, 0.0),
    "shoulder": (0.0, -pi / 2, 0.0, -1.37436249005686),
    "elbow": (0.254902064526751, 0.0, 0.0, -0.196433836738036),
    "forearm_roll": (0.0, -pi / 2, 0.25, 0.0),
    "wrist_angle": (0.0, pi / 2, 0.0, 0.0),
    "wrist_rotate": (0.0, -pi / 2, 0.158575, 0.0),
}
WIDOWX_MIN = (-pi, -1.88495559, -2.14675498, -pi, -1.74532925, -pi)
WIDOWX_MAX = (pi, 1.98967535, 1.60570291, pi, 2.14675498, pi)


def make_limits(names, kinds, q_min, q_max):
    ones = np.ones(len(names))
    return JointLimits(
        names=tuple(names), kinds=tuple(kinds), q_min=q_min, q_max=q_max, qd_max=ones, qdd_max=ones
    )


def make_dh_arm(rows, convention, *, q_min=-inf, q_max=inf, **transforms):
    """Give an arm of DH rows; limits are one number for all joints or one each."""
    names, kinds = [row.name for row in rows], [row.kind for row in rows]
    low, high = (np.broadcast_to(bound, len(rows)) for bound in (q_min, q_max))
    limits = make_limits(names, kinds, low, high)
    return Arm.from_dh("test arm", rows, convention, limits, **transforms)


def random_pose(rng):
    quat = rng.normal(size=4)
    return Pose(rng.uniform(-0.3, 0.3, 3), quat / np.linalg.norm(quat)).matrix()


def make_random_arm(seed, n, convention, *, slides=True):
    """Give an arm of n joints with random rows, tool and base, and limits of about a turn."""
    rng = np.random.default_rng(seed)
    rows = []
    for i in range(n):
        slide = slides and rng.random() < 0.3
        kind = JointKind.PRISMATIC if slide else JointKind.REVOLUTE
        a, d = rng.uniform(-0.4, 0.4, 2)
        alpha = rng.choice([-pi / 2, 0.0, pi / 2, rng.uniform(-pi, pi)])
        rows.append(DHLink(f"joint{i + 1}", a, alpha, d, rng.uniform(-pi, pi), kind))
    sliding = np.array([row.kind is JointKind.PRISMATIC for row in rows])
    room = np.where(sliding, rng.uniform(0.2, 0.5, n), rng.uniform(1.0, 3.0, n))
    return make_dh_arm(
        rows,
        convention,
        q_min=-room,
        q_max=room * rng.uniform(0.5, 1.0, n),
        T_base_first=random_pose(rng),
        T_flange_tool=random_pose(rng),
    )


def inside(arm, rng, m=None):
    """Give joint vectors within the limits of an arm, one turn at most."""
    low, high = np.maximum(arm.limits.q_min, -pi), np.minimum(arm.limits.q_max, pi)
    return rng.uniform(low, high, arm.n if m is None else (m, arm.n))


@pytest.fixture(scope="session")
def limits_of() -> Callable[..., JointLimits]:
    return make_limits


@pytest.fixture(scope="session")
def dh_arm() -> Callable[..., Arm]:
    return make_dh_arm


@pytest.fixture(scope="session")
def random_arm() -> Callable[..., Arm]:
    return make_random_arm


@pytest.fixture(scope="session")
def joints_inside() -> Callable[..., np.ndarray]:
    return inside


@pytest.fixture(scope="session")
def widowx() -> Arm:
    """The six-joint WidowX-250 with its limits; its tool looks along x at q = 0."""
    rows = [DHLink(name, *row) for name, row in WIDOWX.items()]
    tool = Pose(np.zeros(3), np.array([0.0, 1.0, 0.0, 1.0]) / np.sqrt(2.0)).matrix()
    return make_dh_arm(
        rows, DHConvention.MODIFIED, q_min=WIDOWX_MIN, q_max=WIDOWX_MAX, T_flange_tool=tool
    )


@pytest.fixture(scope="session")
def planar() -> Arm:
    """A planar arm of 0.3 m and 0.25 m, 60 mm above its base."""
    rows = [
        DHLink("shoulder", 0.3, 0.0, 0.06, 0.0),
        DHLink("elbow", 0.25, 0.0, 0.0, 0.0),
    ]
    return make_dh_arm(rows, DHConvention.STANDARD, q_min=(-2.7, -2.6), q_max=(2.7, 2.6))
