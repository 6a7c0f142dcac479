"""How the command line shows things: tables, progress, one console."""

import sys
from collections.abc import Sequence

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.table import Table

_PIPED_WIDTH = 160
"""Columns of what goes to a file or another program, where nothing says how wide it is."""

console = Console(width=None if sys.stdout.isatty() else _PIPED_WIDTH, markup=False)
"""Where commands print. Names, titles and files are shown as they are, also those with brackets."""


def table(columns: Sequence[str], rows: Sequence[Sequence[str]], title: str | None = None) -> Table:
    """Give a table; columns after the first that hold numbers only are set to the right."""
    result = Table(title=title, title_justify="left")
    for i, name in enumerate(columns):
        numeric = i > 0 and all(_is_number(row[i]) for row in rows)
        # on a narrow terminal words go on in the next line; cut off they would be lost
        result.add_column(name, justify="right" if numeric else "left", overflow="fold")
    for row in rows:
        result.add_row(*row)
    return result


def _is_number(text: str) -> bool:
    try:
        float(text.rstrip("%"))
    except ValueError:
        return text in ("", "-")
    return True


def progress() -> Progress:
    """Give a progress bar with the time left."""
    return Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TaskProgressColumn(),
        TimeRemainingColumn(),
        console=console,
    )
