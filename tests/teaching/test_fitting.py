"""What a hand led becomes a motion: few control points, near everywhere, within the limits."""

from dataclasses import replace

import numpy as np
import pytest

from splinearm.errors import CurveError, LimitError, StillError
from splinearm.teaching.fitting import FitRule, fit_recording
from splinearm.teaching.recording import Nearness
from splinearm.trajectories.taught import TIMINGS, plan_taught
from splinearm.units import DEG, MM


def off_by(cell, fitted, t, wanted):
    """How far tool, m, and joints, rad, of a motion are off what was measured, by the clock."""
    motion = fitted.motion
    t = t - fitted.start
    u, since = t, 0.0
    for place, seconds in motion.rests:
        u = np.where(t > place + since, np.maximum(t - since - seconds, place), u)
        since += seconds
    found = motion.curve.at(np.clip(u, 0.0, motion.moving))
    fk = cell.arm.fk
    tool = np.linalg.norm(fk(found)[:, :3, 3] - fk(wanted)[:, :3, 3], axis=1)
    return tool, np.abs(found - wanted).max(axis=1)


def wrong_at(led):
    return (np.abs(led.q - led.true) > 1.0 * DEG).any(axis=1)


@pytest.mark.parametrize("seed", range(2))
def test_few_control_points_are_near_every_sample(cell, hand, recording_of, seed):
    led = hand().leads(cell, seed)
    fitted = fit_recording(recording_of(cell, led.t, led.q), cell.arm)
    assert fitted.points <= fitted.samples / 10
    found = np.round(np.array(fitted.wrong) * 100)
    np.testing.assert_array_equal(found, np.flatnonzero(wrong_at(led)))
    assert fitted.scattered <= 3
    end = fitted.start + fitted.motion.duration
    kept = ~wrong_at(led) & (led.t >= fitted.start) & (led.t <= end)
    tool, joints = off_by(cell, fitted, led.t[kept], led.q[kept])
    # what scatters is told and may be farther off
    assert (tool > 1.0 * MM).sum() <= fitted.scattered
    assert (joints > 0.5 * DEG).sum() == 0


def test_pauses_are_kept_with_their_lengths_and_still_ends_cut(cell, hand, recording_of):
    led = hand(tremor_deg=0.005, wrong=0).leads(cell, 2)
    fitted = fit_recording(recording_of(cell, led.t, led.q), cell.arm)
    lasting = [seconds for _, seconds in fitted.motion.rests]
    for _, wanted in led.pauses:
        assert min(abs(wanted - found) for found in lasting) < 0.45
    assert sum(lasting) >= sum(length for _, length in led.pauses)
    assert fitted.motion.duration < led.t[-1] - 0.3


def test_no_limit_is_broken_at_any_share_of_them(cell, hand, recording_of):
    led = hand(seconds=6.0, pauses=1).leads(cell, 4)
    motion = fit_recording(recording_of(cell, led.t, led.q), cell.arm).motion
    for share in (0.1, 0.4, 1.0):
        limits = cell.arm.limits.scaled(share)
        slow, fast = (plan_taught(motion, cell.arm, limits, timing=x) for x in TIMINGS)
        for plan in (slow, fast):
            for peak in plan.peaks():
                assert abs(peak.value) <= abs(peak.limit) * (1 + 1e-9), peak
        assert fast.trajectory.duration <= slow.trajectory.duration * 1.01
        assert slow.trajectory.duration >= motion.duration


def test_where_jerk_is_limited_the_motion_is_smoother(planar, hand, recording_of):
    led = hand(seconds=6.0, pauses=1).leads(planar, 5)
    fitted = fit_recording(recording_of(planar, led.t, led.q), planar.arm, FitRule(smooth=True))
    assert fitted.motion.degree == 5
    assert (np.diff(fitted.motion.knots[6:-6]) > 0.0).all()
    limits = planar.arm.limits.with_jerk_time(0.1)
    for timing in TIMINGS:
        for peak in plan_taught(fitted.motion, planar.arm, limits, timing=timing).peaks():
            assert abs(peak.value) <= abs(peak.limit) * (1 + 1e-6), peak


def test_a_larger_tolerance_needs_fewer_points(planar, hand, recording_of):
    led = hand(seconds=6.0).leads(planar, 6)
    recording = recording_of(planar, led.t, led.q)
    wide = FitRule(nearness=Nearness(tool=8.0 * MM, joint=2.0 * DEG))
    few, more = fit_recording(recording, planar.arm, wide), fit_recording(recording, planar.arm)
    assert few.points < more.points
    assert "8 mm" in few.motion.words


def test_a_little_beyond_a_limit_is_moved_to_it_and_told(planar, recording_of):
    limits = planar.arm.limits
    t = np.arange(300) / 100.0
    x = np.clip(t / 1.5, 0.0, 1.0)
    swing = 10 * x**3 - 15 * x**4 + 6 * x**5
    q = np.column_stack((limits.q_max[0] - 0.6 + (0.6 + 0.1 * DEG) * swing, 0.5 * swing))
    fitted = fit_recording(recording_of(planar, t, q), planar.arm)
    assert any("beyond its limit" in words and "joint1" in words for words in fitted.words)
    assert fitted.motion.points[:, 0].max() <= limits.q_max[0] + 1e-12
    q[:, 0] += 2.0 * DEG * swing
    with pytest.raises(LimitError, match=r"joint1.* t = "):
        fit_recording(recording_of(planar, t, q), planar.arm)


def test_a_recording_in_which_nothing_moves_is_refused(planar, recording_of):
    t = np.arange(300) / 100.0
    q = np.tile(planar.poses["home"], (300, 1))
    with pytest.raises(StillError, match="nothing moves"):
        fit_recording(recording_of(planar, t, q), planar.arm)
    with pytest.raises(StillError, match="nothing moves"):
        fit_recording(recording_of(planar, t[:5], q[:5]), planar.arm)


def test_a_clock_that_was_set_meanwhile_is_told_and_samples_may_come_in_bursts(
    planar, hand, recording_of
):
    led = hand(seconds=5.0, pauses=1, wrong=0).leads(planar, 7)
    jumped = np.where(led.t > 2.5, led.t + 1e7, led.t)
    with pytest.raises(CurveError, match=r"lasts 1e\+07 s, a piece at most 3600 s"):
        fit_recording(recording_of(planar, jumped, led.q), planar.arm)
    t = np.sort(np.concatenate((led.t, led.t + 1e-7)))
    once = fit_recording(recording_of(planar, led.t, led.q), planar.arm)
    twice = fit_recording(recording_of(planar, t, led.q.repeat(2, axis=0)), planar.arm)
    assert twice.motion.duration == pytest.approx(once.motion.duration, abs=0.1)
    assert twice.points <= len(led.t) / 10


def test_a_recording_of_another_arm_is_refused(planar, recording_of):
    recording = recording_of(planar, np.arange(20.0), np.zeros((20, 2)))
    other = replace(recording, names=("a", "b"))
    with pytest.raises(ValueError, match="want joints"):
        fit_recording(other, planar.arm)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("tremor_deg", [0.0, 0.03])
def test_many_hands(cell, hand, recording_of, seed, tremor_deg):
    led = hand(seconds=25.0, pauses=3, wrong=8, tremor_deg=tremor_deg).leads(cell, 100 + seed)
    fitted = fit_recording(recording_of(cell, led.t, led.q), cell.arm)
    assert fitted.points <= fitted.samples / 10
    end = fitted.start + fitted.motion.duration
    kept = ~wrong_at(led) & (led.t >= fitted.start) & (led.t <= end)
    tool, joints = off_by(cell, fitted, led.t[kept], led.q[kept])
    assert (tool > 1.0 * MM).sum() <= fitted.scattered
    assert (joints > 0.5 * DEG).sum() == 0
    for share in (0.1, 0.3, 1.0):
        limits = cell.arm.limits.scaled(share)
        for timing in TIMINGS:
            plan = plan_taught(fitted.motion, cell.arm, limits, timing=timing)
            for peak in plan.peaks():
                assert abs(peak.value) <= abs(peak.limit) * (1 + 1e-9), peak
