"""Places that an arm was jogged to, written as waypoints of a job."""

import tomllib
from itertools import count
from pathlib import Path

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.config import Cell
from splinearm.config.job import JOB_SCHEMA
from splinearm.config.job_text import job_head
from splinearm.config.unit import positions_key
from splinearm.errors import ConfigError
from splinearm.kinematics import quaternion

_MOTION = """
[motion]
through = "joint"
limits_percent = 30.0
"""
_DECIMALS = 3
"""So many have degrees and millimetres of a place."""


class WaypointFile:
    """A job file to which places are appended.

    In a file that is not there yet the first place becomes the start of a new job.

    Args:
        file: The file; None: the lines are only given.
        cell: The arm.

    Raises:
        ConfigError: If the file cannot be read, is none of TOML, or is a job without waypoints.
    """

    def __init__(self, file: Path | None, cell: Cell) -> None:
        self._file = file
        self._cell = cell
        self._names: set[str] = set()
        self.lines: list[str] = []
        """What was saved, ready to be pasted into a job."""
        if file is not None and file.exists():
            self._names = _names_in(file)

    def save(self, q: FloatArray) -> str:
        """Append a place; give in words what was done.

        Args:
            q: The joint positions, shape (n,), rad or m.

        Raises:
            ConfigError: If the file cannot be written.
        """
        file = self._file
        if file is not None and not file.exists():
            start = np.round(self._cell.to_file_units(q), _DECIMALS)
            title = f"{file.stem}, as jogged"
            head = job_head(file, self._cell, name=file.stem, title=title, start=start)
            self._append(file, head + _MOTION)
            return f"a new job starts here, w again adds waypoints: {file}"
        name = next(name for k in count(1) if (name := f"p{k}") not in self._names)
        self._names.add(name)
        text = self._waypoint(name, q)
        self.lines.append(text)
        if file is None:
            return f"waypoint {name}: its lines are printed in the end"
        self._append(file, "\n" + text)
        return f"waypoint {name} is in {file}"

    def _waypoint(self, name: str, q: FloatArray) -> str:
        key = positions_key("joints", self._cell.arm.limits.kinds)
        numbers = ", ".join(f"{value:.{_DECIMALS}f}" for value in self._cell.to_file_units(q))
        place = f"{key} = [{numbers}]  # {pose_words(self._cell, q)}"
        return f'[[waypoint]]\nname = "{name}"\n{place}\n'

    def _append(self, file: Path, text: str) -> None:
        try:
            with file.open("a", encoding="utf-8") as stream:
                stream.write(text)
        except OSError as error:
            raise ConfigError(file, "", f"cannot be written: {error.strerror}") from error


def _names_in(file: Path) -> set[str]:
    """Give the names of a job's waypoints."""
    try:
        job = tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ConfigError(file, "", f"cannot be added to: {error}") from error
    for key in ("piece", "toolpath"):
        if key in job:
            raise ConfigError(file, key, "a job with this takes no waypoints; name another")
    waypoints = job.get("waypoint", [])
    if job.get("schema") != JOB_SCHEMA or not isinstance(waypoints, list):
        raise ConfigError(file, "", "is no job file; name one, or one that is not there yet")
    return {str(each.get("name")) for each in waypoints if isinstance(each, dict)}


def pose_words(cell: Cell, q: FloatArray) -> str:
    """Give the pose of the tool in base in words, of joint positions of shape (n,), rad or m."""
    T = cell.arm.fk(q)
    x, y, z = T[:3, 3] * 1e3 + 0.0
    angles = np.degrees(quaternion.to_euler(quaternion.from_matrix(T[:3, :3]), "xyz"))
    roll, pitch, yaw = np.round(angles, 1) + 0.0
    return (
        f"x {x:.1f}  y {y:.1f}  z {z:.1f} mm  roll {roll:.1f}  pitch {pitch:.1f}  yaw {yaw:.1f} deg"
    )
