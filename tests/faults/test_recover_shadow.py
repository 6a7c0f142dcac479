"""A joint of two servos that is recovered: it sinks while they start anew, and is caught there."""

from dataclasses import replace

import numpy as np
import pytest

from splinearm.control.ending import Outcome
from splinearm.units import DEG


@pytest.mark.parametrize("boot_time", [0.2, 0.4, 0.5])
def test_an_arm_that_sinks_while_a_joint_of_two_servos_reboots_is_held_where_it_is(
    scene, boot_time
):
    one = scene("wx250s")
    for servo in one.virtual.all_servos:
        servo.choices = replace(servo.choices, boot_time=float(boot_time))
    one.enter()
    ending = one.follow(one.motion(), lambda: one.servo(2).fail("overload"))
    assert ending.stopped is not None
    before = one.virtual.q[1]
    one.arm.recover()
    assert one.virtual.q[1] > before + 10.0 * DEG  # leader and shadow begin anew together
    state = one.arm.read()
    np.testing.assert_allclose(state.q, one.arm.goal, atol=6.0 * DEG)
    assert np.abs(state.qd).max() <= 8.0 * DEG
    assert one.go_on(ending).outcome is Outcome.FINISHED
