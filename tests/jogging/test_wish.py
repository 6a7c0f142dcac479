"""Wishes laid down by any thread."""

import time

import numpy as np

from splinearm.jogging.wish import Desk, Wish


def _wish(lasts=1.0):
    return Wish(rates=np.zeros(2), frame=None, lasts=lasts)


def test_only_the_newest_wish_counts_and_it_is_taken_once():
    desk, last = Desk(), _wish()
    desk.lay(_wish())
    desk.lay(last)
    assert desk.take() == (False, last)
    assert desk.take() == (False, None)


def test_braking_forgets_what_was_wished_before_but_not_after():
    desk, after = Desk(), _wish()
    desk.lay(_wish())
    desk.brake()
    assert desk.take() == (True, None)
    desk.brake()
    desk.lay(after)
    assert desk.take() == (True, after)


def test_a_wish_that_lay_too_long_is_none_any_more():
    desk = Desk()
    desk.lay(_wish(lasts=0.01))
    time.sleep(0.02)
    assert desk.take() == (False, None)
