"""The rate of a loop lowered on the way, when this computer cannot hold it."""

from collections import deque

SLOWEST = 1.0 / 30.0
"""Longest time between setpoints that is chosen on the way, s: servos whose watchdog stops them
after 0.1 s without a word hear three in that time."""

_MANY, _WITHIN = 3, 1.0
"""So many late wakings within such a time, s, are no accident."""
_UNSEEN = 1.5
"""Wakings will be so many times as late as the latest that was seen."""


class RateKeeper:
    """Says how many cycles of a loop to take as one, so that it wakes on time.

    What is sent are points of a spline, so that fewer of them change nothing in the path.

    Args:
        period: Time between cycles, s.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._late: deque[tuple[float, float]] = deque()
        self._most = max(int(SLOWEST / period + 1e-9), 1)
        self.stride = 1
        """How many cycles are one by now."""

    @property
    def rate(self) -> float:
        """Setpoints a second, Hz."""
        return 1.0 / (self.stride * self._period)

    def note(self, t: float, lateness: float) -> float | None:
        """Take note of a waking.

        Args:
            t: Time of the loop, s.
            lateness: By how much it was late, s.

        Returns:
            The latest of the last wakings, s, if the rate is lower from here on for them.
        """
        if lateness < self.stride * self._period:
            return None
        self._late.append((t, lateness))
        while self._late[0][0] < t - _WITHIN:
            self._late.popleft()
        if len(self._late) < _MANY or self.stride >= self._most:
            return None
        worst = max(late for _, late in self._late)
        self._late.clear()
        enough = int(_UNSEEN * worst / self._period) + 1
        self.stride = min(max(enough, self.stride + 1), self._most)
        return worst
