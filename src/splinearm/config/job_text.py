"""How jobs that are written by commands begin."""

import os
from pathlib import Path

from splinearm.arrays import FloatArray

from .cell import Cell, arm_file, shipped_arms
from .folder import quoted
from .job import JOB_SCHEMA
from .taught import numbers_text
from .unit import positions_key


def job_head(file: Path, cell: Cell, *, name: str, title: str, start: FloatArray) -> str:
    """Give the first lines of a job.

    Args:
        file: Where it will lie.
        cell: Its arm.
        name: What it is called.
        title: What it is, in words.
        start: Where it starts, shape (n,), deg or mm.
    """
    return (
        f'schema = "{JOB_SCHEMA}"\n'
        f"name = {quoted(name)}\n"
        f"title = {quoted(title)}\n"
        f"arm = {quoted(_arm_word(cell, file))}\n"
        f"{positions_key('start', cell.arm.limits.kinds)} = {numbers_text(start)}\n"
    )


def _arm_word(cell: Cell, file: Path) -> str:
    """Give how a job in a file names an arm: a shipped one by its name, others by their path."""
    if cell.name in shipped_arms() and arm_file(cell.name) == cell.file:
        return cell.name
    return Path(os.path.relpath(cell.file.resolve(), file.resolve().parent)).as_posix()
