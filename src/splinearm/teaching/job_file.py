"""Job files of taught pieces: written anew, or added to."""

import os
from collections.abc import Sequence
from pathlib import Path

from splinearm.config import Cell, Job, load_job
from splinearm.config.folder import write_whole
from splinearm.config.job_text import job_head
from splinearm.config.taught import taught_text
from splinearm.errors import ConfigError
from splinearm.trajectories.taught import TaughtMotion

from .session import Grip

Piece = TaughtMotion | Grip
"""What a job carries out."""


def new_job(file: Path, cell: Cell, pieces: Sequence[Piece], name: str) -> None:
    """Write a job that carries out pieces.

    Args:
        file: The job's file; it must not be there yet.
        cell: The arm.
        pieces: The pieces, at least one of them a motion.
        name: What the job is called.

    Raises:
        ConfigError: If the file is there, or cannot be written.
    """
    if file.exists():
        raise ConfigError(file, "", "is there already and is not overwritten; name another")
    first = next(piece for piece in pieces if isinstance(piece, TaughtMotion))
    start = cell.to_file_units(first.points[0])
    head = job_head(file, cell, name=name, title=f"{name}, taught by hand", start=start)
    write_whole(file, f'{head}\n[motion]\ntiming = "recorded"\n{_pieces_text(pieces, cell, 1)}')


def append_to_job(file: Path, cell: Cell, pieces: Sequence[Piece]) -> None:
    """Add pieces to a job that has pieces; if the result were no job the file stays as it is.

    Raises:
        ConfigError: If the job is for another arm or has no pieces, or cannot be written.
    """
    job = appendable(file, cell)
    text = file.read_text(encoding="utf-8-sig")
    draft = file.with_name(f".{file.stem}.{os.getpid()}.toml")
    whole = text.rstrip("\n") + "\n" + _pieces_text(pieces, cell, len(job.pieces) + 1)
    try:
        write_whole(draft, whole)
        load_job(draft, arm=cell.file)
    finally:
        draft.unlink(missing_ok=True)
    write_whole(file, whole)


def appendable(file: Path, cell: Cell) -> Job:
    """Read a job to which pieces can be added; refuse another before anybody teaches some.

    Raises:
        ConfigError: With the reason.
    """
    job = load_job(file, arm=cell.file)
    if job.waypoints or job.program is not None:
        raise ConfigError(
            file, "", "has no pieces to which others could be added; write a job of its own (-o)"
        )
    return job


def _pieces_text(pieces: Sequence[Piece], cell: Cell, number: int) -> str:
    """Give pieces as tables of a job, named by their numbers from ``number`` on."""
    text = []
    for i, piece in enumerate(pieces, number):
        lines = f'\n[[piece]]\nname = "piece {i}"\n'
        if isinstance(piece, TaughtMotion):
            lines += taught_text(piece, cell.arm.limits.kinds)
        else:
            lines += f'gripper = "{piece}"\n'
        text.append(lines)
    return "".join(text)
