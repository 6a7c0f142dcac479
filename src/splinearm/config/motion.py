"""Motion files: a planned motion kept without loss, or as rows for other programs.

What a file holds follows from its name::

    NAME.json       the motion itself, to the last bit (``splinearm-motion/1``)
    NAME.ros.json   a ``trajectory_msgs/JointTrajectory`` message, sampled
    NAME.csv        a table in degrees, millimetres and seconds, sampled

Rows come back as the motion through them: see ``trajectories.sampled``.
"""

import json
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from splinearm.errors import ConfigError
from splinearm.joints import JointLimits
from splinearm.trajectories import document, sampled
from splinearm.trajectories.trajectory import JointTrajectory

from . import motion_csv, motion_ros

_ENDINGS = (".json", ".csv")


@dataclass(frozen=True, slots=True, eq=False)
class SavedMotion:
    """A motion from a file."""

    trajectory: JointTrajectory
    """The motion."""
    arm: str
    """Name of the arm that it is for; empty if the file does not say."""


def check_motion_file(file: str | PathLike[str]) -> None:
    """Refuse a name that says nothing of what the file shall hold.

    Raises:
        ConfigError: With the endings that do.
    """
    if Path(file).suffix.lower() not in _ENDINGS:
        raise ConfigError(file, "", "a motion's name ends in .json, .ros.json or .csv")


def save_motion(
    file: str | PathLike[str], trajectory: JointTrajectory, *, arm: str = "", rate: float = 100.0
) -> None:
    """Write a motion into a new file, in the form that its name asks for.

    Args:
        file: The file; it must not be there yet.
        trajectory: The motion.
        arm: Name of the arm that it is for, kept in ``.json``.
        rate: Rows a second in ``.ros.json`` and ``.csv``, Hz.

    Raises:
        ConfigError: If the file is there already, cannot be written, or its name says no form.
        ValueError: If the rate is not above 0.
    """
    check_motion_file(file)
    path, limits = Path(file), trajectory.limits
    if _is_ros(path):
        rows = sampled.rows_of(trajectory, rate)
        text = json.dumps(motion_ros.to_message(limits.names, rows), indent=1)
    elif path.suffix.lower() == ".csv":
        text = motion_csv.to_text(limits, sampled.rows_of(trajectory, rate))
    else:
        text = json.dumps(document.to_document(trajectory, arm))
    try:
        with path.open("x", encoding="utf-8", newline="") as out:
            out.write(text + "\n" if not text.endswith("\n") else text)
    except FileExistsError as error:
        raise ConfigError(file, "", "is there already and is not overwritten") from error
    except OSError as error:
        raise ConfigError(file, "", f"cannot be written: {error.strerror}") from error


def load_motion(file: str | PathLike[str], limits: JointLimits | None = None) -> SavedMotion:
    """Read a motion file.

    Args:
        file: The file.
        limits: The joints of the arm that shall move: rows need them, as they say no limits. A
            motion that brings its own must be for joints of the same names, and gets these.

    Raises:
        ConfigError: If the file cannot be read, is not what its name says, or does not fit the
            joints.
    """
    check_motion_file(file)
    path = Path(file)
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise ConfigError(file, "", f"cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ConfigError(file, "", "is not text in UTF-8") from error
    try:
        if path.suffix.lower() == ".csv":
            return SavedMotion(motion_csv.from_text(text, _needed(limits)), "")
        values = json.loads(text)
        if _is_ros(path) or motion_ros.is_message(values):
            return SavedMotion(motion_ros.from_message(values, _needed(limits)), "")
        return _exact(values, limits)
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}"
        raise ConfigError(file, where, f"is not JSON: {error.msg}") from error
    except RecursionError as error:
        raise ConfigError(file, "", "is nested too deeply to be a motion") from error
    except (TypeError, ValueError) as error:
        raise ConfigError(file, "", str(error)) from error


def _is_ros(path: Path) -> bool:
    return path.name.lower().endswith(".ros.json")


def _needed(limits: JointLimits | None) -> JointLimits:
    if limits is None:
        raise ValueError("says no limits; name the arm that it is for")
    return limits


def _exact(values: object, limits: JointLimits | None) -> SavedMotion:
    if not isinstance(values, dict):
        raise TypeError(f"want a motion, got {type(values).__name__}")
    trajectory = document.from_document(values)
    if limits is not None:
        if limits.names != trajectory.limits.names:
            theirs, ours = ", ".join(trajectory.limits.names), ", ".join(limits.names)
            raise ValueError(f"is for joints {theirs}; the arm has {ours}")
        trajectory = JointTrajectory(trajectory.sections, trajectory.q_start, limits)
    return SavedMotion(trajectory, str(values.get("arm", "")))
