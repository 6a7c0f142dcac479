"""Job files of taught pieces: written anew, or added to."""

import os
from collections.abc import Sequence
from pathlib import Path

from splinearm.config import Cell, load_job, shipped_arms
from splinearm.config.folder import write_whole
from splinearm.config.taught import taught_text
from splinearm.config.unit import positions_key
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
    kinds = cell.arm.limits.kinds
    start = next(
        line for line in taught_text(first, kinds).splitlines() if line.startswith("    [")
    ).strip(" ,")
    head = (
        'schema = "splinearm-job/1"\n'
        f"name = {_quoted(name)}\n"
        f"title = {_quoted(f'{name}, taught by hand')}\n"
        f"arm = {_quoted(_arm_word(cell, file))}\n"
        f"{positions_key('start', kinds)} = {start}\n\n"
        '[motion]\ntiming = "recorded"\n'
    )
    write_whole(file, head + pieces_text(pieces, cell, 1))


def append_to_job(file: Path, cell: Cell, pieces: Sequence[Piece]) -> None:
    """Add pieces to a job that has pieces; if the result were no job the file stays as it is.

    Raises:
        ConfigError: If the job is for another arm or has no pieces, or cannot be written.
    """
    check_appendable(file, cell)
    text = file.read_text(encoding="utf-8-sig")
    count = sum(line.strip() == "[[piece]]" for line in text.splitlines())
    draft = file.with_name(f".{file.stem}.{os.getpid()}.toml")
    whole = text.rstrip("\n") + "\n" + pieces_text(pieces, cell, count + 1)
    try:
        write_whole(draft, whole)
        load_job(draft, arm=cell.file)
    finally:
        draft.unlink(missing_ok=True)
    write_whole(file, whole)


def check_appendable(file: Path, cell: Cell) -> None:
    """Refuse a job to which pieces cannot be added, before anybody teaches some.

    Raises:
        ConfigError: With the reason.
    """
    job = load_job(file, arm=cell.file)
    if job.waypoints or job.program is not None:
        raise ConfigError(
            file, "", "has no pieces to which others could be added; write a job of its own (-o)"
        )


def pieces_text(pieces: Sequence[Piece], cell: Cell, number: int) -> str:
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


def _arm_word(cell: Cell, file: Path) -> str:
    """Give how a job in a file names an arm: a shipped one by its name, others by their path."""
    if cell.name in shipped_arms() and load_path(cell.name) == cell.file:
        return cell.name
    return Path(os.path.relpath(cell.file.resolve(), file.resolve().parent)).as_posix()


def load_path(name: str) -> Path:
    """Give the file of a shipped arm."""
    from splinearm.config import load_cell

    return load_cell(name).file


def _quoted(text: str) -> str:
    plain = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{plain}"'
