import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.trajectories.smooth_law import SmoothLaw, cell_times
from splinearm.trajectories.smooth_motion import circular
from splinearm.trajectories.smooth_straight import double_s

pytestmark = pytest.mark.kernel


def law_of(growth, lengths, x, u):
    """Four cells with growth between a launch and a landing of even jerk."""
    h, y = np.array(lengths), [(x, u)]
    for c, step in zip(growth, h, strict=True):
        x, u = x + 2.0 * u * step + c * step**2, u + c * step
        y.append((x, u))
    speed = np.sqrt([x for x, _ in y])
    t = np.concatenate(([0.0], np.cumsum(cell_times(h, speed, np.array(growth)))))
    return SmoothLaw(
        s=np.concatenate(([0.3], 0.3 + np.cumsum(h))),
        t=t,
        speed=speed,
        acceleration=np.array([u for _, u in y]),
        jerks=np.zeros(len(h)),
        growth=np.array(growth),
    )


@pytest.fixture
def law():
    """Growth large, small and zero, of both signs."""
    return law_of([4.0, -9.0, 0.0, 1e-9, -1e-4, 30.0], [0.2, 0.3, 0.3, 0.3, 0.1, 0.2], 3.0, 0.7)


@pytest.mark.property
@given(z=st.floats(-9.0, 30.0), t=st.floats(1e-3, 1e3))
def test_circular_functions_are_right_to_rounding(z, t):
    even, odd, next_even = circular(z / t**2, t)
    k = np.lib.scimath.sqrt(z)
    want = np.cosh(k).real, t * (np.sinh(k) / k).real if z else t
    assert even == pytest.approx(want[0], rel=1e-14, abs=1e-14)
    assert odd == pytest.approx(want[1], rel=1e-13, abs=1e-14 * t)
    # (cosh - 1) / c from its half angle, which loses nothing
    half = 0.5 * t * (2.0 * np.sinh(0.5 * k) / k).real if z else 0.5 * t
    assert next_even == pytest.approx(2.0 * half**2, rel=1e-13)


def test_cells_end_where_the_next_begin(law):
    for k in range(1, len(law.t)):
        before = np.nextafter(law.t[k], 0.0)
        state = law.at(before)
        assert state[0] == pytest.approx(law.s[k], rel=1e-14)
        assert state[1] == pytest.approx(law.speed[k], rel=1e-13)
        assert state[2] == pytest.approx(law.acceleration[k], abs=1e-12)


def test_derivatives_are_those_of_differences(law):
    step = 1e-5
    ts = np.linspace(2 * step, law.duration - 2 * step, 400)
    ts = ts[np.abs(ts[:, None] - law.t).min(axis=1) > 2 * step]
    now, later, before = law.states(ts), law.states(ts + step), law.states(ts - step)
    for k in range(3):
        slope = (later[k] - before[k]) / (2 * step)
        scale = np.abs(now[k + 1]).max()
        assert np.abs(slope - now[k + 1]).max() <= 1e-8 * scale


def test_one_and_many_times_agree_in_any_order(law):
    rng = np.random.default_rng(0)
    ts = rng.permutation(np.concatenate((np.linspace(0.0, law.duration, 101), law.t)))
    many = law.states(ts)
    for k, t in enumerate(ts.tolist()):
        assert law.state(t) == pytest.approx(tuple(many[:, k]), rel=1e-13, abs=1e-13)
        assert law.at(t) == law.state(t)[:3]
    assert np.array_equal(law.jerk(ts), many[3])
    assert np.array_equal(np.stack(law.sample(ts)), many[:3])


def test_the_time_of_a_place_is_found(law):
    whole = double_s(0.0, 1.0, 1.0, 2.0, 9.0)
    for one in (law, whole):
        for t in np.linspace(0.0, one.duration, 41):
            s, speed, _ = one.at(t)
            assert one.at(one.time_at(s))[0] == pytest.approx(s, rel=1e-14, abs=1e-15)
            if speed > 1e-3:
                assert one.time_at(s) == pytest.approx(t, rel=1e-12, abs=1e-12)
        assert one.time_at(one.s[0] - 1.0) == 0.0
        assert one.time_at(one.s[-1] + 1.0) == one.duration


def test_slower_backwards_and_in_parts_it_is_the_same_motion(law):
    ts = np.linspace(0.0, law.duration, 77)
    s, speed, acceleration, jerk = law.states(ts)
    slow = law.slower(0.25).states(4.0 * ts)
    assert np.allclose(slow, [s, speed / 4, acceleration / 16, jerk / 64], rtol=1e-12, atol=1e-13)
    back = law.reversed().states((law.duration - ts)[1:-1])
    want = law.s[0] + law.s[-1] - s, speed, -acceleration, jerk
    inner = np.abs(ts[:, None] - law.t).min(axis=1)[1:-1] > 1e-9
    assert np.allclose(back[:, inner], np.array(want)[:, 1:-1][:, inner], rtol=1e-12, atol=1e-12)
    part = law.between(0.3 * law.duration, 0.8 * law.duration)
    within = (ts > 0.3 * law.duration) & (ts < 0.8 * law.duration)
    got = part.states(ts[within] - 0.3 * law.duration)
    assert np.allclose(got, law.states(ts[within]), rtol=1e-12, atol=1e-12)
    assert law.between(0.5, 0.5).duration == 0.0


def test_a_rest_takes_no_time():
    rest = SmoothLaw.resting(0.7)
    assert rest.duration == 0.0
    assert rest.at(0.0) == (0.7, 0.0, 0.0)
    assert rest.states(np.zeros(2)).tolist() == [[0.7, 0.7], [0.0] * 2, [0.0] * 2, [0.0] * 2]
    assert rest.time_at(0.7) == 0.0


def test_what_makes_no_law_is_refused(law):
    fields = {
        "s": law.s,
        "t": law.t,
        "speed": law.speed,
        "acceleration": law.acceleration,
        "jerks": law.jerks,
        "growth": law.growth,
    }
    for wrong in (
        {"t": law.t[::-1]},
        {"t": law.t + 1.0},
        {"speed": law.speed[1:]},
        {"s": np.full(len(law.s), np.nan)},
        {"jerks": np.ones(len(law.growth))},
    ):
        name = next(iter(wrong))
        with pytest.raises(ValueError, match=name):
            SmoothLaw(**{**fields, **wrong})


@pytest.mark.property
@settings(max_examples=100)
@given(
    way=st.floats(1e-3, 1e3),
    speed=st.floats(0.1, 1e2),
    acceleration=st.floats(0.1, 1e3),
    jerk=st.floats(0.1, 1e4),
)
def test_double_s_reaches_its_end_within_its_limits(way, speed, acceleration, jerk):
    law = double_s(1.0, 1.0 + way, speed, acceleration, jerk)
    before = law.states(np.array([np.nextafter(law.duration, 0.0)]))[:, 0]
    assert before[0] == pytest.approx(1.0 + way, rel=1e-12)
    assert before[1] == pytest.approx(0.0, abs=1e-9 * law.speed.max())
    s, v, a, j = law.states(np.linspace(0.0, law.duration, 2001))
    assert v.max() <= speed * (1.0 + 1e-12)
    assert np.abs(a).max() <= acceleration * (1.0 + 1e-12)
    assert np.abs(j).max() <= jerk * (1.0 + 1e-12)
    assert (np.diff(s) >= -1e-13 * (1.0 + way)).all()


KERNELS = """
import numpy as np
from splinearm.curves.interpolation import interpolate
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.dh import DHConvention, DHLink
from splinearm.kinematics.dynamics import Drives, Dynamics
from splinearm.kinematics.link import Inertia
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.limit import MotionLimits
from splinearm.trajectories.smooth_timing import Passage, quickest_smooth

path = JointPath(interpolate(np.random.default_rng(1).uniform(-1, 1, (5, 2)), degree=5))
names, ones = ("a", "b"), np.ones(2)
limits = JointLimits(names=names, kinds=(JointKind.REVOLUTE,) * 2, q_min=-9 * ones,
    q_max=9 * ones, qd_max=ones, qdd_max=3 * ones, qddd_max=30 * ones, torque_max=[12.0, 4.0])
links = [DHLink(name, a=0.4, alpha=1.0, d=0.0, theta=0.0) for name in names]
bodies = [Inertia(1.5, np.array([-0.2, 0.0, 0.0]), 0.02 * np.eye(3))] * 2
arm = Arm.from_dh("2R", links, DHConvention.STANDARD, limits, inertias=bodies)
every = MotionLimits(joints=limits, dynamics=Dynamics(arm, drives=Drives(viscous=0.5 * ones)),
    tool_acceleration=0.8)
found = []
for some, passage in ((limits, Passage(jerk_max=1e3)), (every, None)):
    law = quickest_smooth(path, some, passage=passage, cells=8)
    found += [law.s, law.t, law.speed, law.growth]
    found.append(law.states(np.linspace(0, law.duration, 50)).ravel())
"""


def test_compiled_and_plain_kernels_agree(compiled_as_plain):
    compiled_as_plain(KERNELS, 10, rtol=1e-9, atol=1e-9)
