import numpy as np
import pytest

from splinearm.trajectories.sampled import rows_of, trajectory_of


def test_rows_are_even_and_end_with_the_motion(make_motion):
    motion = make_motion(1)
    rows = rows_of(motion, 50.0)
    assert np.allclose(np.diff(rows.t[:-1]), 0.02)
    assert rows.t[-1] == motion.duration
    assert 0.0 < rows.t[-1] - rows.t[-2] <= 0.02 + 1e-9
    assert np.array_equal(rows.q[-1], motion.q_goal)
    with pytest.raises(ValueError, match="rate: want a number above 0 Hz, got 0"):
        rows_of(motion, 0.0)


@pytest.mark.parametrize("columns", [1, 2, 3])
def test_a_motion_passes_the_rows_it_was_made_from(columns, make_motion):
    motion = make_motion(2)
    rows = rows_of(motion, 80.0)
    made = trajectory_of(motion.limits, rows.t, *rows[1 : 1 + columns])
    assert made.duration == motion.duration
    assert made.starts_at_rest
    assert made.ends_at_rest
    for have, want in zip(made.sample(rows.t)[:columns], rows[1 : 1 + columns], strict=True):
        assert np.allclose(have[:-1], want[:-1], atol=1e-9)
    assert np.allclose(made.q_goal, rows.q[-1], atol=1e-14)


def test_rows_of_a_polynomial_give_it_back(make_limits):
    t = np.array([0.0, 0.3, 1.0, 1.1, 2.0])

    def f(t, k):
        polynomial = np.polynomial.Polynomial([0.2, 0.0, 1.0, -0.6, 0.1, 0.02])
        return polynomial.deriv(k)(t)[:, None] if k else polynomial(t)[:, None]

    made = trajectory_of(make_limits([9.0], [9.0]), t, f(t, 0), f(t, 1), f(t, 2))
    ts = np.linspace(0.0, 1.999, 50)
    for k, values in enumerate(made.sample(ts)):
        assert np.allclose(values, f(ts, k), atol=1e-10)
    assert np.allclose(made.jerk(ts), f(ts, 3), atol=1e-8)
    assert not made.ends_at_rest


def test_rows_that_make_no_motion_are_refused(make_limits):
    limits = make_limits([1.0], [1.0])
    q = [[0.0], [1.0]]
    for t in ([0.0, 0.0], [0.1, 0.2], [0.0, -1.0]):
        with pytest.raises(ValueError, match="t: want two or more rising times from 0"):
            trajectory_of(limits, t, q)
    with pytest.raises(ValueError, match=r"q: want shape \(2, 1\)"):
        trajectory_of(limits, [0.0, 1.0], [[0.0]])
    with pytest.raises(ValueError, match="qdd: accelerations need velocities"):
        trajectory_of(limits, [0.0, 1.0], q, None, q)
