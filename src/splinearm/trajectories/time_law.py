"""How a path is run through in time: nodes between which the path acceleration is constant."""

from bisect import bisect_right
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.basis import IndexArray


class _Cells(NamedTuple):
    cells: list[tuple[float, ...]]
    """Time, s, ds/dt and d2s/dt2 at the begin of each, and s at its end."""
    starts: list[float]
    """When all but the first begin, s."""


@dataclass(frozen=True, slots=True, eq=False)
class TimeLaw:
    """s(t), with x = (ds/dt)^2 linear in s between nodes."""

    s: FloatArray
    """Nodes, rising, shape (m,); one node is a rest that takes no time."""
    x: FloatArray
    """Square of ds/dt at the nodes, shape (m,); zero at no two neighbours."""
    t: FloatArray = field(init=False)
    """When the nodes are passed, s, shape (m,), from 0."""
    speed: FloatArray = field(init=False)
    """ds/dt at the nodes, shape (m,)."""
    acceleration: FloatArray = field(init=False)
    """d2s/dt2 between nodes, shape (m - 1,)."""
    _kept: list[_Cells] = field(init=False, repr=False, default_factory=list)

    def __post_init__(self) -> None:
        speed = np.sqrt(self.x)
        h = np.diff(self.s)
        t = np.concatenate(([0.0], np.cumsum(2.0 * h / (speed[:-1] + speed[1:]))))
        acceleration = np.diff(self.x) / (2.0 * h)
        object.__setattr__(self, "t", t)
        object.__setattr__(self, "speed", speed)
        object.__setattr__(self, "acceleration", acceleration)

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return float(self.t[-1])

    def at(self, t: float) -> tuple[float, float, float]:
        """Give s, ds/dt and d2s/dt2 at a time from 0 to the duration."""
        if len(self.s) == 1:
            return float(self.s[0]), 0.0, 0.0
        known = self._cells()
        begun, s, speed, acceleration, end = known.cells[bisect_right(known.starts, t)]
        dt = t - begun
        now = speed + acceleration * dt
        return min(s + dt * 0.5 * (speed + now), end), max(now, 0.0), acceleration

    def sample(self, ts: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give the same at many times, each of shape (k,)."""
        if len(self.s) == 1:
            nothing = np.zeros(len(ts))
            return nothing + self.s[0], nothing, nothing.copy()
        cell = np.searchsorted(self.t[1:-1], ts, side="right")
        dt = ts - self.t[cell]
        acceleration = self.acceleration[cell]
        now = self.speed[cell] + acceleration * dt
        s = np.minimum(self.s[cell] + dt * 0.5 * (self.speed[cell] + now), self.s[cell + 1])
        return s, np.maximum(now, 0.0), acceleration

    def time_at(self, s: float) -> float:
        """Give when s is passed, s."""
        if s >= self.s[-1]:
            return self.duration
        cell = int(np.searchsorted(self.s[1:-1], s, side="right"))
        begun, first, speed, acceleration, _ = self._cells().cells[cell]
        way = s - first
        if way <= 0.0:
            return begun
        now = np.sqrt(max(speed * speed + 2.0 * acceleration * way, 0.0))
        return float(begun + 2.0 * way / (speed + now))

    def _cells(self) -> _Cells:
        """Give the cells as plain numbers, for single moments; made when first asked for."""
        if not self._kept:
            columns = (self.t, self.s, self.speed, self.acceleration, self.s[1:])
            cells = list(zip(*(c.tolist() for c in columns), strict=False))
            self._kept.append(_Cells(cells, self.t[1:-1].tolist()))
        return self._kept[0]

    def jerk(self, ts: FloatArray) -> FloatArray:
        """Give d3s/dt3 at many times, shape (k,): zero between nodes, where d2s/dt2 jumps."""
        return np.zeros(len(ts))

    def slower(self, share: float) -> "TimeLaw":
        """Give the same way at ``share`` of the speed everywhere."""
        return TimeLaw(self.s, self.x * share**2)

    def reversed(self) -> "TimeLaw":
        """Give the law that passes the same places backwards, by the parameter s[0] + s[-1] - s."""
        return TimeLaw(self.s[0] + (self.s[-1] - self.s[::-1]), self.x[::-1])

    def between(self, start: float, end: float) -> "TimeLaw":
        """Give what happens from one time to a later one, both from 0 to the duration."""
        (first, last), speed, _ = self.sample(np.array([start, end]))
        inner = (self.t > start) & (self.t < end) & (self.s > first) & (self.s < last)
        s = np.concatenate(([first], self.s[inner], [last]))
        x = np.concatenate((speed[:1] ** 2, self.x[inner], speed[1:] ** 2))
        return TimeLaw(s, x) if last > first else TimeLaw(s[:1], np.zeros(1))


def split_cells(nodes: FloatArray, counts: IndexArray) -> FloatArray:
    """Give nodes with each cell between the old ones split evenly into so many."""
    cell = np.repeat(np.arange(len(counts)), counts)
    within = np.arange(len(cell)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = within / counts[cell]
    return np.append(nodes[cell] + share * np.diff(nodes)[cell], nodes[-1])
