import numpy as np
import pytest

from splinearm.kinematics import IKStatus, Pose
from splinearm.kinematics.objective import AwayFromLimits, Manipulability, NearPosture
from splinearm.kinematics.self_motion import improve, search_best

pytestmark = pytest.mark.kernel

POSTURE = np.array([0.0, -0.3, 0.0, -2.0, 0.0, 2.0, 0.8])
OBJECTIVES = [
    AwayFromLimits(),
    Manipulability(),
    Manipulability(position_only=True),
    NearPosture(POSTURE),
]


@pytest.fixture(scope="module")
def panda(known_arm):
    return known_arm("panda")


@pytest.mark.parametrize(
    "objective", OBJECTIVES, ids=["limits", "volume", "volume of velocities", "posture"]
)
def test_slopes_are_those_of_the_cost(panda, joints_inside, objective):
    q = joints_inside(panda, np.random.default_rng(1))
    way = np.random.default_rng(2).normal(size=7)
    step = 1e-4
    there, back = objective.cost(panda, q + step * way), objective.cost(panda, q - step * way)
    slope = (there - back) / (2.0 * step)
    assert objective.gradient(panda, q) @ way == pytest.approx(slope, rel=1e-4, abs=1e-6)


@pytest.mark.parametrize(
    "objective", OBJECTIVES, ids=["limits", "volume", "volume of velocities", "posture"]
)
def test_an_objective_is_served_better_and_the_tool_stays(panda, joints_inside, objective):
    rng = np.random.default_rng(3)
    gains = []
    for _ in range(10):
        q = joints_inside(panda, rng)
        better = improve(panda, q, objective)
        np.testing.assert_allclose(panda.fk(better), panda.fk(q), atol=3e-6)
        assert (better >= panda.limits.q_min).all()
        assert (better <= panda.limits.q_max).all()
        gains.append(objective.cost(panda, q) - objective.cost(panda, better))
    assert min(gains) >= 0.0
    assert np.median(gains) > 1e-4


def test_where_it_ends_no_self_motion_helps(panda, joints_inside):
    objective = NearPosture(POSTURE)
    q = improve(panda, joints_inside(panda, np.random.default_rng(4)), objective)
    at_limit = (q <= panda.limits.q_min + 1e-9) | (q >= panda.limits.q_max - 1e-9)
    null = np.linalg.svd(panda.jacobian(q)[:, ~at_limit])[2][6:]
    assert np.abs(null @ objective.gradient(panda, q)[~at_limit]).max(initial=0.0) < 1e-2


def test_a_posture_with_the_same_tool_is_taken(panda):
    other = improve(panda, POSTURE, AwayFromLimits())
    assert np.abs(other - POSTURE).max() > 0.05
    np.testing.assert_allclose(improve(panda, other, NearPosture(POSTURE)), POSTURE, atol=1e-3)


def test_an_arm_without_freedom_stays(widowx):
    q = np.array([0.2, 0.4, -0.3, 0.5, 0.8, 0.1])
    np.testing.assert_array_equal(improve(widowx, q, Manipulability()), q)
    moved = improve(widowx, q, AwayFromLimits(), position_only=True)
    assert np.abs(moved - q).max() > 0.1
    np.testing.assert_allclose(widowx.fk(moved)[:3, 3], widowx.fk(q)[:3, 3], atol=2e-6)


def test_the_best_of_all_answers_is_no_worse_than_one_improved(panda, joints_inside):
    rng = np.random.default_rng(5)
    for _ in range(5):
        q = joints_inside(panda, rng)
        T = panda.fk(q)
        result = search_best(panda, Pose.from_matrix(T), AwayFromLimits())
        assert result.reached
        np.testing.assert_allclose(panda.fk(result.q), T, atol=3e-6)
        objective = AwayFromLimits()
        one = objective.cost(panda, improve(panda, q, objective))
        assert objective.cost(panda, result.q) <= one + 1e-3


def test_a_missed_target_is_answered_as_by_search(panda):
    result = search_best(panda, [2.0, 0.0, 0.0], AwayFromLimits())
    assert result.status is IKStatus.OUT_OF_REACH
    assert result.reason.startswith("out of reach by ")


def test_what_is_no_start_is_refused(panda):
    with pytest.raises(ValueError, match="q: want joint positions within the limits"):
        improve(panda, np.full(7, 3.0), AwayFromLimits())
    with pytest.raises(ValueError, match=r"q: want shape \(7\)"):
        improve(panda, np.zeros(6), AwayFromLimits())
    with pytest.raises(ValueError, match="want a posture of 7 joints, got 2"):
        improve(panda, POSTURE, NearPosture(np.zeros(2)))


@pytest.mark.parametrize(
    "objective", OBJECTIVES, ids=["limits", "volume", "volume of velocities", "posture"]
)
def test_the_slopes_of_an_objective_are_its_differences(panda, objective):
    for share in (0.2, 0.45, 0.7):
        q = panda.limits.q_min + share * (panda.limits.q_max - panda.limits.q_min)
        steps = 1e-6 * np.eye(7)
        wanted = [objective.cost(panda, q + d) - objective.cost(panda, q - d) for d in steps]
        found = objective.gradient(panda, q)
        np.testing.assert_allclose(found, np.array(wanted) / 2e-6, atol=1e-6)
