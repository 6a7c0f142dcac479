"""How a motion ended: as a word, as a code that ROS knows, and with what is left of it."""

from dataclasses import dataclass
from enum import Enum, IntEnum

from splinearm.errors import (
    BusError,
    ConfigError,
    FollowingError,
    KinematicsError,
    MotionError,
    SplinearmError,
    StartError,
    TrajectoryError,
)

from .stopped import StoppedMotion


class Outcome(Enum):
    """How a motion ended."""

    FINISHED = "finished"
    """The arm is where the motion ends."""

    STOPPED = "stopped"
    """A stop was asked for; the arm holds on its path."""

    FAILED = "failed"
    """A fault; the arm was stopped along its path if it could still be told to."""


class ExitReason(IntEnum):
    """Why a motion ended, as ``control_msgs/action/FollowJointTrajectory`` numbers it.

    That has fewer words than there are reasons; what is meant here:
    """

    SUCCESSFUL = 0
    """The arm arrived, every joint within its goal tolerance."""

    INVALID_GOAL = -1
    """Refused before anything moved: the motion breaks a limit, starts elsewhere, cannot be made,
    or the arm is not ready for one."""

    INVALID_JOINTS = -2
    """Refused before anything moved: the motion is for other joints than the arm has."""

    OLD_HEADER_TIMESTAMP = -3
    """Never given: motions begin when they are asked for, whatever their header says."""

    PATH_TOLERANCE_VIOLATED = -4
    """Stopped on the way: a joint left its path tolerance, or it can no longer be told whether it
    did (no feedback, a servo's fault, a computer that was too late)."""

    GOAL_TOLERANCE_VIOLATED = -5
    """The arm is not at the goal: it did not settle within its tolerance, or a stop was asked
    for on the way there."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Ending:
    """How a motion ended that was begun."""

    outcome: Outcome
    """The word."""
    reason: ExitReason
    """The code."""
    fault: MotionError | None = None
    """What went wrong, if something did."""
    stopped: StoppedMotion | None = None
    """Where the motion was left and what remains of it; None if it was finished."""


def reason_of(error: SplinearmError, *, at_goal: bool = False) -> ExitReason:
    """Give the code of an error.

    Args:
        error: What was raised, or is the fault of an ending.
        at_goal: Whether the motion had run to its end by then.
    """
    if isinstance(error, ConfigError) and error.key == "joints":
        return ExitReason.INVALID_JOINTS
    if isinstance(error, StartError | ConfigError | KinematicsError | TrajectoryError | BusError):
        return ExitReason.INVALID_GOAL
    if isinstance(error, FollowingError) and at_goal:
        return ExitReason.GOAL_TOLERANCE_VIOLATED
    return ExitReason.PATH_TOLERANCE_VIOLATED
