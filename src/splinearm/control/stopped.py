"""What is left of a motion that was stopped on its path, as a motion that begins at rest."""

from dataclasses import dataclass, replace

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.trajectories.pace import Envelope, Pace, slow_down
from splinearm.trajectories.paced_law import PacedLaw
from splinearm.trajectories.section import Section
from splinearm.trajectories.trajectory import JointTrajectory

_STEPS = 200
_NEAR = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class StoppedMotion:
    """A motion and where on its path it came to rest."""

    trajectory: JointTrajectory
    """The motion."""
    t: float
    """At which time of it the arm is where it rests, s."""

    @classmethod
    def of(cls, trajectory: JointTrajectory, t: float, stop: JointTrajectory) -> "StoppedMotion":
        """Find where a motion rests after a stop.

        Args:
            trajectory: The motion.
            t: When it was left, s.
            stop: What ``stop_from`` gave for that moment.
        """
        t = min(max(t, 0.0), trajectory.duration)
        if not (stop.sections and trajectory.sections) or t >= trajectory.duration:
            return cls(trajectory, t)
        section, local = trajectory.section_at(t)
        rest = section.law.time_at(float(stop.sections[-1].law.s[-1]))
        return cls(trajectory, t - local + max(rest, local))

    @property
    def q(self) -> FloatArray:
        """Where it rests, shape (n,), rad or m."""
        return self.trajectory.at(self.t).q

    def remaining(self) -> JointTrajectory:
        """Give the rest of the motion: from rest, on its path, within its limits, to its end.

        It is soon as fast as the motion was planned there.
        """
        motion = self.trajectory
        q = self.q
        if self.t >= motion.duration:
            return JointTrajectory((), q, motion.limits)
        section, local = motion.section_at(self.t)
        later = motion.sections[motion.sections.index(section) + 1 :]
        end = section.law.duration
        if end - local > _NEAR:
            first = [replace(section, law=_from_rest(section, motion, local))]
        else:
            dwell = min(section.dwell, section.duration - local)
            still = replace(section, law=section.law.between(end, end), dwell=dwell)
            first = [still] if dwell > 0.0 else []
        return JointTrajectory((*first, *later), q, motion.limits)


def _from_rest(section: Section, motion: JointTrajectory, t: float) -> PacedLaw:
    """Give the law that takes a section up at a time, at rest there, and ends as it does."""
    end = section.law.duration
    span = (0.0, end)
    envelope = Envelope.of(section, section.nodes(), span, motion.limits)
    step = min(max((end - t) / _STEPS, 1e-4), 5e-3)
    command = np.array([1.0, step, envelope.highest_push, 1.0, 1.0])
    pace = slow_down(envelope, np.array([t, 0.0, 0.0]), command, end)
    left = end - float(pace.tau[-1])
    if left > 0.0:
        more = (float(pace.t[-1]) + left, end, 1.0, 0.0, 0.0)
        pace = Pace(*(np.append(v, x) for v, x in zip(pace, more, strict=True)))
    return PacedLaw(section.law, pace)
