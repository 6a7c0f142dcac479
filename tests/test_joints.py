import numpy as np
import pytest

from splinearm.errors import LimitError
from splinearm.joints import JointKind, JointLimits, JointSetpoint, JointState


def make_limits(**changed):
    values = {
        "names": ("lift", "turn"),
        "kinds": (JointKind.PRISMATIC, JointKind.REVOLUTE),
        "q_min": [0.0, -1.0],
        "q_max": [0.2, 1.0],
        "qd_max": [0.1, 2.0],
        "qdd_max": [0.5, 8.0],
    }
    return JointLimits(**(values | changed))


def test_values_within_the_limits_pass():
    make_limits().check(np.array([0.2, -1.0]), np.array([-0.1, 2.0]), np.array([0.5, -8.0]))


def test_a_sliding_joint_is_refused_in_millimetres():
    with pytest.raises(LimitError) as caught:
        make_limits().check(np.array([0.25, 0.0]), t=1.5)
    assert str(caught.value).startswith(
        "joint 'lift': position 250 mm is above its limit 200 mm at t = 1.500 s"
    )
    assert (caught.value.value, caught.value.limit) == (0.25, 0.2)


def test_a_turning_joint_is_refused_in_degrees():
    with pytest.raises(LimitError, match=r"joint 'turn': velocity -171\.887 deg/s is below"):
        make_limits().check(np.zeros(2), np.array([0.0, -3.0]))


def test_scaled_limits_slow_velocity_and_acceleration_together():
    slow = make_limits(qddd_max=[1.0, 80.0]).scaled(0.5)
    np.testing.assert_allclose(slow.qd_max, [0.05, 1.0])
    np.testing.assert_allclose(slow.qdd_max, [0.125, 2.0])
    np.testing.assert_allclose(slow.qddd_max, [0.125, 10.0])
    with pytest.raises(ValueError, match="share"):
        make_limits().scaled(1.5)


@pytest.mark.parametrize(
    ("changed", "what"),
    [
        ({"q_min": [0.3, -1.0]}, "joint 'lift'"),
        ({"qd_max": [0.0, 1.0]}, "qd_max: want numbers above zero"),
        ({"q_max": [0.2]}, r"q_max: want shape \(2\), got \(1,\)"),
        ({"qdd_max": [np.nan, 1.0]}, "qdd_max: want finite"),
        ({"kinds": (JointKind.REVOLUTE,)}, "kinds: want 2"),
    ],
)
def test_limits_that_cannot_be_are_refused(changed, what):
    with pytest.raises(ValueError, match=what):
        make_limits(**changed)


def test_an_endless_joint_has_infinite_position_limits():
    limits = make_limits(q_min=[0.0, -np.inf], q_max=[0.2, np.inf])
    limits.check(np.array([0.1, 1e6]))


def test_a_setpoint_is_checked_and_frozen():
    setpoint = JointSetpoint(t=0.0, q=[1, 2], qd=[0, 0], qdd=[0, 0])
    assert setpoint.q.dtype == np.float64
    with pytest.raises(ValueError, match="read-only"):
        setpoint.q[0] = 3.0
    with pytest.raises(ValueError, match="qd: want shape"):
        JointSetpoint(t=0.0, q=[1, 2], qd=[0], qdd=[0, 0])
    with pytest.raises(ValueError, match="q: want finite"):
        JointSetpoint(t=0.0, q=[1, np.nan], qd=[0, 0], qdd=[0, 0])
    with pytest.raises(ValueError, match="t: want a finite time"):
        JointSetpoint(t=np.inf, q=[1, 2], qd=[0, 0], qdd=[0, 0])


def test_a_state_may_lack_the_current():
    state = JointState(t=0.0, q=[1, 2], qd=[0, 0], current=[np.nan, 0.1])
    assert np.isnan(state.current[0])
    with pytest.raises(ValueError, match="current: want shape"):
        JointState(t=0.0, q=[1, 2], qd=[0, 0], current=[0.1])
