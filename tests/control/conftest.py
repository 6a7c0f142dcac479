"""An arm that is exactly where it was told to be, with knobs for what can go wrong."""

from types import TracebackType
from typing import Self

import numpy as np
import pytest

from splinearm.control.clock import StepClock
from splinearm.control.guard import Guard, Tolerances
from splinearm.errors import BusTimeoutError, PortError
from splinearm.joints import JointKind, JointLimits, JointSetpoint, JointState


class IdealArm:
    """Fulfils ``ArmDriver``; its time passes only when it is stepped."""

    def __init__(self, q: np.ndarray) -> None:
        self.q = np.array(q, dtype=float)
        self.qd = np.zeros_like(self.q)
        self.now = 0.0
        self.written: list[JointSetpoint] = []
        self.holding = False
        self.torque = True
        self.lose_reads_from: int | None = None
        self.lose_reads = 0
        self.stuck_from: float | None = None
        self.reads = 0
        self.cut_off_from: int | None = None

    @property
    def n(self) -> int:
        return self.q.size

    @property
    def goal(self) -> np.ndarray:
        return self.written[-1].q if self.written else self.q

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.hold()

    def advance(self, duration: float) -> None:
        self.now += duration

    def read(self) -> JointState:
        self.reads += 1
        self._need_a_wire()
        first = self.lose_reads_from
        if first is not None and first <= self.reads < first + self.lose_reads:
            raise BusTimeoutError(2, "Present Position", port="nowhere", name="elbow")
        return JointState(t=self.now, q=self.q, qd=self.qd, current=np.full(self.n, np.nan))

    def write(self, setpoint: JointSetpoint) -> None:
        self._need_a_wire()
        self.holding = False
        self.written.append(setpoint)
        if self.stuck_from is None or setpoint.t < self.stuck_from:
            self.q, self.qd = setpoint.q.copy(), setpoint.qd.copy()

    def hold(self) -> None:
        self._need_a_wire()
        self.holding = True

    def _need_a_wire(self) -> None:
        if self.cut_off_from is not None and len(self.written) >= self.cut_off_from:
            raise PortError("nowhere", "the connection is lost", "check the cable")

    def release(self) -> None:
        self.torque = False


@pytest.fixture
def limits() -> JointLimits:
    return JointLimits(
        names=("shoulder", "elbow"),
        kinds=(JointKind.REVOLUTE, JointKind.REVOLUTE),
        q_min=[-2.0, -2.5],
        q_max=[2.0, 2.5],
        qd_max=[2.0, 3.0],
        qdd_max=[8.0, 12.0],
    )


@pytest.fixture
def arm() -> IdealArm:
    return IdealArm(np.array([0.0, 0.5]))


@pytest.fixture
def clock(arm: IdealArm) -> StepClock:
    return StepClock(arm.advance, lambda: arm.now)


@pytest.fixture
def guard(limits: JointLimits) -> Guard:
    return Guard(limits, Tolerances())
