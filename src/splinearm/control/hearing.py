"""Reading the joints in every cycle, and how long each was not heard of."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from splinearm.drivers.base import ArmDriver
from splinearm.errors import (
    BusError,
    BusTimeoutError,
    HealthError,
    ServoError,
    SilentBusError,
)
from splinearm.joints import JointSetpoint, JointState

NAMED_AFTER = 3
"""A joint that did not answer in so many cycles on end is named."""


class Hearing:
    """An arm's answers, cycle by cycle.

    A driver with ``last_seen`` tells what the others said when one joint gave no answer: then each
    joint is counted by itself, and answers lost here and there on a noisy line do not add up.

    Args:
        driver: The arm.
        names: Its joints.
        announce: Gets a line when a joint is no longer heard, and when it is again.
    """

    def __init__(
        self, driver: ArmDriver, names: tuple[str, ...], announce: Callable[[str], object]
    ) -> None:
        self._driver: Any = driver
        self._tells_apart = hasattr(type(driver), "last_seen")
        self._names = names
        self._announce = announce
        self._silent = np.zeros(len(names), dtype=np.int64)
        self._named = False
        self.trouble: BusError | None = None
        """Why the last answer was not whole."""

    @property
    def lost(self) -> int:
        """For how many cycles on end some joint has not been heard."""
        return int(self._silent.max())

    def read(self) -> JointState | None:
        """Measure the joints; None if not all of them were heard.

        Raises:
            ServoError: If a servo reports a hardware error, or is too hot or overloaded to go on.
        """
        asked = time.monotonic()
        try:
            state: JointState = self._driver.read()
        except BusError as error:
            if isinstance(error, HealthError) or (isinstance(error, ServoError) and error.alert):
                raise
            self._miss(error, asked)
            return None
        self._silent[:] = 0
        self.trouble = None
        if self._named:
            self._named = False
            self._announce("every joint answers again")
        return state

    def heard(self, wanted: JointSetpoint) -> JointState | None:
        """Give what was heard this time, with joints that were not where they are wanted."""
        if not self._tells_apart:
            return None
        q = np.where(self._silent == 0, self._driver.last_seen.q, wanted.q)
        return JointState(t=wanted.t, q=q, qd=wanted.qd, current=np.full(q.size, np.nan))

    def _miss(self, error: BusError, asked: float) -> None:
        self.trouble = error
        self._silent += 1
        if self._tells_apart:
            self._silent[self._driver.last_seen.t >= asked] = 0
        joint = self._names[int(np.argmax(self._silent))]
        who = f"joint {joint!r} gave no answer"
        if isinstance(error, BusTimeoutError) and self._nobody_answers():
            self.trouble = SilentBusError(error.port)
            who = "no joint gave an answer"
        if self.lost >= NAMED_AFTER and not self._named:
            self._named = True
            self._announce(f"{who} for {self.lost} cycles: {self.trouble}")

    def _nobody_answers(self) -> bool:
        """Tell whether all of several joints have been silent for long."""
        return (
            self._tells_apart and len(self._names) > 1 and bool((self._silent >= NAMED_AFTER).all())
        )
