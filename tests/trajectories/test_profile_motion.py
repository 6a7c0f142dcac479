import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.errors import TrajectoryError
from splinearm.joints import JointSetpoint
from splinearm.trajectories.pace import PacedMotion
from splinearm.trajectories.point_to_point import point_to_point, retarget
from splinearm.trajectories.profile import JointProfile
from splinearm.trajectories.profile_motion import trajectory_of_profile


def profile_of(seed, make_limits, n=3):
    rng = np.random.default_rng(seed)
    limits = make_limits(rng.uniform(0.5, 3.0, n), rng.uniform(2.0, 9.0, n)).with_jerk_time(0.1)
    return point_to_point(limits, rng.normal(size=n), rng.normal(size=n))


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 9999), moving=st.booleans())
def test_as_a_path_it_is_the_same_motion(seed, moving, make_limits):
    profile = profile_of(seed, make_limits)
    if moving:
        profile = retarget(profile, 0.4 * profile.duration, np.zeros(3))
    motion = trajectory_of_profile(profile)
    assert motion.duration == profile.duration
    assert motion.ends_at_rest
    assert motion.starts_at_rest != moving
    ts = np.linspace(0.0, profile.duration, 200)[1:-1]
    ts = ts[np.abs(ts[:, None] - profile.nodes()).min(axis=1) > 1e-6]
    for have, want in zip(motion.sample(ts), profile.sample(ts), strict=True):
        assert np.allclose(have, want, atol=1e-9)
    assert np.allclose(motion.jerk(ts), profile.jerk(ts), atol=1e-6)


@pytest.mark.property
@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 9999), share=st.floats(0.05, 0.95))
def test_it_stops_on_its_way_within_the_limits(seed, share, make_limits):
    motion = trajectory_of_profile(profile_of(seed, make_limits))
    stop = motion.stop_from(share * motion.duration)
    ts = np.linspace(0.0, stop.duration * (1.0 - 1e-9), 1001)
    _, qd, qdd = stop.sample(ts)
    limits = motion.limits
    assert (np.abs(qd) <= limits.qd_max * (1.0 + 1e-6)).all()
    assert (np.abs(qdd) <= limits.qdd_max * (1.0 + 1e-6)).all()
    assert (np.abs(stop.jerk(ts)) <= limits.qddd_max * (1.0 + 1e-6)).all()
    assert stop.ends_at_rest
    assert stop.duration <= (1.0 - share) * motion.duration + 1e-9


def test_it_may_be_paused_and_go_on(make_limits):
    motion = trajectory_of_profile(profile_of(3, make_limits))
    paced = PacedMotion(motion, 0.01)
    for k in range(2000):
        paced.ask(0.0 if 10 <= k < 60 else 1.0)
        paced.step()
        if paced.finished:
            break
    assert paced.finished
    assert np.array_equal(paced.setpoint().q, motion.q_goal)


def test_without_time_it_rests_or_is_refused(make_limits):
    limits = make_limits([1.0], [1.0]).with_jerk_time(0.1)
    still = point_to_point(limits, [0.3], [0.3])
    assert trajectory_of_profile(still).duration == 0.0
    moving = JointSetpoint(t=0.0, q=[0.0], qd=[0.5], qdd=[0.0])
    nothing = JointProfile(limits, [[[0.0, *moving.q, *moving.qd, 0.0, 0.0]]])
    with pytest.raises(TrajectoryError, match="takes no time"):
        trajectory_of_profile(nothing)
