"""Arms to jog without a driver, and with MuJoCo."""

from dataclasses import replace

import numpy as np
import pytest

from splinearm.config import load_cell
from splinearm.guiding import TOOL_SPEED
from splinearm.jogging.bound import Bounds
from splinearm.jogging.jogger import top_speeds
from splinearm.jogging.ramp import Ramp
from splinearm.jogging.stopway import Stopway

PERIOD = 0.01


class Jogged:
    """The setpoints of an arm, and every one of them that was sent."""

    def __init__(self, name, q=None, arm=None) -> None:
        self.cell = load_cell(name)
        if arm is not None:
            self.cell = replace(self.cell, arm=arm)
        self.arm = self.cell.arm.compiled()
        speeds = top_speeds(self.cell)
        self.ramp = Ramp.of(self.arm.limits, speeds, PERIOD)
        bounds = Bounds(arm=self.arm, speeds=speeds, tool_speed=TOOL_SPEED, period=PERIOD)
        start = self.cell.poses["home"] if q is None else np.asarray(q)
        self.way = Stopway(bounds, self.ramp, start)
        self.sent = [start] * 3
        self.setpoints = []
        self.found = []

    def cycle(self, rates=None, frame=None):
        if rates is not None:
            wished = np.asarray(rates) * PERIOD
            if frame is None:
                self.found.append(self.way.move_joints(wished))
            else:
                self.found.append(self.way.move_tool(wished, frame))
        self.setpoints.append(self.way.next())
        self.sent.append(self.setpoints[-1].q)

    def go(self, seconds, rates=None, frame=None):
        for _ in range(round(seconds / PERIOD)):
            self.cycle(rates, frame)

    def rest(self):
        """Let it brake; give how long that took, s."""
        cycles = 0
        while not self.way.rests:
            self.cycle()
            cycles += 1
        return cycles * PERIOD

    @property
    def words(self):
        return [found.words for _, found in self.found if found is not None]

    @property
    def pose(self):
        return self.arm.fk(self.sent[-1])

    def tool_speeds(self):
        """Of everything that was sent: between setpoints, and by the Jacobian at each."""
        p = self.arm.fk(np.array(self.sent))[:, :3, 3]
        between = np.linalg.norm(np.diff(p, axis=0), axis=1) / PERIOD
        at = [np.linalg.norm(self.arm.jacobian(s.q)[:3] @ s.qd) for s in self.setpoints]
        return np.concatenate((between, at))


@pytest.fixture
def jogged():
    return Jogged
