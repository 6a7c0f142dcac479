from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.curves.interpolation import interpolate
from splinearm.errors import CurveError, LimitError
from splinearm.trajectories.constraint import SpeedCap
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.leg import straight_path
from splinearm.trajectories.section import Section
from splinearm.trajectories.smooth_timing import Passage, quickest_smooth
from splinearm.trajectories.timing import quickest

PANDA = ([2.175] * 4 + [2.61] * 3, np.array([15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0]))


def panda_path(seed):
    """The path of the field's comparison: a quintic through eight random waypoints."""
    points = np.random.default_rng(seed).uniform(-2.0, 2.0, (8, 7))
    return JointPath(interpolate(points, degree=5, parameters="uniform"))


@pytest.fixture(scope="module")
def panda_limits(make_limits):
    return make_limits(*PANDA, 10.0 * PANDA[1])


def drawn(seed, make_limits):
    """A path of 1 to 7 joints, some of which rest, turn back or repeat points, and its limits."""
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(1, 8)), int(rng.integers(3, 12))
    points = rng.uniform(-2.0, 2.0, (m, n))
    kind = rng.choice(["any", "resting", "repeated", "there and back", "one line"])
    if kind == "resting":
        points[:, 0] = 0.5
        points = np.hstack((points, rng.uniform(-1.0, 1.0, (m, 1))))
    elif kind == "repeated":
        points = np.repeat(points, rng.integers(1, 3, m), axis=0)
    elif kind == "there and back":
        points = np.vstack((points, points[::-1]))
    elif kind == "one line":
        points = np.outer(rng.uniform(-1.0, 1.0, m), rng.uniform(-1.0, 1.0, n))
    u = 10.0 ** rng.integers(-6, 7) * np.cumsum(rng.uniform(0.3, 1.0, len(points)))
    path = JointPath(interpolate(points, degree=int(rng.choice([3, 5])), parameters=u))
    velocity = 10.0 ** rng.uniform(-2, 2, path.n) * 10.0 ** rng.integers(-3, 4)
    acceleration = velocity * 10.0 ** rng.uniform(-1, 2, path.n)
    jerk = acceleration * 10.0 ** rng.uniform(-1, 3, path.n)
    return path, make_limits(velocity, acceleration, jerk)


def use(path, law, limits, count=10_001):
    """The largest shares of velocity, acceleration and jerk limits at many moments."""
    ts = np.linspace(0.0, law.duration, count)
    section = Section(path, law)
    _, qd, qdd = section.sample(ts)
    pairs = ((qd, limits.qd_max), (qdd, limits.qdd_max), (section.jerk(ts), limits.qddd_max))
    return [float(np.abs(value / most).max()) for value, most in pairs]


def check_within_limits(seed, count, make_limits):
    path, limits = drawn(seed, make_limits)
    law = quickest_smooth(path, limits, cells=100)
    used = use(path, law, limits, count)
    assert max(used) <= 1.0 + 1e-6, used
    assert max(used) > 0.95, "but nearly reached: else it is not the quickest"
    assert law.duration >= quickest(path, limits).duration * (1.0 - 1e-3)
    # it starts and ends at rest without acceleration, and never goes back
    assert law.s[0] == path.domain[0]
    assert law.s[-1] == path.domain[1]
    assert law.speed[[0, -1]].tolist() == law.acceleration[[0, -1]].tolist() == [0.0, 0.0]
    s, speed, acceleration, _ = law.states(np.linspace(0.0, law.duration, count))
    length = law.s[-1] - law.s[0]
    assert s[-1] == pytest.approx(law.s[-1], rel=0, abs=1e-12 * max(length, abs(law.s[-1])))
    assert abs(speed[-1]) <= 1e-11 * speed.max()
    assert abs(acceleration[-1]) <= 1e-11 * np.abs(acceleration).max()
    assert (speed[1:-1] > 0.0).all()


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_no_limit_is_broken_at_any_moment(seed, make_limits):
    check_within_limits(seed, 10_001, make_limits)


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_no_limit_is_broken_on_a_thousand_paths(make_limits):
    for seed in range(1000):
        check_within_limits(seed, 10_001, make_limits)


@pytest.mark.kernel
def test_a_few_cells_are_enough_to_keep_all_limits(make_limits):
    # small, for it is run as plain Python too
    points = np.random.default_rng(5).uniform(-1.0, 1.0, (5, 2))
    path = JointPath(interpolate(points, degree=5, parameters="uniform"))
    limits = make_limits([1.0] * 2, [3.0] * 2, [20.0] * 2)
    whole = quickest_smooth(path, limits, cells=10, passage=Passage(jerk_max=50.0))
    assert max(use(path, whole, limits)) <= 1.0 + 1e-6
    middle = 0.5 * sum(path.domain)
    _, speed, acceleration = whole.at(whole.time_at(middle))
    course = Passage(start_speed=0.8 * speed, start_acceleration=0.64 * acceleration)
    law = quickest_smooth(path, limits, (middle, path.domain[1]), passage=course, cells=10)
    assert max(use(path, law, limits)) <= 1.0 + 1e-6


@pytest.mark.parametrize("seed", range(3))
def test_the_quickest_on_a_fine_grid_is_nearly_reached_on_a_coarse_one(seed, panda_limits):
    path = panda_path(seed)
    fine = quickest_smooth(path, panda_limits, cells=1500).duration
    for cells, worse in ((100, 1.015), (200, 1.006), (600, 1.002)):
        law = quickest_smooth(path, panda_limits, cells=cells)
        assert fine * (1.0 - 1e-3) <= law.duration <= worse * fine
        assert max(use(path, law, panda_limits)) <= 1.0 + 1e-6


def test_very_high_jerks_give_the_quickest_law_without(make_limits):
    path = panda_path(4)
    limits = make_limits(*PANDA, 1e5 * PANDA[1])
    law = quickest_smooth(path, limits, cells=600)
    assert law.duration == pytest.approx(quickest(path, limits).duration, rel=5e-3)


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), c=st.sampled_from([0.001, 0.3, 0.5, 2.0, 7.0, 1e4]))
def test_limits_of_c_take_one_cth_as_long(seed, c, make_limits):
    path, limits = drawn(seed, make_limits)
    other = make_limits(limits.qd_max * c, limits.qdd_max * c**2, limits.qddd_max * c**3)
    want = quickest_smooth(path, limits, cells=60).duration
    assert quickest_smooth(path, other, cells=60).duration * c == pytest.approx(want, rel=1e-8)


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), factor=st.sampled_from([1e-6, 1e-3, 1e3, 1e6]))
def test_no_unit_matters(seed, factor, make_limits):
    path, limits = drawn(seed, make_limits)
    curve = path.curve
    want = quickest_smooth(path, limits, cells=60).duration
    parameter = JointPath(BSpline(curve.knots * factor, curve.points, curve.degree))
    assert quickest_smooth(parameter, limits, cells=60).duration == pytest.approx(want, rel=1e-8)
    length = JointPath(BSpline(curve.knots, curve.points * factor, curve.degree))
    three = (limits.qd_max * factor, limits.qdd_max * factor, limits.qddd_max * factor)
    got = quickest_smooth(length, make_limits(*three), cells=60).duration
    assert got == pytest.approx(want, rel=1e-8)


@pytest.mark.parametrize(
    ("speed", "acceleration", "jerk", "want"),
    [
        # seven phases: both reached; 2 / 1 + 1 / 2 + 2 / 8
        (1.0, 2.0, 8.0, 2.0 + 0.5 + 0.25),
        # acceleration never reached: 2 / 1 + 2 sqrt(1 / 8)
        (1.0, 9.0, 8.0, 2.0 + 2.0 * np.sqrt(1.0 / 8.0)),
        # speed never reached: a / j + sqrt((a / j)^2 + 4 L / a)
        (9.0, 2.0, 8.0, 0.25 + np.sqrt(0.25**2 + 4.0)),
        # nothing but the jerk: 4 (L / (2 j))^(1/3)
        (90.0, 90.0, 8.0, 4.0 * (2.0 / 16.0) ** (1.0 / 3.0)),
    ],
)
def test_a_straight_way_takes_the_time_of_the_seven_phases(
    speed, acceleration, jerk, want, make_limits
):
    path = straight_path(np.array([1.0, 0.0]), np.array([-1.0, 0.5]))
    limits = make_limits([speed] * 2, [acceleration] * 2, [jerk] * 2)
    law = quickest_smooth(path, limits)
    assert law.duration == pytest.approx(want, rel=1e-14)
    assert max(use(path, law, limits)) <= 1.0 + 1e-12
    assert len(law.t) <= 8
    # a tool speed that is never reached takes it to the general solver
    cap = SpeedCap(edges=np.array([0.0, 1.0]), speeds=np.array([1e9]), rate=np.ones_like)
    general = quickest_smooth(path, limits, cap=cap)
    assert want * (1.0 - 1e-9) <= general.duration <= want * 1.01
    finer = quickest_smooth(path, limits, cap=cap, cells=1000)
    assert finer.duration <= want * 1.002


def test_the_path_itself_may_have_a_jerk_limit(make_limits):
    path = straight_path(np.zeros(1), np.ones(1))
    limits = make_limits([1e3], [1e3], [1e6])
    law = quickest_smooth(path, limits, passage=Passage(jerk_max=8.0))
    assert law.duration == pytest.approx(4.0 * (1.0 / 16.0) ** (1.0 / 3.0), rel=1e-14)
    curved, wide = panda_path(1), make_limits(*PANDA, 50.0 * PANDA[1])
    free = quickest_smooth(curved, wide)
    jerk = float(np.abs(free.jerk(np.linspace(0.0, free.duration, 5001))).max())
    tame = quickest_smooth(curved, wide, passage=Passage(jerk_max=0.1 * jerk))
    now = np.abs(tame.jerk(np.linspace(0.0, tame.duration, 20_001))).max()
    assert 0.08 * jerk < now <= 0.1 * jerk * (1.0 + 1e-6)
    assert max(use(curved, tame, wide)) <= 1.0 + 1e-6
    assert tame.duration > free.duration


@pytest.mark.property
@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), at=st.floats(0.02, 0.98), share=st.floats(0.2, 0.95))
def test_it_goes_on_from_any_motion_that_leaves_room(seed, at, share, make_limits):
    path, limits = drawn(seed, make_limits)
    whole = quickest_smooth(path, limits, cells=100)
    moving = whole.slower(share)
    s, speed, acceleration = moving.at(at * moving.duration)
    span = (s, path.domain[1])
    course = Passage(start_speed=speed, start_acceleration=acceleration)
    law = quickest_smooth(path, limits, span, passage=course)
    assert law.at(0.0)[:2] == pytest.approx((s, speed), rel=1e-9)
    rounding = 1e-9 * speed**2 / (span[1] - s)
    assert law.at(0.0)[2] == pytest.approx(acceleration, rel=1e-9, abs=rounding)
    assert law.s[-1] == path.domain[1]
    assert law.speed[-1] == 0.0
    assert max(use(path, law, limits)) <= 1.0 + 2e-6
    assert law.duration <= (1.0 - at) * moving.duration * 1.01


def test_it_ends_with_a_given_speed(panda_limits):
    path = panda_path(2)
    middle = 0.5 * sum(path.domain)
    passed = quickest_smooth(path, panda_limits)
    speed = 0.7 * passed.at(passed.time_at(middle))[1]
    first = quickest_smooth(
        path, panda_limits, (path.domain[0], middle), passage=Passage(end_speed=speed)
    )
    second = quickest_smooth(
        path, panda_limits, (middle, path.domain[1]), passage=Passage(start_speed=speed)
    )
    assert first.speed[-1] == pytest.approx(speed, rel=1e-12)
    assert abs(first.acceleration[-1]) <= 1e-9 * np.abs(first.acceleration).max()
    assert second.at(0.0) == pytest.approx((middle, speed, 0.0), rel=1e-12)
    for law in (first, second):
        assert max(use(path, law, panda_limits)) <= 1.0 + 1e-6
    both = first.duration + second.duration
    assert passed.duration * (1.0 - 1e-3) <= both <= passed.duration * 1.2


def test_it_starts_from_rest_with_an_acceleration(make_limits):
    path = straight_path(np.zeros(2), np.array([1.0, 2.0]))
    limits = make_limits([1.0, 1.0], [2.0, 2.0], [9.0, 9.0])
    law = quickest_smooth(path, limits, passage=Passage(start_acceleration=0.5), cells=600)
    assert law.at(0.0) == (0.0, 0.0, 0.5)
    assert max(use(path, law, limits)) <= 1.0 + 1e-6
    # a start with a = 1 of 2 saves half of the first jerk phase, tj = 2 / 9, less what it lacks
    # in speed then
    rest = quickest_smooth(path, limits).duration
    saved = 1.0 / 9.0
    behind = 0.5 * 9.0 * saved**2
    assert law.duration == pytest.approx(rest - saved + behind / 1.0 * 0.5, rel=0.02)
    assert law.duration < rest


def rounded_zigzag():
    """A tool's way of straights with rounded corners, whose parameter is even on the straights."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0], [2.0, 0.0]])
    share = np.linspace(0.0, 1.0, 13)[:-1, None]
    sides = [a + (b - a) * share for a, b in pairwise(corners)]
    points = np.vstack((*sides, corners[-1:]))
    knots = np.concatenate((np.zeros(5), np.linspace(0.0, 1.0, len(points) - 4), np.ones(5)))
    return JointPath(BSpline(knots, points, 5))


def test_the_tool_is_even_on_straights_and_slow_in_corners(make_limits):
    path = rounded_zigzag()
    limits = make_limits([10.0] * 2, [2.5] * 2, [60.0] * 2)

    def rate(s):
        return np.linalg.norm(path.sample(s)[1], axis=1)

    cap = SpeedCap(edges=np.array([0.0, 1.0]), speeds=np.array([0.5]), rate=rate)
    law = quickest_smooth(path, limits, cap=cap, cells=300)
    ts = np.linspace(0.0, law.duration, 20_001)
    s, speed, _ = law.sample(ts)
    tool = rate(s) * speed
    assert tool.max() <= 0.5 * (1.0 + 1e-6)
    assert max(use(path, law, limits)) <= 1.0 + 1e-6
    # the middles of the straights but the outer ones, where it starts and stops
    for middle in (1.5 / 4.0, 2.5 / 4.0):
        straight = np.abs(s - middle) < 0.04
        assert np.ptp(tool[straight]) <= 0.5 * 1e-9
        assert tool[straight].min() >= 0.5 * (1.0 - 1e-6)
    for first, last in ((0.15, 0.35), (0.4, 0.6), (0.65, 0.85)):
        assert tool[(s > first) & (s < last)].min() < 0.4, "a corner lies there"
    # smoothly: no limit is broken, and the acceleration of the joints does not jump
    qdd = Section(path, law).sample(ts)[2]
    assert np.abs(np.diff(qdd, axis=0)).max() <= 60.0 * law.duration / 20_000 * 1.01


def test_each_section_of_a_speed_cap_is_kept(panda_limits):
    path = panda_path(3)
    start, end = path.domain
    free = quickest_smooth(path, panda_limits)
    edges = np.linspace(start, end, 4)
    speeds = (end - start) / free.duration * np.array([0.4, np.inf, 0.8])

    def rate(s):
        return 1.0 + 0.5 * np.sin(20.0 * (s - start) / (end - start))

    law = quickest_smooth(path, panda_limits, cap=SpeedCap(edges=edges, speeds=speeds, rate=rate))
    s, speed, _ = law.sample(np.linspace(0.0, law.duration, 10_001))
    cell = np.clip(np.searchsorted(edges, s, side="right") - 1, 0, 2)
    assert (rate(s) * speed / speeds[cell]).max() <= 1.0 + 1e-5
    assert max(use(path, law, panda_limits)) <= 1.0 + 1e-6
    assert law.duration > free.duration


def test_a_part_of_a_path_can_be_timed(panda_limits):
    path = panda_path(5)
    start, end = path.domain
    span = (start + 0.21 * (end - start), start + 0.68 * (end - start))
    law = quickest_smooth(path, panda_limits, span)
    assert (law.s[0], law.s[-1]) == span
    assert max(use(path, law, panda_limits)) <= 1.0 + 1e-6


def test_a_third_derivative_may_jump_but_no_second(make_limits):
    rng = np.random.default_rng(3)
    points = rng.uniform(-1.0, 1.0, (6, 3))
    limits = make_limits([1.0] * 3, [3.0] * 3, [20.0] * 3)
    cubic = JointPath(interpolate(points, degree=3, parameters="uniform"))
    assert max(use(cubic, quickest_smooth(cubic, limits), limits)) <= 1.0 + 1e-6
    # with its knots twice a cubic is once differentiable
    knots = np.concatenate((np.zeros(4), [0.5, 0.5], np.ones(4)))
    bent = JointPath(BSpline(knots, points, 3))
    jump = np.ptp(bent.coefficients[:, 1], axis=0)
    assert jump.max() > 0.0
    with pytest.raises(CurveError, match=r"s = 0\.5: .*second derivative .* jumps"):
        quickest_smooth(bent, limits)
    # stopping there is a way out
    for span in ((0.0, 0.5), (0.5, 1.0)):
        law = quickest_smooth(bent, limits, span)
        assert max(use(bent, law, limits)) <= 1.0 + 1e-6


def test_joints_that_stay_take_no_time(make_limits):
    still = JointPath(interpolate(np.full((4, 2), 0.7), parameters="uniform"))
    limits = make_limits([1.0] * 2, [1.0] * 2, [1.0] * 2)
    assert quickest_smooth(still, limits).duration == 0.0
    # a part of a way on which nothing moves
    knots = np.concatenate((np.zeros(4), [0.25, 0.5, 0.75], np.ones(4)))
    points = np.array([[0.0, 0.0]] * 4 + [[0.2, 0.1], [0.6, 0.4], [1.0, 1.0]])
    path = JointPath(BSpline(knots, points, 3))
    assert quickest_smooth(path, limits, (0.0, 0.25)).duration == 0.0
    law = quickest_smooth(path, limits)
    assert max(use(path, law, limits)) <= 1.0 + 1e-6
    # of which the still part takes little, though the law leaves and reaches it at some speed
    rest = quickest_smooth(path, limits, (0.25, 1.0))
    assert law.duration <= rest.duration * 1.15


def test_what_makes_no_sense_is_refused(make_limits, panda_limits):
    path = panda_path(0)
    first, last = path.domain
    with pytest.raises(ValueError, match=r"limits: want a jerk, qddd_max; got none"):
        quickest_smooth(path, make_limits(*PANDA, None))
    with pytest.raises(ValueError, match=r"limits: want them for the 7 joints"):
        quickest_smooth(path, make_limits([1.0], [1.0], [1.0]))
    for span in ((0.5, 0.5), (first - 1.0, last), (first, last + 1.0), (np.nan, last)):
        with pytest.raises(ValueError, match=r"span: want a part of the path"):
            quickest_smooth(path, panda_limits, span)
    with pytest.raises(ValueError, match=r"cells: want at least 8, got 3"):
        quickest_smooth(path, panda_limits, cells=3)
    for wrong, name in (
        ({"start_speed": -1.0}, "start_speed"),
        ({"start_speed": np.nan}, "start_speed"),
        ({"end_speed": np.inf}, "end_speed"),
        ({"start_acceleration": np.nan}, "start_acceleration"),
        ({"start_acceleration": -1.0}, "start_acceleration"),
        ({"jerk_max": 0.0}, "jerk_max"),
    ):
        with pytest.raises(ValueError, match=rf"{name}: "):
            Passage(**wrong)


def test_a_start_beyond_the_limits_is_refused(make_limits):
    path = straight_path(np.zeros(2), np.array([1.0, 0.1]))
    limits = make_limits([1.0, 1.0], [2.0, 2.0], [9.0, 9.0])
    with pytest.raises(LimitError, match=r"'joint0': velocity .* at t = 0"):
        quickest_smooth(path, limits, passage=Passage(start_speed=1.1))
    with pytest.raises(LimitError, match=r"'joint0': velocity"):
        quickest_smooth(path, limits, passage=Passage(end_speed=1.1))
    with pytest.raises(LimitError, match=r"'joint0': acceleration"):
        quickest_smooth(path, limits, passage=Passage(start_speed=0.5, start_acceleration=2.1))
    # too fast to stop before the end
    with pytest.raises(CurveError, match=r"no motion within the limits"):
        quickest_smooth(path, limits, (0.9, 1.0), passage=Passage(start_speed=0.95))
