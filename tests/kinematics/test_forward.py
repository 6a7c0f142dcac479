"""Forward kinematics and Jacobian: kernels against numpy, their entries, and how they load."""

import pickle

import numpy as np
import pytest

from splinearm.kinematics import DHConvention, chain, forward
from splinearm.kinematics.packed import pack_kernel

pytestmark = pytest.mark.kernel

STANDARD = DHConvention.STANDARD


@pytest.fixture(scope="module", autouse=True)
def _kernels():
    forward.load()


@pytest.fixture(scope="module")
def arms(random_arm):
    conventions = (DHConvention.STANDARD, DHConvention.MODIFIED)
    return [random_arm(seed, 2 + seed % 7, conventions[seed % 2]) for seed in range(60)]


def test_the_packed_array_holds_the_chain(random_arm):
    arm = random_arm(5, 4, STANDARD)
    packed = pack_kernel(arm.packed)
    np.testing.assert_array_equal(packed, arm.numbers)
    np.testing.assert_array_equal(packed[:, :9].reshape(-1, 3, 3), arm.packed.fixed[:, :3, :3])
    np.testing.assert_array_equal(packed[:, 9:12], arm.packed.fixed[:, :3, 3])
    np.testing.assert_array_equal(packed[:-1, 12], arm.packed.slides)
    assert packed[-1, 12] == 0.0
    assert packed.flags.c_contiguous
    assert packed.flags.writeable


def test_single_calls_are_what_numpy_says(arms, joints_inside):
    rng = np.random.default_rng(0)
    for arm in arms:
        q = joints_inside(arm, rng)
        T, J = chain.fk_and_jacobian(arm.packed, q)
        np.testing.assert_allclose(arm.fk(q), T, rtol=0, atol=1e-14)
        np.testing.assert_allclose(arm.jacobian(q), J, rtol=0, atol=1e-14)


@pytest.mark.parametrize("m", [1, 63, 64, 65, 200])
def test_batches_are_what_numpy_says(arms, joints_inside, m):
    rng = np.random.default_rng(m)
    for arm in arms[:14]:
        q = joints_inside(arm, rng, m)
        for ours, numpys in (
            (arm.fk, chain.fk_batch),
            (arm.frames, chain.frames_batch),
            (arm.jacobian, chain.jacobian_batch),
        ):
            np.testing.assert_allclose(ours(q), numpys(arm.packed, q), rtol=0, atol=2e-14)


def test_a_batch_of_none_is_empty(arms):
    nothing = np.empty((0, arms[0].n))
    assert arms[0].fk(nothing).shape == (0, 4, 4)
    assert arms[0].frames(nothing).shape == (0, arms[0].n, 4, 4)
    assert arms[0].jacobian(nothing).shape == (0, 6, arms[0].n)


def test_leading_axes_stay(arms):
    arm = arms[3]
    q = np.random.default_rng(1).uniform(-1, 1, (2, 3, arm.n))
    assert arm.fk(q).shape == (2, 3, 4, 4)
    np.testing.assert_allclose(arm.frames(q)[1, 2], arm.frames(q[1, 2]), rtol=0, atol=1e-14)
    np.testing.assert_allclose(arm.jacobian(q)[1, 2], arm.jacobian(q[1, 2]), rtol=0, atol=1e-14)


def test_many_turns_are_exact_too(random_arm):
    arm = random_arm(2, 5, STANDARD, slides=False)
    q = np.random.default_rng(1).uniform(-1e8, 1e8, (100, 5))
    q[50:] *= 1e-4
    np.testing.assert_allclose(arm.fk(q), chain.fk_batch(arm.packed, q), rtol=0, atol=1e-14)


def test_sine_and_cosine_are_exact_to_a_rounding():
    from splinearm.kinematics.sine_kernel import sincos

    angles = np.concatenate((np.linspace(-30, 30, 20001), np.arange(-40, 41) * (np.pi / 2)))
    angles = np.concatenate((angles, np.random.default_rng(0).uniform(-1e5, 1e5, 20000)))
    found = np.array([sincos(x) for x in angles])
    np.testing.assert_allclose(found[:, 0], np.sin(angles), rtol=0, atol=2.3e-16)
    np.testing.assert_allclose(found[:, 1], np.cos(angles), rtol=0, atol=2.3e-16)


def test_answers_are_written_where_asked(arms):
    arm = arms[5]
    q = np.random.default_rng(1).uniform(-1, 1, (4, arm.n))
    for ask in (arm.fk, arm.frames, arm.jacobian):
        for joints in (q, q[0]):
            wanted = ask(joints)
            out = np.full(wanted.shape, np.nan)
            assert ask(joints, out=out) is out
            np.testing.assert_allclose(out, wanted, rtol=0, atol=1e-14)


def test_a_place_that_does_not_fit_is_refused(random_arm):
    arm = random_arm(1, 6, STANDARD)
    q = np.zeros(6)
    read_only = np.zeros((4, 4))
    read_only.flags.writeable = False
    for out in (np.empty((4, 3)), np.empty((4, 8))[:, ::2], np.empty((4, 4)).T, read_only):
        with pytest.raises(ValueError, match="out: want"):
            arm.fk(q, out=out)
    for out in (np.empty((4, 4), dtype=np.float32), [[0.0] * 4] * 4):
        with pytest.raises(TypeError, match="out: want an array of float64"):
            arm.fk(q, out=out)
    with pytest.raises(ValueError, match=r"out: want shape \(6, 6\), got \(6, 5\)"):
        arm.jacobian(q, out=np.empty((6, 5)))


def test_bare_calls_say_whether_they_have(random_arm):
    arm = random_arm(1, 6, STANDARD)
    bare = arm.bare()
    q, T, J = np.linspace(-1, 1, 6), np.empty((4, 4)), np.empty((6, 6))
    assert bare.fk(q, T)
    assert bare.jacobian(q, J)
    np.testing.assert_array_equal(T, arm.fk(q))
    np.testing.assert_array_equal(J, arm.jacobian(q))
    assert not bare.fk(np.zeros(5), T)
    assert not bare.fk(q, np.empty((4, 3)))
    assert not bare.fk(q, np.empty((3, 4)))
    assert not bare.jacobian(q, np.empty((6, 5)))
    assert not bare.jacobian(q, np.empty((5, 6)))
    assert not bare.jacobian(np.full(6, np.nan), J)
    assert not bare.fk(np.full(6, np.inf), T)


def test_every_kind_of_joint_array_is_taken(random_arm):
    arm = random_arm(1, 6, STANDARD)
    q = np.array([0.0, 1.0, -1.0, 2.0, 1.0, 0.0])
    frozen = q.copy()
    frozen.flags.writeable = False
    wanted = chain.fk(arm.packed, q)
    for same in (
        q.tolist(),
        tuple(q),
        q.astype(int),
        frozen,
        np.repeat(q, 2)[::2],
        q.astype(">f8"),
    ):
        np.testing.assert_allclose(arm.fk(same), wanted, rtol=0, atol=1e-14)
        np.testing.assert_allclose(arm.fk(same, out=np.empty((4, 4))), wanted, rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    "q",
    [np.zeros(5), np.zeros(7), [0, 0, 0, 0, 0, np.nan], [0, np.inf, 0, 0, 0, 0], 1.0, "q", None],
)
def test_what_is_not_a_joint_vector_is_refused(random_arm, q):
    arm = random_arm(1, 6, STANDARD)
    given = np.array(q) if isinstance(q, list) else q
    for ask in (arm.fk, arm.frames, arm.jacobian):
        with pytest.raises(ValueError, match="q: want"):
            ask(given)
    with pytest.raises(ValueError, match="q: want"):
        arm.fk(given, out=np.empty((4, 4)))


def test_complex_numbers_are_refused(random_arm):
    with pytest.raises(ValueError, match="q: want an array of numbers"):
        random_arm(1, 6, STANDARD).fk(np.ones(6, dtype=complex))


def test_the_jacobian_is_the_difference_of_poses(arms, joints_inside):
    rng = np.random.default_rng(4)
    step = 1e-6
    for arm in arms:
        q = joints_inside(arm, rng)
        steps = step * np.eye(arm.n)
        T, over, under = arm.fk(q), arm.fk(q + steps), arm.fk(q - steps)
        linear = (over[:, :3, 3] - under[:, :3, 3]) / (2 * step)
        turning = (over[:, :3, :3] - under[:, :3, :3]) @ T[:3, :3].T / (2 * step)
        angular = np.stack([turning[:, 2, 1], turning[:, 0, 2], turning[:, 1, 0]], axis=1)
        wanted = np.concatenate((linear, angular), axis=1).T
        np.testing.assert_allclose(arm.jacobian(q), wanted, rtol=0, atol=1e-8)


def test_the_jacobian_in_the_tool_frame_is_the_same_motion(arms):
    for arm in arms[:10]:
        q = np.random.default_rng(4).uniform(-1, 1, (3, arm.n))
        R = arm.fk(q)[:, :3, :3]
        J, J_tool = arm.jacobian(q, frame="base"), arm.jacobian(q, frame="tool")
        np.testing.assert_allclose(R @ J_tool[:, :3], J[:, :3], rtol=0, atol=1e-14)
        np.testing.assert_allclose(R @ J_tool[:, 3:], J[:, 3:], rtol=0, atol=1e-14)
        np.testing.assert_allclose(arm.jacobian(q[0], frame="tool"), J_tool[0], rtol=0, atol=1e-14)


def test_a_frame_that_is_no_frame_is_refused(arms):
    with pytest.raises(ValueError, match="frame: want 'base' or 'tool', got 'world'"):
        arms[0].jacobian(np.zeros(arms[0].n), frame="world")


ARM = """
import sys, numpy as np
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.dh import DHConvention, DHLink
rows = [DHLink(f"j{k}", 0.1 * k, 0.5 * k, 0.2, 0.1) for k in range(4)]
ones = np.ones(4)
limits = JointLimits(names=tuple(r.name for r in rows), kinds=tuple(r.kind for r in rows),
    q_min=-ones, q_max=ones, qd_max=ones, qdd_max=ones)
arm = Arm.from_dh("arm", rows, DHConvention.STANDARD, limits)
q = np.full(4, 0.3)
loaded = lambda: "numba" in sys.modules
"""


def test_numba_is_loaded_only_when_kernels_are_wanted(python):
    code = f"""{ARM}
arm.fk(q), arm.jacobian(q), arm.frames(q), arm.fk(np.zeros((1000, 4)))
for _ in range(3000):
    arm.fk(q)
assert not loaded()
T = arm.fk(q)
again = arm.fk(q, out=np.empty((4, 4)))
assert loaded() and abs(T - again).max() < 1e-14
"""
    python(code)


def test_a_heavy_batch_loads_the_kernels(python):
    python(f"{ARM}\narm.fk(np.zeros(({forward.HEAVY}, 4)))\nassert loaded()")


def test_an_arm_can_be_compiled_ahead(python):
    python(f"{ARM}\nassert arm.compiled() is arm\nassert loaded()")


@pytest.mark.kernel
def test_an_arm_that_travelled_answers_as_before(random_arm):
    arm = random_arm(3, 5, DHConvention.STANDARD).compiled()
    arm.bare()
    q = np.linspace(-1.0, 1.0, 5)
    there = pickle.loads(pickle.dumps(arm))
    np.testing.assert_array_equal(there.fk(q), arm.fk(q))
    np.testing.assert_array_equal(there.jacobian(q), arm.jacobian(q))
    T = np.empty((4, 4))
    assert there.bare().fk(q, T)
    np.testing.assert_array_equal(T, arm.fk(pickle.loads(pickle.dumps(q))))
