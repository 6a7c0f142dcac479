"""splinearm plans robot-arm motions as B-splines and carries them out.

This is the front door: the names below are the public ones, loaded when first used, so that
``import splinearm`` loads nothing else.
"""

import sys
from importlib import import_module
from typing import TYPE_CHECKING

if sys.version_info < (3, 11):  # noqa: UP036 - a checkout may be run by any Python
    found = ".".join(map(str, sys.version_info[:3]))
    sys.stderr.write(
        "splinearm: C01 Python is too old: this is " + found + "; install Python 3.11 or newer\n"
    )
    raise SystemExit(2)

if TYPE_CHECKING:
    from .backends import open_arm as open_arm
    from .config import load_cell as load_cell
    from .config import load_job as load_job
    from .config import load_motion as load_motion
    from .config import save_motion as save_motion
    from .config import shipped_arms as shipped_arms
    from .control.follow import Loop as Loop
    from .control.guard import Guard as Guard
    from .control.guard import Tolerances as Tolerances
    from .control.record import Recorder as Recorder
    from .curves.bspline import BSpline as BSpline
    from .errors import SplinearmError as SplinearmError
    from .joints import JointLimits as JointLimits
    from .joints import JointSetpoint as JointSetpoint
    from .joints import JointState as JointState
    from .kinematics.arm import Arm as Arm
    from .kinematics.dh import DHConvention as DHConvention
    from .kinematics.dh import DHLink as DHLink
    from .kinematics.pose import Pose as Pose
    from .runner import plan_job as plan_job
    from .runner import run_job as run_job
    from .trajectories.limit import MotionLimits as MotionLimits
    from .trajectories.plan import plan as plan
    from .trajectories.point_to_point import point_to_point as point_to_point
    from .trajectories.trajectory import JointTrajectory as JointTrajectory
    from .trajectories.waypoint import ArcAbout as ArcAbout
    from .trajectories.waypoint import ArcThrough as ArcThrough
    from .trajectories.waypoint import Facing as Facing
    from .trajectories.waypoint import Move as Move
    from .trajectories.waypoint import Waypoint as Waypoint

_HOME = {
    "ArcAbout": "trajectories.waypoint",
    "ArcThrough": "trajectories.waypoint",
    "Arm": "kinematics.arm",
    "BSpline": "curves.bspline",
    "DHConvention": "kinematics.dh",
    "DHLink": "kinematics.dh",
    "Facing": "trajectories.waypoint",
    "Guard": "control.guard",
    "JointLimits": "joints",
    "JointSetpoint": "joints",
    "JointState": "joints",
    "JointTrajectory": "trajectories.trajectory",
    "Loop": "control.follow",
    "MotionLimits": "trajectories.limit",
    "Move": "trajectories.waypoint",
    "Pose": "kinematics.pose",
    "Recorder": "control.record",
    "SplinearmError": "errors",
    "Tolerances": "control.guard",
    "Waypoint": "trajectories.waypoint",
    "load_cell": "config",
    "load_job": "config",
    "load_motion": "config",
    "open_arm": "backends",
    "plan": "trajectories.plan",
    "plan_job": "runner",
    "point_to_point": "trajectories.point_to_point",
    "run_job": "runner",
    "save_motion": "config",
    "shipped_arms": "config",
}


def __getattr__(name: str) -> object:
    """Load a public name from its room."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOME[name]}", __name__), name)


def __dir__() -> list[str]:
    """Give the public names."""
    return sorted(_HOME)
