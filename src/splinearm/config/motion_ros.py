"""Motions in the shape of ROS messages, ``trajectory_msgs/JointTrajectory``."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointLimits
from splinearm.trajectories.sampled import Rows, trajectory_of
from splinearm.trajectories.trajectory import JointTrajectory

_NANO = 1_000_000_000


def is_message(values: object) -> bool:
    """Tell whether JSON values have the shape of the message."""
    return isinstance(values, Mapping) and "joint_names" in values and "points" in values


def to_message(names: Sequence[str], rows: Rows) -> dict[str, Any]:
    """Give rows as a message; its times are whole nanoseconds."""
    empty = np.empty((len(rows.t), 0))
    qd = empty if rows.qd is None else rows.qd
    qdd = empty if rows.qdd is None else rows.qdd
    points = []
    for i, t in enumerate(rows.t.tolist()):
        sec, nanosec = divmod(round(t * _NANO), _NANO)
        points.append(
            {
                "positions": rows.q[i].tolist(),
                "velocities": qd[i].tolist(),
                "accelerations": qdd[i].tolist(),
                "effort": [],
                "time_from_start": {"sec": sec, "nanosec": nanosec},
            }
        )
    header = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    return {"header": header, "joint_names": list(names), "points": points}


def from_message(values: object, limits: JointLimits) -> JointTrajectory:
    """Give the motion of a message; its joints may stand in another order.

    Raises:
        ValueError: With the point that is not right.
    """
    if not isinstance(values, Mapping) or not is_message(values):
        raise ValueError("want a message with joint_names and points")
    order = _order(values["joint_names"], limits.names)
    points = values["points"]
    if not isinstance(points, Sequence) or not points:
        raise ValueError("points: want at least two, got none")
    t = np.array([_time(point, i) for i, point in enumerate(points)])
    q = _column(points, "positions", order)
    if q is None:
        raise ValueError("points[0].positions: want one number a joint, got none")
    return trajectory_of(
        limits, t, q, _column(points, "velocities", order), _column(points, "accelerations", order)
    )


def _order(given: object, names: tuple[str, ...]) -> list[int]:
    """Give for each joint of the arm its place in the message."""
    if not isinstance(given, Sequence) or sorted(map(str, given)) != sorted(names):
        raise ValueError(f"joint_names: want {', '.join(names)} in any order, got {given!r}")
    return [list(given).index(name) for name in names]


def _time(point: object, i: int) -> float:
    try:
        told = point["time_from_start"]  # type: ignore[index] # what is wrong is said below
        return float(told["sec"]) + float(told["nanosec"]) / _NANO
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"points[{i}].time_from_start: want sec and nanosec") from error


def _column(points: Sequence[Any], key: str, order: list[int]) -> FloatArray | None:
    """Give one quantity of all points, joints in the arm's order; None if no point says it."""
    told = [point.get(key, []) if isinstance(point, Mapping) else [] for point in points]
    if not any(len(values) for values in told):
        return None
    for i, values in enumerate(told):
        if len(values) != len(order):
            raise ValueError(f"points[{i}].{key}: want {len(order)} numbers, got {len(values)}")
    try:
        return np.array(told, dtype=np.float64)[:, order]
    except (TypeError, ValueError) as error:
        raise ValueError(f"points: {key} are not all numbers") from error
