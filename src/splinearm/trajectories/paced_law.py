"""A time law run through at a pace of its own."""

from bisect import bisect_right
from dataclasses import dataclass, field

import numpy as np

from splinearm.arrays import FloatArray

from .pace import Pace
from .section import Law


@dataclass(frozen=True, slots=True, eq=False)
class PacedLaw:
    """s(tau(t)): another law whose time goes on at a changing pace."""

    law: Law
    """The law, s by its own time tau."""
    pace: Pace
    """How tau goes on."""
    s: FloatArray = field(init=False)
    """Where it is at the nodes of the pace, shape (m,)."""
    _starts: list[float] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        inside = np.clip(self.pace.tau, 0.0, self.law.duration)
        object.__setattr__(self, "s", self.law.sample(inside)[0])
        object.__setattr__(self, "_starts", self.pace.t[1:-1].tolist())

    @property
    def t(self) -> FloatArray:
        """The nodes of the pace, shape (m,), s."""
        return self.pace.t

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return float(self.pace.t[-1])

    def at(self, t: float) -> tuple[float, float, float]:
        """Give s, ds/dt and d2s/dt2 at a time from 0 to the duration."""
        i = bisect_right(self._starts, t)
        dt = t - float(self.pace.t[i])
        tau, r, p, w = (float(values[i]) for values in self.pace[1:])
        tau += dt * (r + dt * (0.5 * p + dt * w / 6.0))
        s, speed, acceleration = self.law.at(min(max(tau, 0.0), self.law.duration))
        r, p = r + dt * (p + 0.5 * dt * w), p + dt * w
        return s, speed * r, acceleration * r * r + speed * p

    def sample(self, ts: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give the same at many times, each of shape (k,)."""
        tau, r, p, _ = self._go_on(ts)
        s, speed, acceleration = self.law.sample(tau)
        return s, speed * r, acceleration * r * r + speed * p

    def jerk(self, ts: FloatArray) -> FloatArray:
        """Give d3s/dt3 at many times, shape (k,)."""
        tau, r, p, w = self._go_on(ts)
        _, speed, acceleration = self.law.sample(tau)
        jerk: FloatArray = self.law.jerk(tau) * r**3 + 3.0 * acceleration * r * p + speed * w
        return jerk

    def time_at(self, s: float) -> float:
        """Give when s is passed, s."""
        wanted = self.law.time_at(s)
        i = int(np.clip(np.searchsorted(self.pace.tau, wanted, side="right") - 1, 0, None))
        low, high = self.pace.t[i], self.pace.t[min(i + 1, len(self.pace.t) - 1)]
        for _ in range(60):
            middle = 0.5 * (low + high)
            if self._go_on(np.array([middle]))[0][0] < wanted:
                low = middle
            else:
                high = middle
        return float(0.5 * (low + high))

    def slower(self, share: float) -> "PacedLaw":
        """Give the same way at ``share`` of the speed everywhere."""
        t, tau, rate, change, push = self.pace
        slow = Pace(t / share, tau, rate * share, change * share**2, push * share**3)
        return PacedLaw(self.law, slow)

    def reversed(self) -> "PacedLaw":
        """Give the law that passes the same places backwards, by s[0] + s[-1] - s."""
        # within the inner law backwards, the places of this one begin later
        t, tau, rate, change, push = (values[::-1] for values in self.pace)
        backwards = Pace(
            t[0] - t,
            tau[0] - tau,
            rate,
            -change,
            np.append(push[1:], 0.0),
        )
        part = self.law.between(float(self.pace.tau[0]), float(self.pace.tau[-1]))
        return PacedLaw(part.reversed(), backwards)

    def between(self, start: float, end: float) -> "PacedLaw":
        """Give what happens from one time to a later one, both from 0 to the duration."""
        inner = self.pace.t[(self.pace.t > start) & (self.pace.t < end)]
        ts = np.concatenate(([start], inner, [end])) if end > start else np.array([start])
        tau, rate, change, push = self._go_on(ts)
        return PacedLaw(self.law, Pace(ts - start, tau, rate, change, push))

    def _go_on(self, ts: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Give tau within the law, its rate, and what changes that, each of shape (k,)."""
        i = np.searchsorted(self.pace.t[1:-1], ts, side="right")
        dt = ts - self.pace.t[i]
        tau, r, p, w = (values[i] for values in self.pace[1:])
        tau = tau + dt * (r + dt * (0.5 * p + dt * w / 6.0))
        return (
            np.clip(tau, 0.0, self.law.duration),
            np.maximum(r + dt * (p + 0.5 * dt * w), 0.0),
            p + dt * w,
            w,
        )
