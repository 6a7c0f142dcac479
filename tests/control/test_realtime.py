import gc
import os
import sys
import threading
import time

import numpy as np
import pytest

from splinearm.control import realtime
from splinearm.control.clock import StepClock, WallClock
from splinearm.control.realtime import Footing, real_time
from splinearm.control.rehearsal import RATES, UNSEEN_FIRST, Rehearsal, rehearse

linux = pytest.mark.skipif(sys.platform != "linux", reason="schedulers of Linux")


def of_this_thread():
    return (
        os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK,
        os.sched_getparam(0).sched_priority,
        sys.getswitchinterval(),
        gc.isenabled(),
    )


def fail_inside():
    with real_time():
        raise RuntimeError


@linux
def test_everything_is_given_back_also_after_an_error():
    before = of_this_thread()
    with real_time() as footing:
        inside = of_this_thread()
    assert of_this_thread() == before
    assert inside[:2] == ((os.SCHED_FIFO, 50) if footing.fifo else before[:2])
    assert not inside[3]
    with pytest.raises(RuntimeError):
        fail_inside()
    assert of_this_thread() == before


@linux
def test_what_is_started_meanwhile_is_of_normal_priority():
    seen = []
    with real_time():
        thread = threading.Thread(target=lambda: seen.append(os.sched_getscheduler(0)))
        thread.start()
        thread.join()
    assert seen == [os.SCHED_OTHER]


@linux
def test_a_system_that_permits_nothing_is_no_error_and_the_remedy_is_named(monkeypatch):
    def refuse(*_):
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    monkeypatch.setattr(realtime, "_may_lock_all", lambda: False)
    with real_time() as footing:
        assert footing == Footing(fifo=False, locked=False)
    for word in ("no real-time priority", "limits.conf", "ulimit -r", "setcap"):
        assert word in footing.words
    assert "\n" not in footing.words


@linux
def test_priority_that_cannot_be_given_back_whole_leaves_children_normal(monkeypatch):
    calls = []

    def as_a_user(pid, policy, param):
        calls.append(policy)
        if calls[0] & os.SCHED_RESET_ON_FORK and not policy & os.SCHED_RESET_ON_FORK:
            raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", as_a_user)
    with real_time() as footing:
        assert footing.fifo
    assert calls[-1] == os.SCHED_OTHER | os.SCHED_RESET_ON_FORK


def test_words_say_what_is_missing():
    assert "memory locked" in Footing(fifo=True, locked=True).words
    if sys.platform == "linux":
        assert "memory not locked" in Footing(fifo=True, locked=False).words


def test_elsewhere_nothing_is_done_and_that_is_said(monkeypatch):
    monkeypatch.setattr(sys, "platform", "darwin")
    with real_time() as footing:
        assert not footing.fifo
        assert "Linux only" in footing.words


def test_a_clock_that_spins_is_not_early_and_sleeps_now_and_then(monkeypatch):
    slept = []
    sleep = time.sleep
    monkeypatch.setattr(time, "sleep", lambda s: (slept.append(s), sleep(s)))
    clock = WallClock(spin=150e-6)
    end = clock.now() + 0.5
    while clock.now() < end:
        due = clock.now() + 100e-6  # sooner than it wakes: it would spin for ever
        clock.wait_until(due)
        assert clock.now() >= due
    assert slept


def numbers(*values):
    return np.array(values)


@pytest.mark.parametrize(
    ("late", "busy", "wanted", "rate"),
    [
        (10e-6, 100e-6, 1000.0, 1000.0),
        (10e-6, 900e-6, 1000.0, 800.0),
        (4e-3, 100e-6, 1000.0, 60.0),
        (4e-3, 100e-6, 62.0, 62.0),
        (60e-3, 100e-6, 100.0, None),
        (0.0, 0.0, 777.0, 777.0),
    ],
)
def test_the_rate_follows_from_the_latest_waking_and_the_work(late, busy, wanted, rate):
    tried = Rehearsal(numbers(0.0, late), numbers(busy, busy))
    assert tried.rate(wanted) == rate


def test_a_thread_that_goes_before_all_others_is_trusted_more():
    tried = Rehearsal(numbers(0.3e-3), numbers(100e-6))
    assert tried.rate(1000.0, UNSEEN_FIRST) == 1000.0
    assert tried.rate(1000.0) == 800.0


def test_rates_fall():
    assert list(RATES) == sorted(RATES, reverse=True)


def test_a_rehearsal_runs_cycles_and_times_the_work():
    now, count = [0.0], [0]
    clock = StepClock(lambda dt: now.__setitem__(0, now[0] + dt), lambda: now[0])

    def work():
        count[0] += 1

    tried = rehearse(clock, 0.01, work, 0.5)
    assert count[0] == len(tried.busy) == len(tried.lateness) == 50
    assert now[0] == pytest.approx(0.5)
    assert (tried.lateness == 0.0).all()
    assert (tried.busy >= 0.0).all()
