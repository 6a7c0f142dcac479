"""The progress bar of a motion under way."""

import numpy as np
import pytest

from splinearm.cli.motion_bar import MotionBar
from splinearm.control.cycle import Cycle
from splinearm.joints import JointSetpoint


def cycle(t: float) -> Cycle:
    still = np.zeros(1)
    setpoint = JointSetpoint(t=t, q=still, qd=still, qdd=still)
    return Cycle(index=0, t=9.0, lateness=0.0, setpoint=setpoint, state=None, busy=0.0)


def test_it_is_where_its_motion_is_and_begins_anew_with_each_and_each_round():
    sent = []
    first, second = object(), object()
    with MotionBar(sent.append) as bar:

        def shown(motion, name, t):
            bar.show(motion, name, 2.0, cycle(t))
            task = bar._bar.tasks[0]
            return task.description, task.completed

        assert shown(first, "one", 0.5) == ("one", 0.5)
        assert shown(first, "one", 0.6) == ("one", 0.5)  # drawn four times a second
        assert shown(first, "one", 0.8) == ("one", 0.8)
        assert shown(second, "two", 1.0) == ("two", 1.0)
        assert shown(second, "two", 0.0) == ("two", 0.0)
        shown(second, "two", 0.2)
    assert bar._bar.tasks[0].percentage == pytest.approx(10.0)  # where it was left, not at its end
    assert [each.setpoint.t for each in sent] == [0.5, 0.6, 0.8, 1.0, 0.0, 0.2]
