"""Pieces of jobs: what is carried out one after the other.

A job file has ``[[piece]]`` tables in place of ``[[waypoint]]``. Each is one of::

    motion = "wave.json"    a motion that was saved, as seen from the job file
    job = "reach.toml"      the motion of another job, which has waypoints
    knots = [...] ...       a motion that was taught; see ``splinearm.config.taught``
    gripper = "close"       what the gripper does; see below

and may say besides::

    name                    what it is called
    times                   how often it is carried out (default 1, at most 10000)

What a gripper does, in a piece or in a ``[[waypoint]]``, where the arm stops for it::

    gripper                 "open", "close", or how far it shall be open, 0 to 100
    force_percent           how hard, a share of its servo's stall torque; without it as the arm's
                            file says
    wait_s                  how long the arm waits besides, once the gripper stands (default 0)
    must_hold               true: the arm stops if the gripper holds nothing then, or loses it
                            before it is told to move again
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from splinearm.arrays import FloatArray
from splinearm.trajectories.taught import TaughtMotion

from .cell import Cell
from .motion import SavedMotion, load_motion
from .reader import Table
from .taught import TAUGHT_KEY, read_taught

if TYPE_CHECKING:
    from .job import Job

_WORDS = {"open": 100.0, "close": 0.0}
_KINDS = ("motion", "job", TAUGHT_KEY, "gripper")
_OFTEN = 10_000
"""Every repetition is a step that is known before anything moves."""
_GRIP_KEYS = ("force_percent", "must_hold", "wait_s")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class GripAction:
    """What a gripper shall do."""

    percent: float
    """How far it shall be open: 0 is closed, 100 is open."""
    force: float | None = None
    """How hard it may press, a share of its servo's stall torque; None: as the arm's file says."""
    wait: float = 0.0
    """How long the arm waits besides, s."""
    must_hold: bool = False
    """Whether the arm stops if it holds nothing then, or loses it."""

    @property
    def words(self) -> str:
        """The same in words."""
        known = {percent: word for word, percent in _WORDS.items()}
        return f"gripper: {known.get(self.percent, f'{self.percent:g} % open')}"


Content: TypeAlias = "TaughtMotion | SavedMotion | Job | GripAction"
"""What a piece may be."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Piece:
    """One piece of a job."""

    name: str
    """What it is called."""
    content: Content
    """What it is."""
    times: int = 1
    """How often it is carried out."""


def read_pieces(
    tables: Sequence[Table], file: Path, cell: Cell, load_job: Callable[[Path], "Job"]
) -> tuple[Piece, ...]:
    """Read the pieces of a job.

    Args:
        tables: The tables ``[[piece]]``.
        file: The job file.
        cell: Its arm.
        load_job: Reads another job for the same arm.

    Raises:
        ConfigError: With the key that is not right.
    """
    return tuple(_read_piece(table, i + 1, file, cell, load_job) for i, table in enumerate(tables))


def start_of(pieces: Sequence[Piece]) -> FloatArray | None:
    """Give where the first piece that moves the arm begins, shape (n,); None if none does."""
    for piece in pieces:
        content = piece.content
        if isinstance(content, SavedMotion):
            return content.trajectory.q_start
        if not isinstance(content, GripAction):
            return content.q_start
    return None


def read_grip(table: Table) -> GripAction | None:
    """Read what the gripper does by the table of a piece or waypoint; None if it says nothing.

    Raises:
        ConfigError: With the key that is not right.
    """
    if "gripper" not in table:
        for key in _GRIP_KEYS:
            if key in table:
                raise table.refuse(key, "is for the gripper; say what it does (gripper = ...)")
        return None
    if table.is_text("gripper"):
        percent = _WORDS[table.choice("gripper", _WORDS)]
    else:
        percent = table.number("gripper", low=0.0, high=100.0)
    return GripAction(
        percent=percent,
        force=table.number("force_percent", above=0.0, high=1.0)
        if "force_percent" in table
        else None,
        wait=table.number("wait_s", 0.0, low=0.0),
        must_hold=table.flag("must_hold"),
    )


def _read_piece(
    table: Table, number: int, file: Path, cell: Cell, load_job: Callable[[Path], "Job"]
) -> Piece:
    name = table.text("name", f"piece {number}")
    times = table.integer("times", 1, low=1, high=_OFTEN)
    given = [key for key in _KINDS if key in table]
    if not given:
        raise table.refuse(
            "", "is nothing; give a motion, a job, a gripper or a taught curve (knots)"
        )
    if len(given) > 1:
        raise table.refuse(given[1], f"contradicts {given[0]}; make two pieces of it")
    content = _read_content(table, given[0], file, cell, load_job)
    table.finish()
    return Piece(name=name, content=content, times=times)


def _read_content(
    table: Table, kind: str, file: Path, cell: Cell, load_job: Callable[[Path], "Job"]
) -> Content:
    action = read_grip(table)  # which refuses its keys where there is no gripper
    if action is not None:
        return action
    if kind == "motion":
        return load_motion(_file(table, kind, file), cell.arm.limits)
    if kind == "job":
        other = _file(table, kind, file)
        job = load_job(other)
        if job.pieces or job.program is not None:
            raise table.refuse(kind, f"{other} has no waypoints; a piece is a job that has")
        return job
    return read_taught(table, cell.arm.limits)


def _file(table: Table, key: str, file: Path) -> Path:
    """Give the file that a key names, as seen from the job's."""
    named = file.parent / table.text(key)
    if not named.is_file():
        raise table.refuse(key, f"{named} is no file")
    return named
