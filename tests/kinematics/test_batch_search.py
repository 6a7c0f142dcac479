import numpy as np
import pytest

from splinearm.joints import JointKind
from splinearm.kinematics import DHConvention, DHLink, IKStatus, Pose, quaternion, search
from splinearm.kinematics.batch_search import search_batch

NAMES = ["puma", "ur5", "panda", "widowx"]


def misses(arm, q, T):
    """Give distance and angle of tools at q from transforms, by the numpy forward kinematics."""
    found = arm.fk(q)
    off = np.linalg.norm(found[:, :3, 3] - T[:, :3, 3], axis=1)
    turned = quaternion.angle_between(
        quaternion.from_matrix(found[:, :3, :3]), quaternion.from_matrix(T[:, :3, :3])
    )
    return off, turned


def assert_true(arm, batch, T, tolerance=1e-6):
    """What a batch says is so: limits, errors, and what is reached."""
    q = batch.q[batch.reached]
    assert (q >= arm.limits.q_min).all()
    assert (q <= arm.limits.q_max).all()
    off, turned = misses(arm, q, T[batch.reached])
    assert off.max(initial=0.0) <= tolerance
    assert turned.max(initial=0.0) <= tolerance + 1e-8
    np.testing.assert_allclose(batch.position_error[batch.reached], off, atol=1e-12)
    assert np.isnan(batch.q[~batch.reached]).all()
    assert np.isinf(batch.position_error[~batch.reached]).all()


def sweep(arm, inside, m, seed):
    T = arm.fk(inside(arm, np.random.default_rng(seed), m))
    batch = search_batch(arm, T)
    assert_true(arm, batch, T)
    assert batch.reached.mean() >= 0.9999
    return batch


@pytest.mark.parametrize("name", NAMES)
def test_targets_within_the_limits_are_reached(known_arm, joints_inside, name):
    sweep(known_arm(name), joints_inside, 1000, 1)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_ten_thousand_targets_within_the_limits_are_reached(known_arm, joints_inside, name):
    sweep(known_arm(name), joints_inside, 10_000, 2)


def assert_each_miss_has_its_reason(arm, m, seed):
    rng = np.random.default_rng(seed)
    q = rng.uniform(-np.pi, np.pi, (m // 2, arm.n))
    poses = [Pose.from_matrix(T) for T in arm.fk(q)]
    poses += [
        Pose(p, quaternion.normalize(rng.normal(size=4))) for p in rng.uniform(-1, 1, (m // 2, 3))
    ]
    T = np.array([pose.matrix() for pose in poses])
    batch = search_batch(arm, poses)
    assert_true(arm, batch, T)
    assert 0 < batch.reached.sum() < m
    for i in np.flatnonzero(~batch.reached):
        result = batch[int(i)]
        assert result.status is not IKStatus.REACHED
        assert result.reason.startswith("out of reach by ")
        assert result.cause
        assert (result.joint is not None) == (result.status is IKStatus.JOINT_LIMIT)
        assert (result.q >= arm.limits.q_min).all()
        assert (result.q <= arm.limits.q_max).all()
        off, turned = misses(arm, result.q[None], T[i : i + 1])
        assert off[0] == pytest.approx(result.position_error, abs=1e-9)
        assert turned[0] == pytest.approx(result.orientation_error, abs=1e-7)
        assert max(off[0], turned[0]) > 1e-6


@pytest.mark.parametrize("name", ["puma", "panda", "widowx"])
def test_missed_targets_each_get_a_status_and_a_reason(known_arm, name):
    assert_each_miss_has_its_reason(known_arm(name), 200, 3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["puma", "panda", "widowx"])
def test_a_thousand_missed_targets_each_get_a_status_and_a_reason(known_arm, name):
    assert_each_miss_has_its_reason(known_arm(name), 2000, 4)


def test_a_batch_says_what_single_searches_say(widowx, joints_inside):
    rng = np.random.default_rng(5)
    poses = [Pose.from_matrix(T) for T in widowx.fk(joints_inside(widowx, rng, 20))]
    poses.append(Pose([2.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]))
    batch = search_batch(widowx, poses)
    for pose, answer in zip(poses, batch, strict=True):
        single = search(widowx, pose)
        assert single.status is answer.status
        assert single.reason == answer.reason
        np.testing.assert_allclose(single.q, answer.q, atol=1e-7)


def test_positions_leave_the_orientation_free_also_of_an_arm_that_slides(dh_arm):
    rows = [
        DHLink("turn", 0.1, 0.0, 0.2, 0.0),
        DHLink("reach", 0.0, np.pi / 2, 0.0, np.pi / 2, JointKind.PRISMATIC),
        DHLink("out", 0.0, 0.0, 0.1, 0.0, JointKind.PRISMATIC),
    ]
    arm = dh_arm(rows, DHConvention.STANDARD, q_min=(-2.0, 0.0, 0.0), q_max=(2.0, 0.3, 0.4))
    rng = np.random.default_rng(6)
    p = arm.fk(rng.uniform(arm.limits.q_min, arm.limits.q_max, (200, 3)))[:, :3, 3]
    batch = search_batch(arm, p)
    assert batch.reached.all()
    np.testing.assert_allclose(arm.fk(batch.q)[:, :3, 3], p, atol=1e-6)
    assert (batch.q >= arm.limits.q_min).all()
    assert (batch.q <= arm.limits.q_max).all()


def test_seeds_are_where_each_search_begins(widowx, joints_inside):
    q = joints_inside(widowx, np.random.default_rng(7), 100)
    near = np.clip(q + 0.01, widowx.limits.q_min, widowx.limits.q_max)
    batch = search_batch(widowx, widowx.fk(q), near, restarts=0)
    assert batch.reached.mean() > 0.95
    assert np.median(np.abs(batch.q[batch.reached] - q[batch.reached]).max(axis=1)) < 1e-6


def test_no_targets_have_no_answers(widowx):
    batch = search_batch(widowx, np.empty((0, 3)))
    assert len(batch) == 0
    assert list(batch) == []


def _not_rigid():
    T = np.array([np.eye(4)] * 3)
    T[1, 0, 0] = 1.1
    return T


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"targets": np.full((2, 3), np.nan)}, "targets: want finite numbers, got .*nan.* at 0"),
        ({"targets": np.zeros((2, 4))}, r"targets: want shape \(m, 3\) or \(m, 4, 4\), got \(2, 4"),
        ({"targets": _not_rigid()}, r"targets\[1\]: want a rotation .* got \[\[1.1"),
        ({"targets": np.array([np.diag([1, 1, -1, 1])])}, r"targets\[0\]: want a rotation"),
        ({"targets": "here"}, "targets: want arrays of numbers or poses"),
        ({"q_seed": [0.0]}, r"q_seed: want shape \(2,\) or \(1, 2\), got \(1,\)"),
        ({"q_seed": [0.0, np.inf]}, "q_seed: want finite numbers"),
        ({"restarts": 0}, "restarts: want at least 1 without a seed"),
        ({"position_tolerance": -1.0}, "position_tolerance: want a finite number above zero"),
    ],
)
def test_arguments_that_are_none_are_refused(planar, arguments, message):
    with pytest.raises(ValueError, match=message):
        search_batch(planar, **{"targets": [[0.4, 0.1, 0.06]], **arguments})


def test_an_unnormalised_quaternion_is_refused_before_it_gets_here():
    with pytest.raises(ValueError, match=r"quat: want a unit quaternion .* of length 2"):
        Pose([0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0])
