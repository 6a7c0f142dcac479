"""How often a loop comes round, and how evenly."""

from collections import deque
from dataclasses import dataclass
from math import nan

import numpy as np

_KEPT = 1000
"""Cycles that count."""
_RENEWED = 0.25
"""How often the figures are computed anew, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rhythm:
    """How often, and by how much the times between two samples differ from what was wanted."""

    wanted: float = nan
    """The rate that was asked for, Hz; NaN: none was."""
    rate: float = nan
    """The rate of late, Hz; NaN: there was but one sample."""
    jitter_p50: float = nan
    """Half of all times differ by less, s."""
    jitter_p99: float = nan
    """All but one in a hundred differ by less, s."""
    jitter_max: float = nan
    """None differs by more, s."""


class Beat:
    """Counts cycles.

    Args:
        rate: The wanted rate, Hz; None: none is wanted.
    """

    def __init__(self, rate: float | None = None) -> None:
        self._wanted = nan if rate is None else rate
        self._periods: deque[float] = deque(maxlen=_KEPT)
        self._last = nan
        self._due = -np.inf
        self.rhythm = Rhythm(wanted=self._wanted)
        """What there is to say so far."""

    def strike(self, t: float) -> None:
        """Note that a cycle began, at a time on the monotonic clock, s."""
        if not np.isnan(self._last):
            self._periods.append(t - self._last)
        self._last = t
        if t >= self._due and self._periods:
            self._due = t + _RENEWED
            self.rhythm = self._figures()

    def pause(self) -> None:
        """Note that what comes next is not the next cycle."""
        self._last = nan

    def _figures(self) -> Rhythm:
        periods = np.array(self._periods)
        mean = float(periods.mean())
        apart = np.abs(periods - (mean if np.isnan(self._wanted) else 1.0 / self._wanted))
        p50, p99 = np.percentile(apart, (50.0, 99.0))
        return Rhythm(
            wanted=self._wanted,
            rate=1.0 / mean,
            jitter_p50=float(p50),
            jitter_p99=float(p99),
            jitter_max=float(apart.max()),
        )
