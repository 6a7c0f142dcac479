"""Which rate this computer can hold, found by trying with the arm at rest."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray

from .clock import Clock

LASTS = 0.5
"""How long it is tried, s."""

RATES = (
    *(2000, 1500, 1200, 1000, 800, 600, 500, 400, 300, 250, 200, 150, 120, 100),
    *(80, 60, 50, 40, 30, 25, 20),
)
"""Rates among which is chosen, Hz; below the last the servos' own watchdog would stop them."""

WINDOWS = 3
"""In how many parts it is tried without real-time priority."""

UNSEEN_FIRST, UNSEEN_AMONG = 2.0, 4.0
"""Wake-ups will be so many times as late as the latest that was seen: of a thread that goes before
all others, and of one among them."""

_FULL = 0.85
"""Share of a period that the work of most cycles may take."""


@dataclass(frozen=True, slots=True, eq=False)
class Rehearsal:
    """Cycles in which nothing moved."""

    lateness: FloatArray
    """By how much each began late, shape (m,), s."""
    busy: FloatArray
    """How long its work took, shape (m,), s."""
    windows: int = 1
    """In how many parts, with pauses between them, it was tried; the worst decides."""

    def shortest_period(self, unseen: float) -> float:
        """Give the shortest time between cycles that can be held, s.

        Args:
            unseen: How many times as late as seen wake-ups will be.
        """
        parts = np.array_split(self.busy, self.windows)
        most = max(float(np.percentile(part, 90)) for part in parts) / _FULL
        return max(most, unseen * float(self.lateness.max()))

    def rate(self, wanted: float, unseen: float = UNSEEN_AMONG) -> float | None:
        """Give the highest rate up to the wanted one that can be held, Hz; None: none that helps.

        A wanted rate that can be held is given as it is.
        """
        possible = 1.0 / max(self.shortest_period(unseen), 1e-6)
        if wanted <= possible:
            return wanted
        return next((float(rate) for rate in RATES if rate <= possible), None)


def rehearse(
    clock: Clock,
    period: float,
    work: Callable[[], object],
    duration: float = LASTS,
    windows: int = 1,
) -> Rehearsal:
    """Run cycles of some work, on the clock that the motion will have.

    Args:
        clock: The clock.
        period: Time between cycles, s.
        work: What a cycle does, without moving anything.
        duration: For how long, s.
        windows: In how many parts with pauses as long as they are: what disturbs a computer comes
            and goes.
    """
    count = max(int(duration / period), 10)
    pauses = {count * k // windows for k in range(1, windows)}
    lateness, busy = np.empty(count), np.empty(count)
    due = clock.now()
    for i in range(count):
        if i in pauses:
            clock.wait_until(clock.now() + duration / windows)
        due = max(due + period, clock.now())
        lateness[i] = clock.wait_until(due)
        begun = time.perf_counter()
        work()
        busy[i] = time.perf_counter() - begun
    return Rehearsal(lateness, busy, windows)
