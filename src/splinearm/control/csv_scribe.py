"""The process that writes rows as CSV: ``python -m splinearm.control.csv_scribe deg,deg,mm``.

Rows come on standard input as ``row`` has them, lines leave on standard output.
"""

import math
import sys
from collections.abc import Sequence
from typing import IO

from .row import Row, read_rows

PER_UNIT = {"deg": math.pi / 180.0, "mm": 1e-3}
"""How much of SI a unit is."""


def line_of(row: Row, per_unit: Sequence[float]) -> str:
    """Give the line of a row; cells are empty where nothing was measured."""
    head = (
        str(row.cycle),
        f"{row.t:.6f}",
        f"{row.motion_t:.6f}",
        f"{row.lateness * 1e3:.4f}",
        f"{row.busy * 1e3:.4f}",
    )
    places = [
        _cell(joint[part] / per, "{:.9g}")
        for part in range(5)
        for joint, per in zip(row.joints, per_unit, strict=True)
    ]
    currents = [_cell(joint[5], "{:.5g}") for joint in row.joints]
    return ",".join((*head, *places, *currents)) + "\r\n"


def _cell(value: float, form: str) -> str:
    return "" if math.isnan(value) else form.format(value)


def write_lines(pipe: int, units: Sequence[str], out: IO[str]) -> None:
    """Write every row that comes through a pipe, until its other end is closed."""
    per_unit = [PER_UNIT[unit] for unit in units]
    for rows in read_rows(pipe, len(units)):
        out.writelines(line_of(row, per_unit) for row in rows)
        out.flush()


if __name__ == "__main__":
    with open(1, "w", newline="", encoding="utf-8") as stdout:
        write_lines(sys.stdin.fileno(), sys.argv[1].split(","), stdout)
