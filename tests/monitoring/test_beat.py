"""How often, how evenly, and how well servos answer."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.drivers.bus import Loss
from splinearm.monitoring.beat import Beat
from splinearm.monitoring.tally import Tally


@pytest.mark.property
@given(
    period=st.floats(1e-3, 1.0),
    late=st.lists(st.floats(0.0, 0.4), min_size=2, max_size=50),
)
def test_jitter_is_how_far_periods_are_from_the_wanted_one(period, late):
    beat, times = Beat(1.0 / period), np.cumsum([period * (1.0 + share) for share in late])
    beat.strike(0.0)
    for t in times[:-1]:
        beat.strike(t)
    beat.strike(times[-1] + 10.0)  # figures are renewed now and then only
    apart = np.abs(np.diff([0.0, *times[:-1], times[-1] + 10.0]) - period)
    rhythm = beat.rhythm
    assert rhythm.rate == pytest.approx(len(late) / (times[-1] + 10.0))
    assert rhythm.jitter_max == pytest.approx(apart.max())
    assert rhythm.jitter_p50 == pytest.approx(np.median(apart))
    assert rhythm.jitter_p50 <= rhythm.jitter_p99 <= rhythm.jitter_max


def test_a_pause_is_no_jitter():
    beat = Beat(10.0)
    for t in (0.0, 0.1, 0.2):
        beat.strike(t)
    beat.pause()
    for t in (50.0, 50.1, 50.2):
        beat.strike(t)
    assert beat.rhythm.jitter_max == pytest.approx(0.0, abs=1e-9)
    assert beat.rhythm.rate == pytest.approx(10.0)


def test_one_beat_has_no_rate():
    beat = Beat()
    beat.strike(1.0)
    assert math.isnan(beat.rhythm.rate)


def counted(*losses):
    tally = Tally()
    for loss in losses:
        tally.note(loss)
    return tally


def test_every_answer_is_counted_and_what_is_hidden_is_nobodys_fault():
    stats = counted(None, Loss.SILENT, Loss.DAMAGED, Loss.HIDDEN, None).stats
    assert (stats.reads, stats.timeouts, stats.crc_errors) == (5, 1, 1)


def test_few_losses_are_chance_and_more_are_told():
    assert counted(*[None] * 100, *[Loss.DAMAGED] * 4).complaint is None
    code, cause = counted(*[None] * 100, *[Loss.DAMAGED] * 5).complaint
    assert (code, cause) == ("L07", "5 of its last 105 answers are damaged")
    assert counted(*[None] * 100, *[Loss.SILENT] * 9).complaint[0] == "L08"


def test_what_was_long_ago_is_forgiven():
    tally = counted(*[Loss.SILENT] * 20)
    assert tally.complaint is not None
    for _ in range(4000):
        tally.note(None)
    assert tally.complaint is None
    assert tally.stats.timeouts == 20
