import os
import sys
import threading

import pytest

from splinearm.control.aside import Aside


def test_calls_are_made_in_their_order_in_another_thread_and_none_is_lost():
    seen, threads = [], set()

    def look(value):
        seen.append(value)
        threads.add(threading.current_thread())

    with Aside() as aside:
        leave = aside.later(look)
        for value in range(1000):
            leave(value)
    assert seen == list(range(1000))
    assert threading.current_thread() not in threads
    assert aside.trouble is None


def test_a_call_that_fails_is_kept_and_the_others_go_on(caplog):
    seen = []

    def fail(value):
        raise KeyError(value)

    with Aside() as aside:
        failing, fine = aside.later(fail), aside.later(seen.append)
        for value in range(3):
            failing(value)
            fine(value)
    assert seen == [0, 1, 2]
    assert isinstance(aside.trouble, KeyError)
    assert caplog.text.count("left out") == 1


def test_an_error_inside_comes_through():
    with pytest.raises(RuntimeError), Aside():
        raise RuntimeError


@pytest.mark.skipif(sys.platform != "linux", reason="schedulers of Linux")
def test_it_hurries_only_where_that_is_permitted(monkeypatch):
    asked = []

    def refuse(thread, policy, param):
        asked.append((thread, policy, param.sched_priority))
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    seen = []
    with Aside() as aside:
        aside.hurry()
        aside.later(seen.append)(1)
        thread = aside._thread.native_id
    assert seen == [1]
    assert asked == [(thread, os.SCHED_FIFO, 1)]
