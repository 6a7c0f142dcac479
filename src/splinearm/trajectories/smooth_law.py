"""Time laws whose acceleration never jumps, in closed form."""

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from splinearm.arrays import FloatArray, frozen_array

from .smooth_motion import circular

_ROUNDS = 60


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class SmoothLaw:
    """s(t) in cells on which d3s/dt3 = jerk + growth ds/dt, one of the two being zero.

    With a jerk, s is a cubic of the time. With a growth, d2s/dt2 is linear in s and the square of
    ds/dt quadratic, and s is made of sines or hyperbolic sines of the time.
    """

    s: FloatArray
    """Nodes, rising, shape (m,); one node is a rest that takes no time."""
    t: FloatArray
    """When they are passed, s, shape (m,), from 0."""
    speed: FloatArray
    """ds/dt at the nodes, shape (m,)."""
    acceleration: FloatArray
    """d2s/dt2 at the nodes, shape (m,)."""
    jerks: FloatArray
    """d3s/dt3 in each cell that has no growth, else 0, shape (m - 1,)."""
    growth: FloatArray
    """How d2s/dt2 grows with s in each cell, 1/s2, or 0, shape (m - 1,)."""
    cells: FloatArray = field(init=False, repr=False)
    """Of each cell t, s, speed, acceleration, jerk and growth at its begin, shape (m - 1, 6)."""
    _rows: list[tuple[float, ...]] = field(init=False, repr=False)
    _starts: list[float] = field(init=False, repr=False)
    _end: tuple[float, float, float, float] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        m = np.size(self.s)
        for name in ("s", "t", "speed", "acceleration"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), (m,), name))
        for name in ("jerks", "growth"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), (m - 1,), name))
        if m == 0 or self.t[0] != 0.0 or (np.diff(self.t) <= 0.0).any():
            raise ValueError(f"t: want rising times from 0 on, got {self.t.tolist()}")
        if ((self.jerks != 0.0) & (self.growth != 0.0)).any():
            raise ValueError("jerks, growth: want one of them zero in each cell")
        columns = (self.t[:-1], self.s[:-1], self.speed[:-1], self.acceleration[:-1])
        cells = np.ascontiguousarray(np.stack((*columns, self.jerks, self.growth), axis=1))
        object.__setattr__(self, "cells", cells)
        object.__setattr__(self, "_rows", [tuple(row) for row in cells.tolist()])
        object.__setattr__(self, "_starts", self.t[1:-1].tolist())
        last = (self.t, self.s, self.speed, self.acceleration)
        object.__setattr__(self, "_end", tuple(float(values[-1]) for values in last))

    @classmethod
    def resting(cls, s: float) -> "SmoothLaw":
        """Give the law that stays at s and takes no time."""
        one, none = np.zeros(1), np.zeros(0)
        return cls(s=one + s, t=one, speed=one, acceleration=one, jerks=none, growth=none)

    @classmethod
    def of_jerks(cls, s: float, jerks: FloatArray, durations: FloatArray) -> "SmoothLaw":
        """Give the law that starts at rest at s and has one jerk after the other.

        Args:
            s: Where it starts.
            jerks: d3s/dt3 of each cell, shape (k,).
            durations: How long each lasts, shape (k,), s; those of no length are left out.
        """
        states = [(s, 0.0, 0.0)]
        used = durations > 0.0
        for j, dt in zip(jerks[used].tolist(), durations[used].tolist(), strict=True):
            s, v, a = states[-1]
            s += dt * (v + dt * (0.5 * a + dt * (j / 6.0)))
            states.append((s, v + dt * (a + dt * (0.5 * j)), a + dt * j))
        nodes = np.array(states)
        return cls(
            s=nodes[:, 0],
            t=np.concatenate(([0.0], np.cumsum(durations[used]))),
            speed=nodes[:, 1],
            acceleration=nodes[:, 2],
            jerks=jerks[used],
            growth=np.zeros(int(used.sum())),
        )

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return float(self.t[-1])

    def at(self, t: float) -> tuple[float, float, float]:
        """Give s, ds/dt and d2s/dt2 at a time from 0 to the duration."""
        s, speed, acceleration, _ = self.state(t)
        return s, speed, acceleration

    def state(self, t: float) -> tuple[float, float, float, float]:
        """Give s, ds/dt, d2s/dt2 and d3s/dt3 at a time from 0 to the duration."""
        if not self._rows:
            return float(self.s[0]), 0.0, 0.0, 0.0
        begun, s, v, a, j, c = self._rows[bisect_right(self._starts, t)]
        if t >= self._end[0]:
            return *self._end[1:], j + c * self._end[2]
        dt = t - begun
        if c == 0.0:
            speed = max(v + dt * (a + dt * (0.5 * j)), 0.0)
            return s + dt * (v + dt * (0.5 * a + dt * (j / 6.0))), speed, a + dt * j, j
        even, odd, next_even = circular(c, dt)
        speed = max(v * even + a * odd, 0.0)
        return s + v * odd + a * next_even, speed, a * even + c * v * odd, c * speed

    def sample(self, ts: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give s, ds/dt and d2s/dt2 at many times, each of shape (k,)."""
        s, speed, acceleration, _ = self.states(ts)
        return s, speed, acceleration

    def states(self, ts: FloatArray) -> FloatArray:
        """Give s, ds/dt, d2s/dt2 and d3s/dt3 at many times, as rows, shape (4, k)."""
        out = np.zeros((4, len(ts)))
        if self._rows:
            _sampler()(self.cells, np.ascontiguousarray(ts, dtype=np.float64), out)
            out[:3, ts >= self._end[0]] = np.array(self._end[1:])[:, None]
        else:
            out[0] = self.s[0]
        return out

    def jerk(self, ts: FloatArray) -> FloatArray:
        """Give d3s/dt3 at many times, shape (k,)."""
        jerk: FloatArray = self.states(ts)[3]
        return jerk

    def time_at(self, s: float) -> float:
        """Give when s is passed, s."""
        if not self._rows or s <= self.s[0]:
            return 0.0
        if s >= self.s[-1]:
            return self.duration
        i = int(np.searchsorted(self.s[1:-1], s, side="right"))
        # Newton's method within what is known to hold the time
        low, high = float(self.t[i]), float(self.t[i + 1])
        t = low + (high - low) * (s - float(self.s[i])) / float(self.s[i + 1] - self.s[i])
        for _ in range(_ROUNDS):
            at, speed, _ = self.at(t)
            low, high = (t, high) if at < s else (low, t)
            step = (s - at) / speed if speed > 0.0 else 0.0
            new = t + step if low < t + step < high else 0.5 * (low + high)
            if abs(new - t) <= 1e-16 * high:
                break
            t = new
        return t

    def slower(self, share: float) -> "SmoothLaw":
        """Give the same way at ``share`` of the speed everywhere."""
        return SmoothLaw(
            s=self.s,
            t=self.t / share,
            speed=self.speed * share,
            acceleration=self.acceleration * share**2,
            jerks=self.jerks * share**3,
            growth=self.growth * share**2,
        )

    def reversed(self) -> "SmoothLaw":
        """Give the law that passes the same places backwards, by the parameter s[0] + s[-1] - s."""
        return SmoothLaw(
            s=self.s[0] + (self.s[-1] - self.s[::-1]),
            t=self.t[-1] - self.t[::-1],
            speed=self.speed[::-1],
            acceleration=-self.acceleration[::-1],
            jerks=self.jerks[::-1],
            growth=self.growth[::-1],
        )

    def between(self, start: float, end: float) -> "SmoothLaw":
        """Give what happens from one time to a later one, both from 0 to the duration."""
        if not end > start or not self._rows:
            return SmoothLaw.resting(self.at(start)[0])
        inner = (self.t > start) & (self.t < end)
        t = np.concatenate(([start], self.t[inner], [end]))
        s, speed, acceleration, _ = self.states(t)
        cell = np.searchsorted(self.t[1:-1], 0.5 * (t[:-1] + t[1:]), side="right")
        return SmoothLaw(
            s=s,
            t=t - start,
            speed=speed,
            acceleration=acceleration,
            jerks=self.jerks[cell],
            growth=self.growth[cell],
        )


def cell_times(h: FloatArray, speed: FloatArray, growth: FloatArray) -> FloatArray:
    """Give how long cells with a growth take, shape (m - 1,), s.

    Args:
        h: Their lengths, shape (m - 1,).
        speed: ds/dt at their ends, shape (m,), above zero.
        growth: How d2s/dt2 grows with s in each, shape (m - 1,).
    """
    # from f'' = c f: h = (v0 + v1) tanh(k t / 2) / k with k = sqrt(c), and tan with sqrt(-c)
    ratio = h / (speed[:-1] + speed[1:])
    z = growth * ratio * ratio
    root = np.sqrt(np.abs(z))
    large = np.where(z > 0.0, np.arctanh(np.minimum(root, 1.0 - 1e-16)), np.arctan(root))
    series = 1.0 + z * (1 / 3 + z * (1 / 5 + z * (1 / 7)))
    small = np.abs(z) < 1e-4
    times: FloatArray = 2.0 * ratio * np.where(small, series, large / np.where(small, 1.0, root))
    return times


@cache
def _sampler() -> Callable[[FloatArray, FloatArray, FloatArray], None]:
    """Load the kernel when it is first wanted."""
    from splinearm.compiled import entry, inputs, outputs

    from .smooth_law_kernel import sample_into

    return entry(sample_into, *inputs(2, 1), *outputs(2))
