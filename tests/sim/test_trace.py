"""The motion of a shaft, written down."""

import numpy as np
import pytest

from splinearm.sim.trace import Trace


def test_it_is_the_motion_of_the_shaft(bench):
    bench.servo.trace = Trace()
    bench.set("Profile Velocity", 40)
    bench.set("Profile Acceleration", 20)
    bench.set("Torque Enable", 1)
    bench.set("Goal Position", 2500)
    bench.run(1.5)
    motion = bench.servo.trace.motion()
    assert len(bench.servo.trace) == len(motion.t) == 1500
    np.testing.assert_allclose(np.diff(motion.t), 1e-3)
    # each row is the state at the begin of its millisecond
    np.testing.assert_allclose(motion.angle[1:], motion.angle[:-1] + motion.speed[1:] * 1e-3)
    limit = 40 * 0.229 / 60 * 2 * np.pi
    assert motion.speed.max() < 1.2 * limit
    assert motion.acceleration.max() < 20.0
    assert motion.torque_on.all()


def test_its_late_part_can_be_had(bench):
    bench.servo.trace = Trace()
    bench.run(0.1)
    late = bench.servo.trace.motion().after(0.0505)
    assert late.t[0] == pytest.approx(0.051)
    assert not late.torque_on.any()


@pytest.mark.parametrize("rows", [0, 1])
def test_of_too_few_rows_the_acceleration_is_nothing(rows):
    trace = Trace()
    for _ in range(rows):
        trace.add(0.0, 0.0, 1.0, False)
    assert trace.motion().acceleration.tolist() == [0.0] * rows
