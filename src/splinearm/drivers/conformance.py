"""What every arm driver must do: one check that all of them pass, real or simulated."""

import time
from collections.abc import Callable

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointSetpoint
from splinearm.units import DEG

from .base import ArmDriver

_PERIOD = 0.02
"""Time between setpoints, s."""


class _Leave(Exception):  # noqa: N818 - no error, a way out
    """Leaves a with-block."""


def check_arm_driver(
    driver: ArmDriver,
    *,
    wait: Callable[[float], object] = time.sleep,
    settle: float = 0.5,
    step: float = 2.0 * DEG,
    sag: float = 3.0 * DEG,
    is_holding: Callable[[], bool] | None = None,
) -> None:
    """Pass a driver that keeps the promises of ``ArmDriver``. The arm moves by ``step``.

    Args:
        driver: The driver, not entered yet; it must be able to move by ``step`` either way.
        wait: Lets time pass on the driver's clock: gets a time in s.
        settle: How long the arm is led over ``step``, and then given to arrive, s.
        step: How far each joint is moved, rad (m for a sliding joint). After there and back it must
            have moved by this to a quarter.
        sag: How far the arm may sink when its motors take its weight. A servo without an integral
            gain hangs below its goal, always by the same angle.
        is_holding: Tells after leaving whether the arm still has torque; None: not looked at.

    Raises:
        AssertionError: With the promise that was broken.
    """
    check = _Check(driver, wait, settle, step)
    left = False
    try:
        _leave_in_the_middle(check, sag)
    except _Leave:
        left = True
    _require(kept=left, promise="leaving lets an exception through")
    if is_holding is not None:
        _require(kept=is_holding(), promise="leaving by an exception keeps the torque")


def _leave_in_the_middle(check: "_Check", sag: float) -> None:
    """Check what holds inside the with-block, then leave it by an exception."""
    with check.driver as entered:
        _require(kept=entered is check.driver, promise="entering gives the driver itself")
        check.reads()
        check.holds_at_entry(sag)
        check.follows()
        check.refuses_other_shapes()
        check.holds_when_told()
        raise _Leave


class _Check:
    """The promises, one a method, in the order in which they build on each other."""

    def __init__(
        self,
        driver: ArmDriver,
        wait: Callable[[float], object],
        settle: float,
        step: float,
    ) -> None:
        self.driver = driver
        self.wait = wait
        self.settle = settle
        self.step = step

    def reads(self) -> None:
        """States have n joints, numbers, and a time that goes on."""
        driver = self.driver
        _require(kept=driver.n >= 1, promise="an arm has at least one joint")
        first = driver.read()
        for name in ("q", "qd", "current"):
            shape = getattr(first, name).shape
            kept = shape == (driver.n,)
            _require(kept=kept, promise=f"{name} has shape ({driver.n},), not {shape}")
        self.wait(_PERIOD)
        _require(kept=driver.read().t > first.t, promise="time goes on from state to state")
        kept = driver.goal.shape == (driver.n,)
        _require(kept=kept, promise=f"goal has shape ({driver.n},), not {driver.goal.shape}")

    def holds_at_entry(self, sag: float) -> None:
        """An arm that was entered stays where it is, without being told."""
        start = self.driver.read().q
        self.wait(self.settle)
        self._is_at(start, sag, "an entered arm stays where it stands")

    def follows(self) -> None:
        """The arm goes where setpoints say, there and back."""
        start = self.driver.read().q
        self._lead(start, start + self.step)
        there = self.driver.read().q
        self._lead(start + self.step, start)
        self._is_at(there - self.step, 0.25 * self.step, "the arm goes where setpoints lead it")

    def _lead(self, start: FloatArray, goal: FloatArray) -> None:
        """Send setpoints on the way, then at its end."""
        count = max(2, round(self.settle / _PERIOD))
        for k in range(1, 2 * count):
            share = min(k / count, 1.0)
            self._write(start + share * (goal - start))
            self.wait(_PERIOD)

    def refuses_other_shapes(self) -> None:
        """A setpoint for another number of joints is a wrong argument."""
        refused = False
        try:
            self._write(np.zeros(self.driver.n + 1))
        except ValueError:
            refused = True
        promise = "a setpoint for another number of joints is a ValueError"
        _require(kept=refused, promise=promise)

    def holds_when_told(self) -> None:
        """``hold`` keeps the arm where it is, also when it is said twice."""
        start = self.driver.read().q
        self.driver.hold()
        self.driver.hold()
        self.wait(self.settle)
        self._is_at(start, 0.25 * self.step, "hold keeps the arm where it is")

    def _write(self, q: FloatArray) -> None:
        rest = np.zeros_like(q)
        self.driver.write(JointSetpoint(t=0.0, q=q, qd=rest, qdd=rest))
        kept = np.allclose(self.driver.goal, q)
        _require(kept=kept, promise="goal is the last setpoint that was written")

    def _is_at(self, q: FloatArray, tolerance: float, promise: str) -> None:
        away = float(np.abs(self.driver.read().q - q).max())
        kept = away <= tolerance
        _require(kept=kept, promise=f"{promise}, but it is {away / DEG:.3f} deg away")


def _require(*, kept: bool, promise: str) -> None:
    """Say which promise was broken."""
    if not kept:
        raise AssertionError(f"broken promise: {promise}")
