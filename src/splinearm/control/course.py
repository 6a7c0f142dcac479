"""Where a motion is in each cycle: as planned, at another pace, or on its way to rest."""

from splinearm.joints import JointSetpoint
from splinearm.trajectories.pace import PacedMotion
from splinearm.trajectories.trajectory import JointTrajectory

from .override import PaceRequest
from .stopped import StoppedMotion


class Course:
    """The setpoints of a motion by cycle.

    Its time is ``anchor_t`` at the cycle ``anchor`` and runs with the cycles from there.

    Args:
        trajectory: The motion.
        period: Time between cycles, s.
        pace: Where another pace is asked for, or None.
    """

    def __init__(
        self, trajectory: JointTrajectory, period: float, pace: PaceRequest | None = None
    ) -> None:
        self.motion = trajectory
        """What is followed: the motion, then its stop."""
        self.stopped: StoppedMotion | None = None
        """Where the motion will rest, once it is being stopped."""
        self._period = period
        self._pace = pace
        self._paced: PacedMotion | None = None
        if pace is not None and trajectory.duration > 0.0:
            self._paced = PacedMotion(trajectory, period)
        self._stepped = 0
        self._anchor = 0
        self._anchor_t = 0.0
        self._begun = trajectory

    def t(self, index: int) -> float:
        """Give the time along the motion in a cycle, s; it may be beyond its end."""
        if self._paced is not None:
            return self._paced.motion_t
        return (index - self._anchor) * self._period + self._anchor_t

    def ended(self, index: int) -> bool:
        """Tell whether the motion has run to its end."""
        return self.t(index) >= self.motion.duration

    def setpoint(self, index: int) -> JointSetpoint:
        """Give the setpoint of a cycle, which is not before the last one."""
        if self._paced is not None and self._pace is not None:
            while self._stepped < index:
                self._paced.ask(self._pace.pace)
                self._paced.step()
                self._stepped += 1
            if not self._paced.finished:
                return self._paced.setpoint()
            self._paced = None
            self.anchor(index, self.motion.duration)
        return self.motion.at(min(self.t(index), self.motion.duration))

    def anchor(self, index: int, t: float) -> None:
        """Let the motion be at a time in a cycle, whatever was before."""
        self._anchor, self._anchor_t = index, t

    def stop(self, index: int) -> None:
        """Let the motion end along its path, from a cycle on."""
        t = min(self.t(index), self.motion.duration)
        if self._paced is not None:
            stop, self._paced = self._paced.stop(), None
        else:
            stop = self.motion.stop_from(t)
        self.stopped = StoppedMotion.of(self._begun, t, stop)
        self.motion = stop
        self.anchor(index, 0.0)

    def cut(self, t: float) -> StoppedMotion:
        """Give where the motion is left by an arm that got its last setpoint at a time of it."""
        return self.stopped or StoppedMotion(self._begun, min(t, self._begun.duration))
