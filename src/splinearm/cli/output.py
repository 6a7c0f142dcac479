"""How the command line shows things: tables, progress, one console."""

from collections.abc import Sequence

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.table import Table

console = Console()
"""Where commands print."""


def table(columns: Sequence[str], rows: Sequence[Sequence[str]], title: str | None = None) -> Table:
    """Give a table; columns after the first that hold numbers only are set to the right."""
    result = Table(title=title, title_justify="left")
    for i, name in enumerate(columns):
        numeric = i > 0 and all(_is_number(row[i]) for row in rows)
        result.add_column(name, justify="right" if numeric else "left")
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
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeRemainingColumn(),
        console=console,
    )
