"""The progress bar of a motion under way."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Self

from .output import progress

if TYPE_CHECKING:
    from splinearm.control.cycle import Cycle

_REDRAWN = 0.25
"""Time of a motion between two pictures of its progress, s."""


class MotionBar:
    """A progress bar that is drawn only when it is told of a cycle: no thread of its own.

    Args:
        send: Gets every cycle too.
    """

    def __init__(self, send: "Callable[[Cycle], object]") -> None:
        self._send = send
        self._bar = progress()
        self._bar.live.auto_refresh = False
        self._task = self._bar.add_task("moving", total=1.0)
        self._motion: object = None
        self._t = self._shown = 0.0

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._draw()
        self._bar.stop()

    def show(self, motion: object, name: str, duration: float, cycle: "Cycle") -> None:
        """Be as far as a cycle of a motion, and pass it on.

        Args:
            motion: Which motion it is: of another one, or the same from its begin, it starts anew.
            name: What the motion is called.
            duration: How long it takes, s.
            cycle: The cycle.
        """
        self._send(cycle)
        t = cycle.setpoint.t
        if motion is not self._motion or t < self._t:
            self._motion, self._shown = motion, 0.0
            self._bar.update(self._task, description=name, total=duration, completed=0.0)
        self._t = t
        if t - self._shown >= _REDRAWN:
            self._draw()

    def _draw(self) -> None:
        self._shown = self._t
        self._bar.update(self._task, completed=self._t)
        self._bar.refresh()
