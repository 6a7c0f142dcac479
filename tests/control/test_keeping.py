"""A loop that lowers its rate on the way, and stays on its path."""

import numpy as np
import pytest

from splinearm.control.follow import Loop
from splinearm.control.follow import Outcome as Done
from splinearm.control.keeping import RateKeeper
from splinearm.control.report import report_loop
from splinearm.trajectories.plan import plan_joint_move


class SlowClock:
    """A computer that wakes late by ``late`` in every ``every``th cycle."""

    def __init__(self, arm, late: float, every: int) -> None:
        self.arm, self.late, self.every, self.wakings = arm, late, every, 0

    def now(self) -> float:
        return self.arm.now

    def wait_until(self, t: float) -> float:
        self.wakings += 1
        late = self.late if self.wakings % self.every == 0 else 0.0
        self.arm.now = max(self.arm.now, t + late)
        return self.arm.now - t


def follow(arm, guard, limits, clock):
    cycles, said = [], []
    motion = plan_joint_move(limits, arm.goal, np.array([1.5, -1.5]))
    loop = Loop(driver=arm, clock=clock, guard=guard, observe=cycles.append, announce=said.append)
    return loop.follow(motion), cycles, said, motion


def test_a_loop_that_is_often_late_goes_on_at_a_rate_that_it_holds(arm, guard, limits):
    outcome, cycles, said, motion = follow(arm, guard, limits, SlowClock(arm, 0.014, 5))
    assert outcome is Done.FINISHED
    assert [text for text in said if "setpoints a second" in text] == [
        "this computer wakes up to 14.0 ms late: going on at 33 setpoints a second; "
        "the path stays the same"
    ]
    assert cycles[-1].stride == 3
    assert {c.index - b.index for b, c in zip(cycles[-20:], cycles[-19:], strict=False)} == {3}
    assert report_loop(cycles, 0.01).missed == 3
    for cycle in cycles:
        np.testing.assert_allclose(cycle.setpoint.q, motion.at(min(cycle.t, motion.duration)).q)


def test_a_loop_that_is_late_now_and_then_keeps_its_rate(arm, guard, limits):
    outcome, cycles, said, _ = follow(arm, guard, limits, SlowClock(arm, 0.014, 60))
    assert outcome is Done.FINISHED
    assert not [text for text in said if "setpoints a second" in text]
    assert cycles[-1].stride == 1


def test_the_rate_is_lowered_further_but_never_below_what_the_watchdog_bears():
    keeper = RateKeeper(0.005)
    for k in range(2):
        assert keeper.note(0.01 * k, 0.006) is None
    assert keeper.note(0.02, 0.0061) == pytest.approx(0.0061)
    assert keeper.stride == 2
    assert keeper.note(0.03, 0.006) is None  # no longer late
    for k in range(3):
        keeper.note(0.1 + 0.01 * k, 1.0)
    assert keeper.stride == 6
    for k in range(9):
        assert keeper.note(0.2 + 0.01 * k, 1.0) is None
    assert RateKeeper(0.05).rate == pytest.approx(20.0)


def test_lateness_long_ago_does_not_count():
    keeper = RateKeeper(0.01)
    assert [keeper.note(float(2 * k), 0.02) for k in range(9)] == [None] * 9
