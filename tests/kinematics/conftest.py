"""Arms to test with; all fixtures live a session long, so that hypothesis may use them."""

from collections.abc import Callable
from itertools import pairwise
from math import inf, pi

import numpy as np
import pytest

from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics import Arm, DHConvention, DHLink, Pose, body
from splinearm.kinematics.link import Link

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


# a, alpha, d, theta and limits in rad: P. Corke and B. Armstrong-Helouvry, A search for consensus
# among model parameters reported for the PUMA 560, ICRA 1994; Universal Robots, DH parameters for
# calculations; Franka, Robot and interface specifications
_HALF = pi / 2
KNOWN = {
    "puma": (
        DHConvention.STANDARD,
        ((0.0, _HALF, 0.6718), (0.4318, 0.0, 0.0), (0.0203, -_HALF, 0.15005),
         (0.0, _HALF, 0.4318), (0.0, -_HALF, 0.0), (0.0, 0.0, 0.0)),
        np.radians((-160.0, -110.0, -135.0, -266.0, -100.0, -266.0)),
        np.radians((160.0, 110.0, 135.0, 266.0, 100.0, 266.0)),
    ),
    "ur5": (
        DHConvention.STANDARD,
        ((0.0, _HALF, 0.089159), (-0.425, 0.0, 0.0), (-0.39225, 0.0, 0.0),
         (0.0, _HALF, 0.10915), (0.0, -_HALF, 0.09465), (0.0, 0.0, 0.0823)),
        -pi,
        pi,
    ),
    "panda": (
        DHConvention.MODIFIED,
        ((0.0, 0.0, 0.333), (0.0, -_HALF, 0.0), (0.0, _HALF, 0.316), (0.0825, _HALF, 0.0),
         (-0.0825, -_HALF, 0.384), (0.0, _HALF, 0.0), (0.088, _HALF, 0.107)),
        (-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973),
        (2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973),
    ),
}  # fmt: skip


def make_known_arm(name):
    """Give one of the arms that solvers are compared on: puma, ur5, panda or widowx."""
    if name == "widowx":
        rows = [DHLink(joint, *row) for joint, row in WIDOWX.items()]
        return make_dh_arm(rows, DHConvention.MODIFIED, q_min=WIDOWX_MIN, q_max=WIDOWX_MAX)
    convention, table, low, high = KNOWN[name]
    rows = [DHLink(f"{name}{i}", a, alpha, d, 0.0) for i, (a, alpha, d) in enumerate(table, 1)]
    return make_dh_arm(rows, convention, q_min=low, q_max=high)


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
def known_arm() -> Callable[[str], Arm]:
    return make_known_arm


@pytest.fixture(scope="session")
def random_arm() -> Callable[..., Arm]:
    return make_random_arm


@pytest.fixture(scope="session")
def joints_inside() -> Callable[..., np.ndarray]:
    return inside


def check_same_arm(arm, wanted, atol=1e-12):
    """The same arm, however it is described: motion, limits, inertias and where it stands."""
    rng = np.random.default_rng(1)
    q = np.concatenate((np.zeros((1, arm.n)), inside(wanted, rng, 6)))
    assert arm.joint_names == wanted.joint_names
    assert arm.limits.kinds == wanted.limits.kinds
    np.testing.assert_allclose(arm.fk(q), wanted.fk(q), rtol=0, atol=atol)
    np.testing.assert_allclose(arm.T_world_base, wanted.T_world_base, rtol=0, atol=atol)
    for name in ("q_min", "q_max", "qd_max", "qdd_max", "qddd_max", "torque_max"):
        have, want = getattr(arm.limits, name), getattr(wanted.limits, name)
        assert (have is None) is (want is None), name
        if want is not None:
            np.testing.assert_allclose(have, want, rtol=1e-15, atol=0, err_msg=name)
    frames, wanted_frames = arm.frames(q), wanted.frames(q)
    for i, (link, like) in enumerate(zip(arm.links, wanted.links, strict=True)):
        assert (link.inertia is None) is (like.inertia is None)
        if like.inertia is None:
            continue
        assert abs(link.inertia.mass - like.inertia.mass) <= atol
        for T, T_like in zip(frames[:, i], wanted_frames[:, i], strict=True):
            have, want = body.moved(link.inertia, T), body.moved(like.inertia, T_like)
            np.testing.assert_allclose(have.com, want.com, rtol=0, atol=atol)
            np.testing.assert_allclose(have.tensor, want.tensor, rtol=0, atol=atol)


@pytest.fixture(scope="session")
def assert_same_arm() -> Callable[..., None]:
    return check_same_arm


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


# a, alpha, d, theta of standard rows; Puma 560 after Corke, Robotics, Vision and Control, 2017;
# UR5 after Universal Robots' table of DH parameters; the others are made up to stand for a class
CLOSED_DH = {
    "puma": [(0, 1, 0.6718, 0), (0.4318, 0, 0, 0), (0.0203, -1, 0.15005, 0), (0, 1, 0.4318, 0),
             (0, -1, 0, 0), (0, 0, 0.1, 0)],
    "industrial": [(0.15, -1, 0.45, 0), (0.6, 0, 0, -1), (0.12, -1, 0, 0), (0, 1, 0.62, 0),
                   (0, -1, 0, 0), (0, 0, 0.1, 2)],
    "ur5": [(0, 1, 0.0892, 0), (-0.425, 0, 0, 0), (-0.39225, 0, 0, 0), (0, 1, 0.10915, 0),
            (0, -1, 0.09465, 0), (0, 0, 0.0823, 0)],
    "oblique wrist": [(0.1, 1, 0.3, 0), (0.4, 0, 0, 0), (0.05, 1, 0.02, 0), (0, 0.6, 0.43, 0.3),
                      (0, -0.8, 0, 0), (0, 0, 0.1, 0.2)],
    "base 12": [(0, 1, 0.3, 0), (0.4, 0.4, 0.1, 0.1), (0.05, 1, 0.12, 0.2), (0, 1, 0.43, 0.3),
                (0, -1, 0, 0), (0, 0, 0.1, 0.2)],
    "base 23": [(0.2, 1, 0.3, 0), (0, -0.4, 0.15, 0.1), (0.3, 1, 0.12, 0.2), (0, 1, 0.43, 0.3),
                (0, -1, 0, 0), (0, 0, 0.1, 0.2)],
    "parallel 12": [(0.3, 0, 0.3, 0), (0.2, -0.4, 0.15, 0.1), (0.03, 1, 0.12, 0.2),
                    (0, 1, 0.43, 0.3), (0, -1, 0, 0), (0, 0, 0.1, 0.2)],
    "quartic": [(0.3, 0.3, 0.3, 0), (0.2, -0.4, 0.15, 0.1), (0.13, 1, 0.12, 0.2),
                (0, 1, 0.43, 0.3), (0, -1, 0, 0), (0, 0, 0.1, 0.2)],
    "meeting wrist": [(0, 1, 0.24, 0), (0.28, 0, 0.03, 0), (0, 1, 0.02, 0), (0, 1, 0.245, 0.1),
                      (0, 1, 0.08, 0), (0, 0, 0.13, 0)],
    "meeting wrist, base 12": [(0, 1, 0.3, 0), (0.4, 0.4, 0.1, 0.1), (0.05, 1, 0.12, 0.2),
                               (0.05, 1, 0.3, 0), (0, -1, 0.08, 0), (0, 0, 0.1, 0)],
    "meeting wrist, oblique": [(0.1, 1, 0.3, 0), (0.4, 0, 0.1, 0.1), (0.05, 1, 0.12, 0.2),
                               (0.05, 0.6, 0.3, 0), (0, -0.8, 0.08, 0), (0, 0, 0.1, 0)],
}  # fmt: skip
"""Arms of six joints, one or two of each class; alpha in right angles."""

# joint axes, points on them and the tool point at q = 0, in m; the makers' models, rounded
CLOSED_AXES = {
    "koch": (
        ((0, 0, -1), (1, 0, 0), (-1, 0, 0), (1, 0, 0), (0, -1, 0)),
        ((0, -0.012, 0.0409), (-0.0209, -0.012, 0.0563), (-0.0144, 0.0028, 0.1646),
         (-0.01435, 0.10328, 0.1673), (-0.00125, 0.14828, 0.1673)),
        (0.00925, 0.21508, 0.16775),
    ),
    "omx_f": (
        ((0, 0, 1), (0, 1, 0), (0, 1, 0), (0, 1, 0), (1, 0, 0)),
        ((-0.01125, 0, 0.034), (-0.01125, 0, 0.0975), (0.03025, 0, 0.21065),
         (0.19225, 0, 0.21065), (0.22095, 0, 0.21065)),
        (0.31288, -0.0016, 0.21065),
    ),
    "rx150": (
        ((0, 0, 1), (0, 1, 0), (0, 1, 0), (0, 1, 0), (1, 0, 0)),
        ((0, 0, 0), (0, 0, 0.10457), (0.05, 0, 0.25457), (0.2, 0, 0.25457), (0.2, 0, 0.25457)),
        (0.35857, 0, 0.25457),
    ),
    "wx200": (
        ((0, 0, 1), (0, 1, 0), (0, 1, 0), (0, 1, 0), (1, 0, 0)),
        ((0, 0, 0), (0, 0, 0.11065), (0.05, 0, 0.31065), (0.25, 0, 0.31065), (0.25, 0, 0.31065)),
        (0.40858, 0, 0.31065),
    ),
    "open_manipulator_x": (
        ((0, 0, 1), (0, 1, 0), (0, 1, 0), (0, 1, 0)),
        ((0.012, 0, 0), (0.012, 0, 0.0595), (0.036, 0, 0.1875), (0.16, 0, 0.1875)),
        (0.286, 0, 0.1875),
    ),
}  # fmt: skip
"""Arms of four and five joints, as shipped."""


def make_axes_arm(axes, points, tip, *, q_min=-inf, q_max=inf):
    """Give an arm of joint axes and points on them at q = 0; all its links are parallel to base."""
    frames = [np.eye(4)]
    for axis, point in zip(axes, points, strict=True):
        z = np.asarray(axis, dtype=float)
        x = np.roll(z, 1)
        T = np.eye(4)
        T[:3, :3] = np.column_stack((x, np.cross(z, x), z))
        T[:3, 3] = point
        frames.append(T)
    links = tuple(
        Link(f"joint{i + 1}", JointKind.REVOLUTE, np.linalg.inv(a) @ b, np.eye(4))
        for i, (a, b) in enumerate(pairwise(frames))
    )
    tool = np.eye(4)
    tool[:3, 3] = tip
    n = len(links)
    limits = make_limits(
        [link.name for link in links],
        [link.kind for link in links],
        np.full(n, q_min),
        np.full(n, q_max),
    )
    return Arm("axes", links, limits, T_flange_tool=np.linalg.inv(frames[-1]) @ tool)


@pytest.fixture(scope="session")
def axes_arm() -> Callable[..., Arm]:
    return make_axes_arm


def make_closed_arms():
    """Give arms without limits that have closed forms, by name."""
    arms = {}
    for name, table in CLOSED_DH.items():
        rows = [
            DHLink(f"joint{i + 1}", a, alpha * pi / 2, d, theta)
            for i, (a, alpha, d, theta) in enumerate(table)
        ]
        arms[name] = make_dh_arm(rows, DHConvention.STANDARD)
    for name, (axes, points, tip) in CLOSED_AXES.items():
        arms[name] = make_axes_arm(axes, points, tip)
    panda = [(0, 0, 0.333), (0, -1, 0), (0, 1, 0.316), (0.0825, 1, 0), (-0.0825, -1, 0.384),
             (0, 1, 0), (0.088, 1, 0.107)]  # fmt: skip
    # Franka Robotics, Robot and interface specifications, modified DH parameters
    rows = [DHLink(f"joint{i + 1}", a, al * pi / 2, d, 0) for i, (a, al, d) in enumerate(panda)]
    arms["panda"] = make_dh_arm(rows, DHConvention.MODIFIED)
    return arms


@pytest.fixture(scope="session")
def closed_arms() -> dict[str, Arm]:
    return make_closed_arms()


@pytest.fixture(scope="session")
def rng_of() -> Callable[[int], np.random.Generator]:
    return np.random.default_rng
