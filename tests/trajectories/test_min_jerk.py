import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.curves.interpolation import interpolate
from splinearm.errors import CurveError
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.leg import straight_path
from splinearm.trajectories.min_jerk import minimum_jerk, shortest_duration
from splinearm.trajectories.polynomial_law import PolynomialLaw
from splinearm.trajectories.section import Section

PATH = JointPath(
    interpolate(np.random.default_rng(2).uniform(-1.0, 1.0, (6, 3)), parameters="uniform")
)


@pytest.fixture(scope="module")
def limits_3(make_limits):
    return make_limits([1.0] * 3, [4.0] * 3, [60.0] * 3)


def use(path, law, limits, count=20_001):
    ts = np.linspace(0.0, law.duration, count)
    section = Section(path, law)
    _, qd, qdd = section.sample(ts)
    shares = [np.abs(qd) / limits.qd_max, np.abs(qdd) / limits.qdd_max]
    if limits.qddd_max is not None:
        shares.append(np.abs(section.jerk(ts)) / limits.qddd_max)
    return [float(share.max()) for share in shares]


def test_a_straight_move_is_the_known_quintic(make_limits):
    # largest speed 15 / 8, acceleration 10 / sqrt(3), jerk 60 times way / time^k
    path = straight_path(np.zeros(1), np.ones(1))
    for limits, want in (
        (make_limits([0.1], [1e9], [1e9]), 18.75),
        (make_limits([1e9], [0.1], [1e9]), np.sqrt(100.0 / np.sqrt(3.0))),
        (make_limits([1e9], [1e9], [0.06]), 10.0),
        (make_limits([0.1], [1e9]), 18.75),
    ):
        assert shortest_duration(path, limits) == pytest.approx(want, rel=1e-9)
    law = minimum_jerk(path, make_limits([1.0], [9.0]), 2.0)
    assert law.at(1.0) == pytest.approx((0.5, 0.9375, 0.0), abs=1e-15)


@pytest.mark.property
@settings(max_examples=20, deadline=None)
@given(v0=st.floats(0.0, 0.4), v1=st.floats(0.0, 0.4), seed=st.integers(0, 99))
def test_nothing_near_it_jerks_less(v0, v1, seed, make_limits):
    law = minimum_jerk(PATH, make_limits([9e9] * 3, [9e9] * 3), 2.0, speeds=(v0, v1))
    t = np.linspace(0.0, 2.0, 4001)
    assert law.at(0.0) == pytest.approx((law.s[0], v0, 0.0), abs=1e-12)
    assert law.at(2.0) == pytest.approx((law.s[1], v1, 0.0), abs=1e-12)
    jerk = law.jerk(t)
    # whatever is zero with two derivatives at both ends may be added
    x, extra = t / 2.0, np.random.default_rng(seed).normal(size=4)
    bump = np.polynomial.Polynomial([0, 0, 0, 1, -3, 3, -1]) * np.polynomial.Polynomial(extra)
    other = jerk + bump.deriv(3)(x) * 0.01
    assert np.trapezoid(other**2, t) > np.trapezoid(jerk**2, t)


def test_the_shortest_duration_uses_a_limit_fully_and_breaks_none(make_limits, limits_3):
    shortest = shortest_duration(PATH, limits_3)
    used = use(PATH, minimum_jerk(PATH, limits_3, shortest), limits_3)
    assert 0.9999 < max(used) <= 1.0 + 1e-6
    with pytest.raises(CurveError, match=r"too short for the limits; .* s are enough"):
        minimum_jerk(PATH, limits_3, 0.99 * shortest)
    # without a limit of jerk it is never longer
    assert shortest_duration(PATH, make_limits([1.0] * 3, [4.0] * 3)) <= shortest


def test_moving_ends_have_a_shortest_duration_too(limits_3):
    speeds = (0.05, 0.08)
    shortest = shortest_duration(PATH, limits_3, speeds=speeds)
    law = minimum_jerk(PATH, limits_3, shortest, speeds=speeds)
    assert 0.999 < max(use(PATH, law, limits_3)) <= 1.0 + 1e-6
    with pytest.raises(CurveError, match=r"too short"):
        minimum_jerk(PATH, limits_3, 0.98 * shortest, speeds=speeds)
    # too long: it would have to turn round
    with pytest.raises(CurveError, match=r"goes backwards or breaks a limit; one of"):
        minimum_jerk(PATH, limits_3, 1e3 * shortest, speeds=speeds)
    with pytest.raises(CurveError, match=r"no duration keeps the limits"):
        shortest_duration(PATH, limits_3, speeds=(100.0, 0.0))


def test_limits_of_c_take_one_cth_as_long(make_limits, limits_3):
    want = shortest_duration(PATH, limits_3)
    for c in (0.01, 0.5, 3.0):
        limits = make_limits(limits_3.qd_max * c, limits_3.qdd_max * c**2, limits_3.qddd_max * c**3)
        assert shortest_duration(PATH, limits) * c == pytest.approx(want, rel=1e-12)


def test_a_law_slower_backwards_and_in_parts_is_the_same_motion(limits_3):
    law = minimum_jerk(PATH, limits_3, 14.0)
    ts = np.linspace(0.0, 14.0, 31)
    s, speed, acceleration = law.sample(ts)
    jerk = law.jerk(ts)
    slow = law.slower(0.5)
    assert np.allclose(slow.sample(2.0 * ts), (s, speed / 2, acceleration / 4), atol=1e-13)
    back = law.reversed()
    assert np.allclose(
        back.sample(14.0 - ts), (law.s[0] + law.s[1] - s, speed, -acceleration), atol=1e-12
    )
    part = law.between(2.0, 7.0)
    inner = (ts >= 2.0) & (ts <= 7.0)
    got = part.sample(ts[inner] - 2.0)
    assert np.allclose(got, (s[inner], speed[inner], acceleration[inner]), atol=1e-12)
    assert np.allclose(part.jerk(ts[inner] - 2.0), jerk[inner], atol=1e-11)
    for t in (0.0, 2.3, 14.0):
        assert law.time_at(law.at(t)[0]) == pytest.approx(t, abs=1e-4)
        assert law.at(law.time_at(law.at(t)[0]))[0] == pytest.approx(law.at(t)[0], abs=1e-14)
    assert law.time_at(-1.0) == 0.0
    assert law.time_at(99.0) == law.duration


def test_joints_that_stay_need_no_time(make_limits):
    still = JointPath(interpolate(np.full((4, 2), 0.7), parameters="uniform"))
    assert shortest_duration(still, make_limits([1.0] * 2, [1.0] * 2)) < 1e-4
    assert minimum_jerk(still, make_limits([1.0] * 2, [1.0] * 2), 3.0).duration == 3.0


def test_what_makes_no_sense_is_refused(make_limits, limits_3):
    for duration in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match=r"duration: want a number above 0"):
            minimum_jerk(PATH, limits_3, duration)
    for speeds in ((-1.0, 0.0), (np.nan, 0.0), (0.0,)):
        with pytest.raises(ValueError, match=r"speeds: want two numbers"):
            minimum_jerk(PATH, limits_3, 1.0, speeds=speeds)
    with pytest.raises(ValueError, match=r"span: want a part"):
        minimum_jerk(PATH, limits_3, 1.0, (0.5, 0.2))
    with pytest.raises(ValueError, match=r"limits: want them for the 3 joints"):
        shortest_duration(PATH, make_limits([1.0], [1.0]))
    knots = np.concatenate((np.zeros(4), [0.5, 0.5], np.ones(4)))
    bent = JointPath(BSpline(knots, np.random.default_rng(3).uniform(-1, 1, (6, 3)), 3))
    with pytest.raises(CurveError, match=r"second derivative"):
        shortest_duration(bent, limits_3)
    assert shortest_duration(bent, make_limits([1.0] * 3, [4.0] * 3)) > 0.0
    with pytest.raises(ValueError, match=r"coefficients: want at least one"):
        PolynomialLaw(np.zeros(0), 1.0)
    with pytest.raises(ValueError, match=r"duration: want a number above 0"):
        PolynomialLaw(np.zeros(1), 0.0)
