"""The ramp in which wishes come in."""

import numpy as np
import pytest

from splinearm.config import load_cell
from splinearm.jogging.jogger import top_speeds
from splinearm.jogging.ramp import COMMITTED, Ramp


@pytest.mark.parametrize("jerk_time", [None, 0.2])
@pytest.mark.parametrize("period", [0.002, 0.01, 0.05])
def test_coming_to_full_speed_keeps_acceleration_and_jerk(period, jerk_time):
    cell = load_cell("wx250s")
    limits = cell.arm.limits
    if jerk_time is not None:
        limits = limits.with_jerk_time(jerk_time)
    speeds = top_speeds(cell)
    ramp = Ramp.of(limits, speeds, period)
    qd = ramp.weights[:, None] * speeds  # of a wish that stays
    qdd = np.diff(qd, axis=0) / period
    assert (np.abs(qdd) <= limits.qdd_max).all()
    if limits.qddd_max is not None:
        assert (np.abs(np.diff(qdd, axis=0)) / period <= limits.qddd_max).all()


def test_what_is_wished_comes_whole_and_never_back():
    cell = load_cell("planar_2r")
    ramp = Ramp.of(cell.arm.limits, top_speeds(cell), 0.01)
    assert not ramp.weights[:COMMITTED].any()
    assert ramp.weights[-1] == 1.0
    assert (np.diff(ramp.weights) >= 0.0).all()
    assert ramp.duration == pytest.approx(0.01 * np.argmax(ramp.weights == 1.0), abs=0.011)
