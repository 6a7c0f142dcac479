import time

from splinearm.control.clock import StepClock, WallClock


def test_a_wall_clock_waits_until_the_time_and_says_how_late_it_is():
    clock = WallClock()
    due = clock.now() + 0.02
    lateness = clock.wait_until(due)
    assert clock.now() >= due
    assert 0.0 <= lateness <= clock.now() - due


def test_a_wall_clock_that_is_asked_too_late_says_so_at_once():
    clock = WallClock()
    assert clock.wait_until(clock.now() - 1.0) >= 1.0


def test_a_step_clock_steps_the_arm_by_what_is_missing():
    steps: list[float] = []
    clock = StepClock(steps.append, lambda: sum(steps))
    assert clock.wait_until(0.25) == 0.0
    assert clock.wait_until(0.75) == 0.0
    assert steps == [0.25, 0.5]
    assert clock.now() == 0.75


def test_a_step_clock_never_steps_back():
    steps: list[float] = []
    clock = StepClock(steps.append, lambda: sum(steps))
    clock.wait_until(0.5)
    clock.wait_until(0.25)
    assert steps == [0.5]


def test_a_step_clock_in_real_time_keeps_pace_with_the_wall():
    steps: list[float] = []
    clock = StepClock(steps.append, lambda: sum(steps), realtime=True)
    before = time.monotonic()
    clock.wait_until(0.03)
    assert time.monotonic() - before >= 0.03


def test_a_step_clock_in_real_time_does_not_make_up_for_time_before_it_was_asked():
    steps: list[float] = []
    clock = StepClock(steps.append, lambda: sum(steps), realtime=True)
    time.sleep(0.3)
    before = time.monotonic()
    assert clock.now() == 0.0
    clock.wait_until(0.03)
    assert time.monotonic() - before >= 0.03
