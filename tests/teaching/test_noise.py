"""Samples that are wrong are found, and no others; noise goes, the motion stays."""

import numpy as np
import pytest

from splinearm.teaching.noise import clean
from splinearm.units import DEG

NEAR = 0.5 * DEG


@pytest.mark.parametrize("seed", range(4))
def test_exactly_the_wrong_samples_are_found(cell, hand, seed):
    led = hand(seconds=8.0, wrong=4).leads(cell, seed)
    found = clean(led.t, led.q, np.full(cell.arm.n, NEAR))
    off = (np.abs(led.q - led.true) > 1.0 * DEG).any(axis=1)
    np.testing.assert_array_equal(found.wrong, np.flatnonzero(off))


def test_what_is_left_is_nearer_to_the_truth_than_the_samples(cell, hand):
    led = hand(tremor_deg=0.0, wrong=0).leads(cell, 1)
    found = clean(led.t, led.q, np.full(cell.arm.n, NEAR))
    calm = found.curve.at(led.t)
    assert not found.wrong.size
    assert (calm - led.true).std() < 0.6 * (led.q - led.true).std()
    assert np.abs(calm - led.true).max() < 0.15 * DEG


def test_a_jump_that_lasts_is_a_motion(planar):
    t = np.arange(200) / 100.0
    q = np.zeros((200, 2))
    q[100:105] = 10.0 * DEG
    found = clean(t, q, np.full(2, NEAR))
    assert not np.isin(np.arange(100, 105), found.wrong).any()


def test_times_need_not_be_even(planar, hand):
    led = hand(seconds=6.0, wrong=2).leads(planar, 3)
    kept = np.sort(np.random.default_rng(0).choice(len(led.t), 420, replace=False))
    found = clean(led.t[kept], led.q[kept], np.full(2, NEAR))
    off = (np.abs(led.q - led.true)[kept] > 1.0 * DEG).any(axis=1)
    assert set(np.flatnonzero(off)[1:-1]) <= set(found.wrong)
