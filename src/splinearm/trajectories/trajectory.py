"""Motions of the joints in time."""

from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from math import inf

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.curves.basis import IndexArray
from splinearm.curves.bspline import BSpline
from splinearm.joints import JointLimits, JointSetpoint

from . import stopping, time_curve
from .section import Section

_STILL = 1e-9
"""Below this share of its highest speed a joint rests."""


@dataclass(frozen=True, slots=True, eq=False)
class JointTrajectory:
    """A motion of the joints: sections one after the other.

    What ``plan`` gives begins and ends at rest; parts of it (``split``) may begin or end moving.
    """

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
    _envelopes: stopping.Envelopes = field(init=False, repr=False, default_factory=dict)

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

    @property
    def starts_at_rest(self) -> bool:
        """Whether no joint moves when it begins."""
        return self._rests(0, 0.0)

    @property
    def ends_at_rest(self) -> bool:
        """Whether no joint moves when it ends."""
        return self._rests(-1, inf)

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
        section, local = self.section_at(t)
        q, qd, qdd = section.at(local)
        return JointSetpoint(t=t, q=q, qd=qd, qdd=qdd)

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
        for section, here, local in self._shares(times):
            q[here], qd[here], qdd[here] = section.sample(local)
        return q, qd, qdd

    def jerk(self, ts: ArrayInput) -> FloatArray:
        """Give the jerk at many times, shape (m, n), rad/s3 or m/s3; where it jumps, from ahead.

        A motion planned without a limit of jerk has jumps of acceleration between the moments at
        which this looks.

        Args:
            ts: Times, shape (m,), s; as for ``at``.

        Raises:
            ValueError: If a time is not a finite number.
        """
        times = frozen_array(ts, (None,), "ts")
        qddd = np.zeros((len(times), self.n))
        for section, here, local in self._shares(times):
            qddd[here] = section.jerk(local)
        return qddd

    def tool_share(self, ts: ArrayInput) -> FloatArray:
        """Give how much of the tool's highest speed is used at many times, shape (m,).

        Args:
            ts: Times, shape (m,), s; 0 where no speed of the tool was asked for.

        Raises:
            ValueError: If a time is not a finite number.
        """
        times = frozen_array(ts, (None,), "ts")
        share = np.zeros(len(times))
        for section, here, local in self._shares(times):
            share[here] = section.tool_share(local)
        return share

    def stop_from(self, t: float) -> "JointTrajectory":
        """Give the motion that leaves this one at a time and slows down along the same path.

        It begins with the position and velocity that this one has at t, slows down as hard as the
        joints' limits allow, keeps all of them and ends at rest, never beyond where this one would
        have come to rest next. Where jerk is limited it begins with the acceleration as well. Where
        this one rests, the stop takes no time.

        Args:
            t: When to leave, s; as for ``at``.

        Raises:
            ValueError: If t is not a finite number.
        """
        now = self.at(t)
        if t <= 0.0 or t >= self.duration:
            return JointTrajectory((), now.q, self.limits)
        section, local = self.section_at(t)
        if local >= section.law.duration:
            return JointTrajectory((), now.q, self.limits)
        law = stopping.law_to_rest(section, self.limits, local, self._envelopes)
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
        return self._with(replace(part, law=part.law.slower(share)) for part in self.sections)

    def split(self, t: float) -> "tuple[JointTrajectory, JointTrajectory]":
        """Give what happens before and after a time; both parts keep their pace.

        Raises:
            ValueError: If the time is not strictly within the motion.
        """
        if not 0.0 < t < self.duration:
            raise ValueError(f"t: want a time between 0 and {self.duration} s, got {t}")
        i = bisect_right(self.starts, t) - 1
        before, after = self.sections[i].split(t - self.starts[i])
        first = JointTrajectory((*self.sections[:i], before), self.q_start, self.limits)
        second = (after, *self.sections[i + 1 :])
        return first, JointTrajectory(second, second[0].q_start, self.limits)

    def reversed(self) -> "JointTrajectory":
        """Give the motion backwards in time, rests included."""
        parts: list[Section] = []
        for section in reversed(self.sections):
            if section.dwell > 0.0:
                still = section.law.between(section.law.duration, section.law.duration)
                parts.append(Section(section.path, still, section.dwell))
            parts.append(section.reversed())
        return JointTrajectory(tuple(parts), self.q_goal, self.limits)

    def to_bspline(self, tolerance: float) -> BSpline:
        """Give the joints as a cubic B-spline of the time, C1, from 0 to the duration.

        Args:
            tolerance: How far a joint may be off, rad or m, at places close to each other.

        Raises:
            ValueError: If the tolerance is not above 0, or the motion takes no time.
        """
        return time_curve.fit(self, tolerance)

    def section_at(self, t: float) -> tuple[Section, float]:
        """Give the section at a time within the motion, and the time since its beginning."""
        i = bisect_right(self.starts, t) - 1
        return self.sections[i], t - self.starts[i]

    def nodes(self) -> FloatArray:
        """Give the times between which the motion is smooth, rising, from 0 to the duration."""
        parts = [np.array([0.0, self.duration])]
        for start, section in zip(self.starts, self.sections, strict=True):
            parts.append(start + section.nodes())
        return np.unique(np.clip(np.concatenate(parts), 0.0, self.duration))

    def _with(self, sections: Iterable[Section]) -> "JointTrajectory":
        return JointTrajectory(tuple(sections), self.q_start, self.limits)

    def _rests(self, which: int, local: float) -> bool:
        if not self.sections:
            return True
        section = self.sections[which]
        if which == -1 and section.dwell > 0.0:
            return True
        _, qd, _ = section.at(min(local, section.law.duration))
        return bool((np.abs(qd) <= _STILL * self.limits.qd_max).all())

    def _shares(self, times: FloatArray) -> list[tuple[Section, IndexArray, FloatArray]]:
        """Give each section with the indices of the times within it and those since its start."""
        shares = []
        for start, section in zip(self.starts, self.sections, strict=True):
            local = times - start
            inside = (local >= 0.0) & (local < section.duration) & (times < self.duration)
            here = np.flatnonzero(inside)
            if here.size:
                shares.append((section, here, local[here]))
        return shares
