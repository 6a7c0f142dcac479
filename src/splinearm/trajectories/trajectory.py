"""Motions of the joints in time."""

from bisect import bisect_right
from dataclasses import dataclass, field, replace
from math import inf

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.joints import JointLimits, JointSetpoint

from . import stopping
from .joint_path import JointPath
from .time_law import TimeLaw


@dataclass(frozen=True, slots=True, eq=False)
class Section:
    """A part of a motion from rest to rest, and how long it rests then."""

    path: JointPath
    """The way of the joints."""
    law: TimeLaw
    """How it is run through."""
    dwell: float = 0.0
    """How long the joints rest at its end, s."""

    @property
    def duration(self) -> float:
        """How long it takes with its rest, s."""
        return self.law.duration + self.dwell

    @property
    def q_end(self) -> FloatArray:
        """Where it ends, shape (n,), rad or m."""
        end: FloatArray = self.path.at(float(self.law.s[-1]))[0]
        return end


@dataclass(frozen=True, slots=True, eq=False)
class JointTrajectory:
    """A motion of the joints that ends at rest: sections one after the other."""

    sections: tuple[Section, ...]
    """The sections; none for a motion that stays where it is."""
    q_start: FloatArray
    """Where it starts, shape (n,), rad or m."""
    limits: JointLimits
    """What the joints may do; the motion is within."""
    starts: tuple[float, ...] = field(init=False)
    """When each section begins, s."""
    duration: float = field(init=False)
    """How long the motion takes, s."""
    q_goal: FloatArray = field(init=False)
    """Where it ends, shape (n,), rad or m."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "q_start", frozen_array(self.q_start, (self.limits.n,), "q_start"))
        for section in self.sections:
            if section.path.n != self.limits.n:
                raise ValueError(
                    f"sections: want ways of {self.limits.n} joints, got one of {section.path.n}"
                )
        ends = np.cumsum([section.duration for section in self.sections]).tolist()
        object.__setattr__(self, "starts", (0.0, *ends[:-1]) if ends else ())
        object.__setattr__(self, "duration", float(ends[-1]) if ends else 0.0)
        goal = self.sections[-1].q_end if self.sections else self.q_start
        object.__setattr__(self, "q_goal", frozen_array(goal, (self.limits.n,), "q_goal"))

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.limits.n

    def at(self, t: float) -> JointSetpoint:
        """Give the setpoint at a time.

        Before the start and from the end on the motion holds its ends: velocity and acceleration
        are zero there.

        Args:
            t: Time since the start, s.

        Raises:
            ValueError: If t is not a finite number.
        """
        if not -inf < t < inf:
            raise ValueError(f"t: want a finite time, got {t}")
        if t < 0.0 or t >= self.duration:
            rest = np.zeros(self.n)
            q = self.q_start if t < 0.0 or not self.sections else self.q_goal
            return JointSetpoint(t=t, q=q, qd=rest, qdd=rest)
        section, local = self._section_at(t)
        if local >= section.law.duration:
            rest = np.zeros(self.n)
            return JointSetpoint(t=t, q=section.q_end, qd=rest, qdd=rest)
        s, speed, acceleration = section.law.at(local)
        q, slope, bend = section.path.at(s)
        return JointSetpoint(
            t=t, q=q, qd=slope * speed, qdd=slope * acceleration + bend * (speed * speed)
        )

    def sample(self, ts: ArrayInput) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give position, velocity and acceleration at many times, each of shape (m, n).

        Args:
            ts: Times, shape (m,), s; as for ``at``.

        Raises:
            ValueError: If a time is not a finite number.
        """
        times = frozen_array(ts, (None,), "ts")
        q = np.where((times < 0.0)[:, None], self.q_start, self.q_goal)
        qd, qdd = np.zeros_like(q), np.zeros_like(q)
        for start, section in zip(self.starts, self.sections, strict=True):
            local = times - start
            inside = (local >= 0.0) & (local < section.duration) & (times < self.duration)
            here = np.flatnonzero(inside)
            moving = here[local[here] < section.law.duration]
            q[here] = section.q_end
            s, speed, acceleration = section.law.sample(local[moving])
            position, slope, bend = section.path.sample(s)
            q[moving] = position
            qd[moving] = slope * speed[:, None]
            qdd[moving] = slope * acceleration[:, None] + bend * (speed * speed)[:, None]
        return q, qd, qdd

    def stop_from(self, t: float) -> "JointTrajectory":
        """Give the motion that leaves this one at a time and slows down along the same path.

        It begins with the position and velocity that this one has at t, slows down as hard as the
        joints' accelerations allow, keeps all limits and ends at rest, never beyond where this one
        would have come to rest next. Where this one rests, the stop takes no time.

        Args:
            t: When to leave, s; as for ``at``.

        Raises:
            ValueError: If t is not a finite number.
        """
        now = self.at(t)
        if t <= 0.0 or t >= self.duration:
            return JointTrajectory((), now.q, self.limits)
        section, local = self._section_at(t)
        if local >= section.law.duration:
            return JointTrajectory((), now.q, self.limits)
        s, speed, _ = section.law.at(local)
        law = stopping.brake(section.path, self.limits, section.law, s, speed)
        if law.duration <= 0.0:
            return JointTrajectory((), now.q, self.limits)
        return JointTrajectory((Section(section.path, law),), now.q, self.limits)

    def scaled(self, share: float) -> "JointTrajectory":
        """Give the same motion at ``share`` of its speed; rests stay as long as they are.

        Raises:
            ValueError: If the share is not above 0 and at most 1.
        """
        if not 0.0 < share <= 1.0:
            raise ValueError(f"share: want above 0 and at most 1, got {share}")
        slower = [replace(part, law=part.law.slower(share)) for part in self.sections]
        return JointTrajectory(tuple(slower), self.q_start, self.limits)

    def _section_at(self, t: float) -> tuple[Section, float]:
        """Give the section at a time within the motion, and the time since its beginning."""
        i = bisect_right(self.starts, t) - 1
        section = self.sections[i]
        return section, t - self.starts[i]
