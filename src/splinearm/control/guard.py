"""What a setpoint must pass before it may leave for the arm."""

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import FollowingError, LimitError, StartError, TrajectoryError
from splinearm.joints import JointKind, JointLimits, JointSetpoint, JointState
from splinearm.trajectories.trajectory import JointTrajectory

from .tolerance import Tolerances as Tolerances

# rounding, and the half period by which a setpoint may be sampled late: not a margin to use up
_SLACK = 1e-6
# share by which the mean rate between two setpoints may seem above a limit: cycle times are rounded
_STEP_SLACK = 1e-3


class Guard:
    """Refuses motions and setpoints that break a limit or do not continue the last one."""

    def __init__(self, limits: JointLimits, tolerances: Tolerances | None = None) -> None:
        self.limits = limits
        self.tolerances = Tolerances() if tolerances is None else tolerances
        self._last: JointSetpoint | None = None

    def admit(self, trajectory: JointTrajectory, period: float) -> None:
        """Pass a whole motion, or refuse it before anything moves.

        It is looked at in every cycle and four times between cycles.

        Args:
            trajectory: The motion.
            period: Time between setpoints, s.

        Raises:
            LimitError: With joint, quantity, value, limit and time.
            TrajectoryError: If it does not begin and end at rest.
        """
        for rests, what in (
            (trajectory.starts_at_rest, "begins"),
            (trajectory.ends_at_rest, "ends"),
        ):
            if not rests:
                raise TrajectoryError(f"the motion {what} while joints move, not at rest")
        count = max(2, int(np.ceil(trajectory.duration / period)) * 5 + 1)
        ts = np.linspace(0.0, trajectory.duration, count)
        q, qd, qdd = trajectory.sample(ts)
        limits = self.limits
        over = (
            (q < limits.q_min - _SLACK)
            | (q > limits.q_max + _SLACK)
            | (np.abs(qd) > limits.qd_max * (1.0 + _SLACK))
            | (np.abs(qdd) > limits.qdd_max * (1.0 + _SLACK))
        ).any(axis=1)
        if over.any():
            i = int(np.argmax(over))
            limits.check(q[i], qd[i], qdd[i], t=float(ts[i]))
        if limits.qddd_max is not None:
            jerk = trajectory.jerk(ts)
            i = int(np.argmax((np.abs(jerk) / limits.qddd_max).max(axis=1)))
            self._refuse("jerk", jerk[i], limits.qddd_max, float(ts[i]))

    def begin(self, trajectory: JointTrajectory, state: JointState, goal: FloatArray) -> None:
        """Pass an arm that is held where the motion starts; forget the last setpoint.

        Args:
            trajectory: The motion.
            state: Where the arm is; by its weight it may hang below where it is held.
            goal: Where it is held, shape (n,), rad.

        Raises:
            StartError: With the joint that is elsewhere.
        """
        start = np.broadcast_to(self.tolerances.start, goal.shape)
        sag = np.inf if self.tolerances.path is None else self.tolerances.path
        self._at_start(trajectory.q_start, goal, start)
        self._at_start(trajectory.q_start, state.q, start + sag)
        self._last = None

    def _at_start(self, start: FloatArray, q: FloatArray, tolerance: FloatArray) -> None:
        away = np.abs(q - start)
        worst = int(np.argmax(away - tolerance))
        if away[worst] > tolerance[worst]:
            raise StartError(
                self.limits.names[worst],
                float(start[worst]),
                float(q[worst]),
                float(tolerance[worst]),
                linear=self._slides(worst),
            )

    def _slides(self, joint: int) -> bool:
        return self.limits.kinds[joint] is JointKind.PRISMATIC

    def check(self, setpoint: JointSetpoint, elapsed: float) -> None:
        """Pass one setpoint that is within the limits and continues the last.

        Args:
            setpoint: What is about to be written.
            elapsed: Time of the motion since the last setpoint that was written, s.

        Raises:
            LimitError: If it breaks a limit, or is further from the last setpoint, in position,
                velocity or acceleration, than the limits allow in that time.
        """
        self.limits.check(setpoint.q, setpoint.qd, setpoint.qdd, t=setpoint.t, tolerance=_SLACK)
        if self._last is not None and elapsed > 0.0:
            rate = (setpoint.q - self._last.q) / elapsed
            self._refuse("velocity", rate, self.limits.qd_max, setpoint.t)
            gain = (setpoint.qd - self._last.qd) / elapsed
            self._refuse("acceleration", gain, self.limits.qdd_max, setpoint.t)
            if self.limits.qddd_max is not None:
                push = (setpoint.qdd - self._last.qdd) / elapsed
                self._refuse("jerk", push, self.limits.qddd_max, setpoint.t)
        self._last = setpoint

    def follows(self, setpoint: JointSetpoint, state: JointState, t: float) -> None:
        """Pass an arm that keeps up with the motion.

        Raises:
            FollowingError: With the joint that does not.
        """
        path, lag = self.tolerances.path, self.tolerances.lag
        if path is not None:
            self._near(setpoint, state, path + lag * np.abs(setpoint.qd), t)

    def arrived(self, setpoint: JointSetpoint, state: JointState) -> bool:
        """Tell whether the arm is within the goal tolerance, or need not be."""
        goal = self.tolerances.goal
        return goal is None or bool((np.abs(state.q - setpoint.q) <= goal).all())

    def require_arrival(
        self, setpoint: JointSetpoint, state: JointState, t: float, over: float
    ) -> None:
        """Pass an arm whose joints are within the goal tolerance or have time left to get there.

        Args:
            setpoint: Where it should be.
            state: Where it is.
            t: Time along the motion, for the error, s.
            over: For how long the motion has been over, s.

        Raises:
            FollowingError: With the joint that is not.
        """
        goal = self.tolerances.goal
        if goal is not None:
            settling = over < self.tolerances.settle
            tolerance = np.where(settling, np.inf, goal) + np.zeros_like(setpoint.q)
            self._near(setpoint, state, tolerance, t)

    def _near(
        self, setpoint: JointSetpoint, state: JointState, tolerance: FloatArray, t: float
    ) -> None:
        away = np.abs(state.q - setpoint.q)
        worst = int(np.argmax(away - tolerance))
        if away[worst] > tolerance[worst]:
            raise FollowingError(
                self.limits.names[worst],
                float(setpoint.q[worst]),
                float(state.q[worst]),
                float(tolerance[worst]),
                t,
                linear=self._slides(worst),
            )

    def _refuse(
        self,
        quantity: str,
        value: FloatArray,
        limit: FloatArray,
        t: float,
    ) -> None:
        over = np.abs(value) > limit * (1.0 + _STEP_SLACK)
        if over.any():
            i = int(np.argmax(over))
            raise LimitError(
                self.limits.names[i],
                quantity,
                float(value[i]),
                float(limit[i]),
                t,
                linear=self._slides(i),
            )
