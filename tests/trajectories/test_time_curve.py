import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.errors import CurveError
from splinearm.trajectories.trajectory import JointTrajectory


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(
    seed=st.integers(0, 9999),
    dwell=st.sampled_from([0.0, 0.4]),
    tolerance=st.sampled_from([1e-2, 1e-3, 1e-5]),
)
def test_a_curve_by_time_stays_within_its_tolerance(seed, dwell, tolerance, make_motion):
    motion = make_motion(seed, dwell)
    curve = motion.to_bspline(tolerance)
    assert curve.domain == (0.0, motion.duration)
    ts = np.linspace(0.0, motion.duration, 3001)
    assert np.abs(curve.at(ts) - motion.sample(ts)[0]).max() <= 1.1 * tolerance
    assert np.allclose(curve.at(np.array(curve.domain), 1), 0.0, atol=1e-9)


def test_a_smaller_tolerance_takes_more_points_and_far_fewer_than_samples(make_motion):
    motion = make_motion(3)
    sizes = [len(motion.to_bspline(tolerance).points) for tolerance in (1e-2, 1e-4, 1e-6)]
    assert sizes[0] < sizes[1] < sizes[2] < 1000


def test_what_is_no_curve_by_time_is_refused(make_motion):
    motion = make_motion(3)
    with pytest.raises(ValueError, match="tolerance: want a number above 0, got 0"):
        motion.to_bspline(0.0)
    with pytest.raises(CurveError, match="allow more"):
        motion.to_bspline(1e-18)
    with pytest.raises(CurveError, match="takes no time"):
        JointTrajectory((), motion.q_start, motion.limits).to_bspline(1e-3)
