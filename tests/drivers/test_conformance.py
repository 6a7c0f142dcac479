from typing import Self

import numpy as np
import pytest

from splinearm.drivers.conformance import check_arm_driver
from splinearm.joints import JointSetpoint, JointState


class Arm:
    """An arm that keeps every promise; those below break one each."""

    n = 2

    def __init__(self) -> None:
        self.now = 0.0
        self.q = np.array([0.1, -0.2])
        self.goal = self.q

    def pass_time(self, duration: float) -> None:
        self.now += duration

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> bool | None:
        return None

    def read(self) -> JointState:
        return JointState(t=self.now, q=self.q, qd=np.zeros(2), current=np.full(2, np.nan))

    def write(self, setpoint: JointSetpoint) -> None:
        if setpoint.q.shape != (2,):
            raise ValueError("want 2 joints")
        self.q = self.goal = setpoint.q

    def hold(self) -> None:
        pass

    def release(self) -> None:
        pass


class EntersSomethingElse(Arm):
    def __enter__(self) -> Arm:
        return Arm()


class HasStoppedTime(Arm):
    def pass_time(self, duration: float) -> None:
        pass


class HasOneJointTooMany(Arm):
    n = 3


class Sinks(Arm):
    def pass_time(self, duration: float) -> None:
        super().pass_time(duration)
        self.q = self.q - duration


class DoesNotMove(Arm):
    def write(self, setpoint: JointSetpoint) -> None:
        if setpoint.q.shape != (2,):
            raise ValueError("want 2 joints")
        self.goal = setpoint.q


class TakesAnything(Arm):
    def write(self, setpoint: JointSetpoint) -> None:
        self.goal = setpoint.q
        self.q = setpoint.q[:2]


class ForgetsItsGoal(Arm):
    def write(self, setpoint: JointSetpoint) -> None:
        super().write(setpoint)
        self.goal = np.zeros(2)


class JumpsOnHold(Arm):
    def hold(self) -> None:
        self.q = self.q + 0.1


class SwallowsExceptions(Arm):
    def __exit__(self, *_: object) -> bool:
        return True


def test_an_arm_that_keeps_every_promise_passes():
    arm = Arm()
    check_arm_driver(arm, wait=arm.pass_time, is_holding=lambda: True)


@pytest.mark.parametrize(
    ("kind", "promise"),
    [
        (EntersSomethingElse, "gives the driver itself"),
        (HasStoppedTime, "time goes on"),
        (HasOneJointTooMany, "q has shape"),
        (Sinks, "an entered arm stays"),
        (DoesNotMove, "where setpoints lead it"),
        (TakesAnything, "is a ValueError"),
        (ForgetsItsGoal, "goal is the last setpoint"),
        (JumpsOnHold, "hold keeps the arm"),
        (SwallowsExceptions, "lets an exception through"),
    ],
)
def test_a_broken_promise_is_named(kind, promise):
    arm = kind()
    with pytest.raises(AssertionError, match=promise):
        check_arm_driver(arm, wait=arm.pass_time)


def test_an_arm_without_torque_after_leaving_fails():
    arm = Arm()
    with pytest.raises(AssertionError, match="keeps the torque"):
        check_arm_driver(arm, wait=arm.pass_time, is_holding=lambda: False)
