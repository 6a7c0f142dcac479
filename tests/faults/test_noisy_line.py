"""A line on which one byte in a hundred of what servos say is another: motions finish as usual."""

import numpy as np
import pytest
from fault_scene import Scene, Witness

from splinearm.control.ending import Outcome
from splinearm.control.servo_count import ServoCounter

pytestmark = pytest.mark.sim

SHARE = 0.01
GROWS = 1.05
"""By how much the tracking error may grow."""


def tracked(scene: Scene, noise: float) -> tuple[float, ServoCounter]:
    """Carry the motion out; give the root mean square of how far joints were off, rad."""
    scene.enter()
    motion, begun = scene.motion(), scene.virtual.rig.now
    counter = ServoCounter(scene.arm, scene.chain)
    if noise:
        scene.line("garbled", probability=noise)
    assert scene.follow(motion).outcome is Outcome.FINISHED
    scene.calm()
    seen = Witness(scene, motion, begun, scene.virtual.rig.now)
    rows = np.searchsorted(seen.t, [scene.time_of(cycle) for cycle in scene.cycles])
    there = rows < len(seen.t)
    wanted = np.array([cycle.setpoint.q for cycle in scene.cycles])
    error = seen.q[rows[there]] - wanted[there]
    return float(np.sqrt(np.mean(error**2))), counter


@pytest.mark.parametrize("arm", ["planar_2r", "wx250s"])
@pytest.mark.parametrize("seed", range(3))
def test_a_motion_finishes_as_well_and_each_servo_has_its_damaged_answers_counted(scene, arm, seed):
    usual, _ = tracked(scene(arm), 0.0)
    error, counter = tracked(scene(arm, seed=seed), SHARE)
    assert error < usual * GROWS
    counts = counter.counts()
    assert len(counts) == 2 or len(counts) == 6
    for one in counts:
        assert 0.02 * one.reads < one.crc_errors < 0.3 * one.reads
        assert one.timeouts < 0.02 * one.reads


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40))
def test_many_motions_finish(scene, seed):
    tracked(scene("wx250s", seed=seed), SHARE)
