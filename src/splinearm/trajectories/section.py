"""Parts of a motion: a way of the joints, the law by which it is run through, and a rest."""

from dataclasses import dataclass, replace
from typing import Protocol, Self

import numpy as np

from splinearm.arrays import FloatArray

from .constraint import SpeedCap
from .joint_path import JointPath


class Law(Protocol):
    """How a path is run through: s as a function of time, from 0 to the duration."""

    @property
    def s(self) -> FloatArray:
        """Nodes, rising, shape (m,); one node is a rest that takes no time."""
        ...

    @property
    def t(self) -> FloatArray:
        """When they are passed, shape (m,), from 0; the law is smooth between them."""
        ...

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        ...

    def at(self, t: float) -> tuple[float, float, float]:
        """Give s, ds/dt and d2s/dt2 at a time."""
        ...

    def sample(self, ts: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give the same at many times, each of shape (k,)."""
        ...

    def jerk(self, ts: FloatArray) -> FloatArray:
        """Give d3s/dt3 at many times, shape (k,)."""
        ...

    def time_at(self, s: float) -> float:
        """Give when s is passed, s."""
        ...

    def slower(self, share: float) -> Self:
        """Give the same way at ``share`` of the speed everywhere."""
        ...

    def reversed(self) -> Self:
        """Give the law that passes the same places backwards, by s[0] + s[-1] - s."""
        ...

    def between(self, start: float, end: float) -> Self:
        """Give what happens from one time to a later one."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Section:
    """A part of a motion, and how long it rests at its end."""

    path: JointPath
    """The way of the joints."""
    law: Law
    """How it is run through."""
    dwell: float = 0.0
    """How long the joints rest at its end, s."""
    cap: SpeedCap | None = None
    """How fast the tool may be along the path, if that was asked for; the law keeps it."""

    @property
    def duration(self) -> float:
        """How long it takes with its rest, s."""
        return self.law.duration + self.dwell

    @property
    def q_start(self) -> FloatArray:
        """Where it starts, shape (n,), rad or m."""
        start: FloatArray = self.path.at(float(self.law.s[0]))[0]
        return start

    @property
    def q_end(self) -> FloatArray:
        """Where it ends, shape (n,), rad or m."""
        end: FloatArray = self.path.at(float(self.law.s[-1]))[0]
        return end

    def at(self, t: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give q, qd and qdd at a time from 0 to the duration, each of shape (n,)."""
        if self.dwell > 0.0 and t >= self.law.duration:
            q = self.q_end
            return q, np.zeros_like(q), np.zeros_like(q)
        s, speed, acceleration = self.law.at(t)
        q, slope, bend = self.path.at(s)
        return q, slope * speed, slope * acceleration + bend * (speed * speed)

    def sample(self, ts: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give the same at many times, each of shape (k, n)."""
        moving = self._moving(ts)
        q = np.tile(self.q_end, (len(ts), 1))
        qd, qdd = np.zeros_like(q), np.zeros_like(q)
        s, speed, acceleration = self.law.sample(ts[moving])
        position, slope, bend = self.path.sample(s)
        q[moving] = position
        qd[moving] = slope * speed[:, None]
        qdd[moving] = slope * acceleration[:, None] + bend * (speed * speed)[:, None]
        return q, qd, qdd

    def jerk(self, ts: FloatArray) -> FloatArray:
        """Give qddd at many times, shape (k, n)."""
        moving = self._moving(ts)
        qddd = np.zeros((len(ts), self.path.n))
        s, speed, acceleration = self.law.sample(ts[moving])
        _, slope, bend = self.path.sample(s)
        qddd[moving] = (
            slope * self.law.jerk(ts[moving])[:, None]
            + bend * (3.0 * speed * acceleration)[:, None]
            + self.path.third(s) * (speed**3)[:, None]
        )
        return qddd

    def nodes(self) -> FloatArray:
        """Give the times between which it is smooth, rising, from 0 to the duration."""
        law, breaks = self.law, self.path.breaks
        inner = breaks[(breaks > law.s[0]) & (breaks < law.s[-1])]
        passed = np.array([law.time_at(float(s)) for s in inner])
        nodes = np.concatenate((law.t, passed, [law.duration, self.duration]))
        return np.unique(np.clip(nodes, 0.0, self.duration))

    def tool_share(self, ts: FloatArray) -> FloatArray:
        """Give how much of the tool's highest speed is used at many times, shape (k,)."""
        if self.cap is None:
            return np.zeros(len(ts))
        s, speed, _ = self.law.sample(np.minimum(ts, self.law.duration))
        moving = speed * self._moving(ts)
        share: FloatArray = self.cap.rate(s) * moving / self.cap.at(s)
        return share

    def split(self, t: float) -> "tuple[Section, Section]":
        """Give what happens before and after a time from 0 to the duration."""
        if t >= self.law.duration:
            end = self.law.duration
            still = replace(self, law=self.law.between(end, end), dwell=self.duration - t)
            return replace(self, dwell=t - end), still
        before = replace(self, law=self.law.between(0.0, t), dwell=0.0)
        return before, replace(self, law=self.law.between(t, self.law.duration))

    def reversed(self) -> "Section":
        """Give the same way backwards, without the rest; by the parameter mirrored in the law."""
        first, last = float(self.law.s[0]), float(self.law.s[-1])
        return Section(self.path.mirrored(first, last), self.law.reversed())

    def _moving(self, ts: FloatArray) -> "np.ndarray[tuple[int, ...], np.dtype[np.bool_]]":
        """Tell at which times the joints do not rest yet."""
        return (ts < self.law.duration) | (self.dwell == 0.0)
