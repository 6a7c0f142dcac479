"""How long and how far an arm goes on after a stop is asked for, known before it moves."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointKind
from splinearm.trajectories.trajectory import JointTrajectory
from splinearm.units import DEG, MM

_MOMENTS = 60
_LOOKS = 20


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class StopForecast:
    """The worst stop of a motion; each figure is that of the moment at which it is worst."""

    time: float
    """How long it takes, s."""
    tool: float
    """How far the tool goes on along its path, m; NaN if it is not known where the tool is."""
    joint: str
    """The joint that goes on farthest."""
    travel: float
    """How far that is, rad or m."""
    linear: bool
    """Whether that joint slides."""

    @property
    def words(self) -> str:
        """The figures in one line."""
        tool = "" if np.isnan(self.tool) else f"within {self.tool / MM:.1f} mm of the tool's path, "
        return f"a stop takes up to {self.time:.2f} s, {tool}{self._joint}"

    @property
    def _joint(self) -> str:
        return _travel_words(self.travel, self.joint, linear=self.linear)


def forecast_stops(
    trajectory: JointTrajectory, tool: Callable[[FloatArray], FloatArray] | None = None
) -> StopForecast:
    """Look at stops from many moments of a motion.

    Args:
        trajectory: The motion.
        tool: Gives the positions of the tool, shape (m, 3), m, for joints of shape (m, n).
    """
    time, way = 0.0, 0.0 if tool is not None else float("nan")
    travel = np.zeros(trajectory.n)
    for t in np.linspace(0.0, trajectory.duration, _MOMENTS + 2)[1:-1]:
        stop = trajectory.stop_from(float(t))
        time = max(time, stop.duration)
        q, _, _ = stop.sample(np.linspace(0.0, stop.duration, _LOOKS))
        travel = np.maximum(travel, np.abs(np.diff(q, axis=0)).sum(axis=0))
        if tool is not None:
            way = max(way, float(np.linalg.norm(np.diff(tool(q), axis=0), axis=1).sum()))
    limits = trajectory.limits
    worst = int(np.argmax(travel))
    return StopForecast(
        time=time,
        tool=way,
        joint=limits.names[worst],
        travel=float(travel[worst]),
        linear=limits.kinds[worst] is JointKind.PRISMATIC,
    )


def joint_travel(stop: JointTrajectory) -> str:
    """Say how far the joint that goes farthest goes on in a stop."""
    away = np.abs(stop.q_goal - stop.q_start)
    worst = int(np.argmax(away))
    linear = stop.limits.kinds[worst] is JointKind.PRISMATIC
    return _travel_words(float(away[worst]), stop.limits.names[worst], linear=linear)


def _travel_words(travel: float, joint: str, *, linear: bool) -> str:
    unit, name = (MM, "mm") if linear else (DEG, "deg")
    return f"{travel / unit:.1f} {name} of joint {joint!r}"
