"""A stop that is asked for: along the path, in the time that was announced, and on from there."""

import numpy as np
import pytest
from fault_scene import Witness, require_setpoints_within_limits, torque_lost

from splinearm.control.ending import Outcome
from splinearm.control.forecast import forecast_stops
from splinearm.control.stop import StopRequest
from splinearm.units import DEG, MM

pytestmark = pytest.mark.sim

OFF, TOOL_OFF = 0.1 * DEG, 0.1 * MM
USUAL: dict[str, tuple[float, float]] = {}


def usual(scene, arm: str) -> tuple[float, float]:
    """Give how far joints and tool are off the path when nothing is wrong."""
    if arm not in USUAL:
        here = scene(arm)
        here.enter()
        motion, begun = here.motion(), here.virtual.rig.now
        here.follow(motion)
        USUAL[arm] = off(here, motion, begun)
    return USUAL[arm]


def off(scene, motion, begun: float) -> tuple[float, float]:
    seen = Witness(scene, motion, begun, scene.virtual.rig.now)
    return seen.off_path(range(len(scene.joints))).max(), seen.tool_off_path().max()


@pytest.mark.parametrize("arm", ["planar_2r", "wx250s"])
@pytest.mark.parametrize("at", [3, 12, 25, 47, 68, 90, 115])
def test_the_arm_stays_as_near_to_its_path_as_ever_and_stops_in_the_time_announced(scene, arm, at):
    joints_off, tool_off = usual(scene, arm)
    here = scene(arm)
    here.enter()
    motion, begun, stop = here.motion(), here.virtual.rig.now, StopRequest()
    forecast = forecast_stops(motion)
    ending = here.follow(motion, stop.request, at, stop)
    assert ending.outcome is Outcome.STOPPED
    assert (here.cycles[-1].index - at - 1) / here.rate <= forecast.time + 1.0 / here.rate
    here.wait(0.3)
    worst, tool_worst = off(here, motion, begun)
    assert worst <= joints_off + OFF
    assert tool_worst <= tool_off + TOOL_OFF
    assert not torque_lost(here)
    assert here.go_on(ending).outcome is Outcome.FINISHED
    here.wait(0.5)
    assert np.abs(here.virtual.q - motion.q_goal).max() < 0.5 * DEG
    require_setpoints_within_limits(here)
