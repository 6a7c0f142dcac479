"""Motions whose pace changes while they run: slower, faster, paused, resumed, on their own path."""

from dataclasses import dataclass, field
from functools import cache
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointLimits, JointSetpoint

if TYPE_CHECKING:
    from .trajectory import JointTrajectory

FASTEST = 1.5
"""Highest pace that can be asked for, as a share of the planned one."""

_STRETCHES = 400
_LOOKS = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
_INSIDE = 1e-9
_STEPS = 60
_MOST_STEPS = 4000
_HALVINGS = 60


class _Kernels(NamedTuple):
    step: Any
    run: Any


@cache
def _kernels() -> _Kernels:
    from splinearm.compiled import entry, inputs, outputs

    from . import pace_kernel as kernel

    same = (*inputs(1, 3, 2), *outputs(1, 1, 2))
    return _Kernels(entry(kernel.step_into, *same), entry(kernel.run_into, *same, *outputs(2)))


class Motion(Protocol):
    """Joints by time."""

    def sample(self, ts: FloatArray, /) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give q, qd and qdd at times, each of shape (m, n)."""
        ...

    def jerk(self, ts: FloatArray, /) -> FloatArray:
        """Give qddd at times, shape (m, n)."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Envelope:
    """What a motion asks of its joints, stretch by stretch: how much its pace may change there."""

    edges: FloatArray
    """Ends of the stretches, rising, shape (k + 1,), s of the motion."""
    box: FloatArray
    """Lowest and highest velocity, acceleration and jerk, shape (k, n, 6)."""
    limits: FloatArray
    """Rows of velocity, acceleration and jerk, infinite where not limited, shape (3, n)."""
    highest_push: float = field(init=False)
    """Largest second derivative of the pace that is tried, 1/s2: far above what joints do."""

    def __post_init__(self) -> None:
        size = self.limits[2][np.isfinite(self.limits[2])]
        speed = np.abs(self.box[:, :, :2]).max()
        push = float(1e3 * size.max() / speed) if size.size and speed > 0.0 else 1e4
        object.__setattr__(self, "highest_push", push)

    @classmethod
    def of(
        cls, motion: "Motion", nodes: FloatArray, span: tuple[float, float], limits: JointLimits
    ) -> "Envelope":
        """Look at a motion from one time to a later one, five times in each of many stretches.

        Args:
            motion: The motion.
            nodes: Times between which it is smooth.
            span: From when to when.
            limits: What the joints may do.
        """
        start, end = span
        even = np.linspace(start, end, _STRETCHES + 1)
        edges = np.union1d(even, nodes[(nodes > start) & (nodes < end)])
        edges = edges[np.diff(edges, prepend=-inf) > _INSIDE * (end - start)]
        edges[-1] = end
        width = np.diff(edges)[:, None]
        inside = np.clip(_LOOKS, _INSIDE, 1.0 - _INSIDE)
        ts = (edges[:-1, None] + width * inside).ravel()
        _, qd, qdd = motion.sample(ts)
        shape = (len(edges) - 1, len(_LOOKS), limits.n)
        looks = [values.reshape(shape) for values in (qd, qdd, motion.jerk(ts))]
        box = np.stack([bound(v, axis=1) for v in looks for bound in (np.min, np.max)], axis=2)
        jerk = np.full(limits.n, inf) if limits.qddd_max is None else limits.qddd_max
        return cls(edges, box, np.stack((limits.qd_max, limits.qdd_max, jerk)))


class PacedMotion:
    """A motion carried out step by step at a pace that may change at any time.

    All limits of the joints hold whatever is asked, as far as the motion holds them itself; the
    path is kept exactly, and position, velocity and acceleration are continuous wherever those of
    the motion are. What is asked for is reached as soon as the limits allow, which may be never: a
    motion at its limits has no room to go faster.
    """

    def __init__(
        self,
        trajectory: "JointTrajectory",
        period: float,
        *,
        limits: JointLimits | None = None,
    ) -> None:
        """Take the motion, which is looked at once.

        Args:
            trajectory: The motion.
            period: Time of a step, s.
            limits: What the joints may do; None: the limits of the motion.

        Raises:
            ValueError: If the period is not above 0 or the motion takes no time.
        """
        if not 0.0 < period < inf:
            raise ValueError(f"period: want a time above 0, got {period}")
        if trajectory.duration <= 0.0:
            raise ValueError("trajectory: takes no time, so it has no pace")
        self.trajectory = trajectory
        self._envelope = Envelope.of(
            trajectory,
            trajectory.nodes(),
            (0.0, trajectory.duration),
            trajectory.limits if limits is None else limits,
        )
        self._command = np.array([1.0, period, self._envelope.highest_push, 1.0, 1.0])
        self._state = np.array([0.0, 1.0, 0.0])
        self._work = np.empty((3, 3))
        self._asked = 1.0
        self.elapsed = 0.0
        """Time since the first step, s."""

    @property
    def motion_t(self) -> float:
        """Where in the motion it is, s."""
        return min(float(self._state[0]), self.trajectory.duration)

    @property
    def pace(self) -> float:
        """Present pace, as a share of the planned one."""
        return float(self._state[1])

    @property
    def finished(self) -> bool:
        """Whether the end of the motion is reached."""
        return float(self._state[0]) >= self.trajectory.duration

    @property
    def rests(self) -> bool:
        """Whether the motion has ended or is paused."""
        return self.finished or (self._state[1] == 0.0 and self._state[2] == 0.0)

    def ask(self, pace: float) -> None:
        """Ask for a pace: 0 pauses on the path, 1 is as planned, at most 1.5.

        Raises:
            ValueError: If it is not from 0 to 1.5.
        """
        if not (isfinite(pace) and 0.0 <= pace <= FASTEST):
            raise ValueError(f"pace: want a share from 0 to {FASTEST:g} of the plan, got {pace}")
        self._command[0] = pace
        if pace > 0.0:
            self._asked = pace

    def pause(self) -> None:
        """Slow down along the path and stay there."""
        self._command[0] = 0.0

    def resume(self) -> None:
        """Go on at the pace that was asked for last."""
        self._command[0] = self._asked

    def setpoint(self) -> JointSetpoint:
        """Give where the joints shall be now; its ``t`` is ``motion_t``."""
        tau, r, p = self._state.tolist()
        if self.finished:
            r = p = 0.0
        planned = self.trajectory.at(tau)
        return JointSetpoint(
            t=self.motion_t,
            q=planned.q,
            qd=planned.qd * r,
            qdd=planned.qdd * (r * r) + planned.qd * p,
        )

    def stop(self) -> "JointTrajectory":
        """Give the motion that slows down from here along the path as soon as the limits allow."""
        from .paced_law import PacedLaw
        from .section import Section
        from .trajectory import JointTrajectory

        motion = self.trajectory
        now = self.setpoint()
        rest = JointTrajectory((), now.q, motion.limits)
        if self.rests:
            return rest
        section, local = motion.section_at(self.motion_t)
        if local >= section.law.duration:
            return rest
        begun = self.motion_t - local
        command = np.array([0.0, *self._command[1:]])
        pace = slow_down(self._envelope, self._state, command, begun + section.law.duration)
        law = PacedLaw(section.law, pace._replace(tau=pace.tau - begun))
        return JointTrajectory((Section(section.path, law),), now.q, motion.limits)

    def step(self) -> JointSetpoint:
        """Go on by one period and give the setpoint there."""
        if not self.finished:
            e = self._envelope
            _kernels().step(e.edges, e.box, e.limits, self._command, self._state, self._work)
        self.elapsed += float(self._command[1])
        return self.setpoint()


class Pace(NamedTuple):
    """How the time of a motion goes on: r = d tau/dt is quadratic between nodes."""

    t: FloatArray
    """Nodes, rising from 0, shape (m,), s."""
    tau: FloatArray
    """Time of the motion there, shape (m,), s."""
    rate: FloatArray
    """d tau/dt there, shape (m,)."""
    change: FloatArray
    """Its derivative by time there, shape (m,), 1/s."""
    push: FloatArray
    """Second derivative from there on, shape (m,), 1/s2."""


def slow_down_from(envelope: Envelope, t: float) -> Pace:
    """Give the pace by which a motion under way as planned comes to rest on its path.

    Args:
        envelope: The motion; it ends at rest.
        t: When it is left, s.

    Returns:
        The pace, to its rest or to the end of the motion.
    """
    end = float(envelope.edges[-1])
    h = min(max((end - t) / _STEPS, 1e-4), 2e-2)
    command = np.array([0.0, h, envelope.highest_push, 1.0, 1.0])
    return slow_down(envelope, np.array([t, 1.0, 0.0]), command, end)


def slow_down(envelope: Envelope, state: FloatArray, command: FloatArray, end: float) -> Pace:
    """Give the pace by which a motion comes to rest on its path as soon as the limits allow.

    Args:
        envelope: The motion.
        state: Its time, its pace and how that changes, when it is left, shape (3,).
        command: As the kernel has it, with the way on that is known from there, shape (5,).
        end: When the motion comes to rest by itself, s.

    Returns:
        The pace, to its rest or to that end.
    """
    out = np.empty((_MOST_STEPS, 4))
    e = envelope
    moved = np.array(state)
    count = _kernels().run(e.edges, e.box, e.limits, command, moved, np.empty((3, 3)), out)
    beyond = int(np.searchsorted(out[:count, 0], end))
    rows = out[: min(count, beyond + 1)]
    t = command[1] * np.arange(len(rows))
    pace = Pace(t, rows[:, 0], rows[:, 1], rows[:, 2], rows[:, 3])
    return pace if rows[-1, 0] < end else _until(pace, end)


def _until(pace: Pace, end: float) -> Pace:
    """Give a pace up to the moment at which a motion ends."""
    t, tau, r, p, w = (values[-2] for values in pace)
    low, high = 0.0, float(pace.t[-1] - t)
    for _ in range(_HALVINGS):
        dt = 0.5 * (low + high)
        if tau + dt * (r + dt * (0.5 * p + dt * w / 6.0)) < end:
            low = dt
        else:
            high = dt
    last = (t + high, end, r + high * (p + 0.5 * high * w), p + high * w, 0.0)
    return Pace(*(np.append(v[:-1], x) for v, x in zip(pace, last, strict=True)))
