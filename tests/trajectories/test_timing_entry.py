"""The kernels of timing: against plain Python, against rows and programs made in another way."""

import numpy as np
import pytest
from scipy.optimize import linprog

from splinearm.curves.interpolation import interpolate
from splinearm.trajectories import constraint
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.reachability import fastest, frame
from splinearm.trajectories.timing import quickest
from splinearm.trajectories.timing_entry import kernels

KERNELS = """
import numpy as np
from splinearm.curves.interpolation import interpolate
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics import Arm, DHConvention, DHLink, Inertia
from splinearm.kinematics.dynamics import Drives, Dynamics
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.limit import MotionLimits
from splinearm.trajectories.timing import quickest

found = []
for n, degree in ((1, 3), (3, 5), (2, 3)):
    rng = np.random.default_rng(n)
    points = rng.uniform(-2.0, 2.0, (7, n))
    path = JointPath(interpolate(points, degree=degree, parameters="uniform"))
    names = tuple(f"joint{k}" for k in range(n))
    limits = JointLimits(names=names, kinds=(JointKind.REVOLUTE,) * n, q_min=np.full(n, -9.0),
        q_max=np.full(n, 9.0), qd_max=np.full(n, 2.0), qdd_max=np.full(n, 9.0),
        torque_max=np.full(n, 60.0))
    rows = [DHLink(name, a=0.3, alpha=0.5, d=0.1, theta=0.0) for name in names]
    inertias = [Inertia(2.0, np.array([-0.1, 0.0, 0.1]), 0.05 * np.eye(3)) for _ in names]
    arm = Arm.from_dh("arm", rows, DHConvention.STANDARD, limits, inertias=inertias)
    drives = Drives(viscous=np.ones(n), coulomb=np.full(n, 0.3))
    torques = MotionLimits(joints=limits, dynamics=Dynamics(arm, drives=drives),
        no_load_speed=np.full(n, 4.0))
    for what in (limits, torques):
        law = quickest(path, what, cells=30)
        found += [law.s, law.x, law.t]
    law = quickest(path, limits, (0.1, 0.8), ends=(0.02, 0.01), cells=20)
    found += [law.s, law.x, law.t]
"""


def test_compiled_and_plain_kernels_agree(compiled_as_plain):
    compiled_as_plain(KERNELS, 27, rtol=1e-11, atol=1e-13)


def a_path(seed, n, degree, make_limits):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-2.0, 2.0, (degree + 3, n))
    path = JointPath(interpolate(points, degree=degree, parameters="uniform"))
    return path, make_limits(rng.uniform(1.0, 3.0, n), rng.uniform(5.0, 20.0, n))


@pytest.mark.kernel
@pytest.mark.parametrize("degree", [3, 5, 7])
def test_lines_are_the_rows_of_accelerations(degree, make_limits):
    points = np.random.default_rng(degree).uniform(-2, 2, (degree + 3, 3))
    path = JointPath(interpolate(points, degree=degree, parameters="uniform"))
    limits = make_limits([2.0] * 3, [9.0, 5.0, 7.0])
    s = np.unique(np.concatenate((path.breaks, np.linspace(*path.domain, 12))))
    both, _ = frame(path, limits, s)
    rows = constraint.acceleration_rows(path, limits, s)
    half = rows.a.shape[1] // 2
    a, b = rows.a[:, :half], rows.b[:, :half]
    # those are in the order of coefficients, these in that of joints
    d = both.shape[2] // 3
    a, b = (v.reshape(len(v), d, 3).swapaxes(1, 2).reshape(len(v), -1) for v in (a, b))
    assert np.allclose(both[:, 0], -a / b, rtol=1e-9)
    assert np.allclose(both[:, 1], 1.0 / np.abs(b), rtol=1e-9)


@pytest.mark.kernel
@pytest.mark.parametrize("seed", range(3))
def test_a_straight_x_below_the_caps_keeps_all_velocities(seed, make_limits):
    path, limits = a_path(seed, 2, 5, make_limits)
    s = np.unique(np.concatenate((path.breaks, np.linspace(*path.domain, 21))))
    cap = frame(path, limits, s).cap
    for share in np.linspace(0.0, 1.0, 21):
        at = s[:-1] + share * np.diff(s)
        x = cap[:-1] * (1.0 - share) + cap[1:] * share
        _, slope, _ = path.sample(at)
        assert (slope**2 * x[:, None] <= limits.qd_max**2 * (1.0 + 1e-12)).all()


@pytest.mark.kernel
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("last", [0.0, 0.01])
def test_no_profile_is_faster_anywhere(seed, last, make_limits):
    path, limits = a_path(seed, 2, 3, make_limits)
    s = np.unique(np.concatenate((path.breaks, np.linspace(*path.domain, 9))))
    known = frame(path, limits, s)
    x = fastest(known, s, (0.0, np.sqrt(last)))
    rows = constraint.acceleration_rows(path, limits, s)
    cells, k = rows.a.shape
    A = np.zeros((cells, k, cells + 1))
    for i in range(cells):
        A[i, :, i], A[i, :, i + 1] = rows.a[i], rows.b[i]
    bounds = [(0.0, 0.0), *((0.0, c) for c in known.cap[1:-1]), (last, last)]
    # the largest sum is the sum of the largest: allowed profiles form a lattice
    best = linprog(-np.ones(cells + 1), A.reshape(-1, cells + 1), np.ones(cells * k), bounds=bounds)
    assert best.success
    assert x.sum() == pytest.approx(-best.fun, rel=1e-7)


def test_the_same_problem_twice_is_the_same_law_though_memory_is_used_again(make_limits):
    one, limits = a_path(1, 3, 5, make_limits)
    other, _ = a_path(2, 3, 3, make_limits)
    first = quickest(one, limits)
    quickest(other, limits, cells=900)
    again = quickest(one, limits)
    assert (first.x == again.x).all()
    assert kernels() is kernels()
