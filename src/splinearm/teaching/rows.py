"""Recordings as tables: those that ``run --csv`` writes, and those of motions."""

import csv
import io
from os import PathLike
from pathlib import Path

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.config.unit import from_file_units, to_file_units
from splinearm.errors import ConfigError
from splinearm.joints import JointKind, JointLimits

from .recording import Recording

_TIME = "t_s"
_UNITS = {JointKind.REVOLUTE: "deg", JointKind.PRISMATIC: "mm"}


def read_rows(file: str | PathLike[str], limits: JointLimits) -> Recording:
    """Read a recording from a table with a line of names.

    Wanted are a column ``t_s`` and one a joint: ``JOINT_measured_deg`` as ``run --csv`` writes
    them, or ``JOINT_deg`` (``_mm`` of joints that slide). Rows in which a joint was not measured
    are left out and counted. Others are not looked at.

    Raises:
        ConfigError: With the line or the column that is not right.
    """
    path = Path(file)
    try:
        lines = list(csv.reader(io.StringIO(path.read_text(encoding="utf-8-sig"))))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ConfigError(path, "", f"cannot be read ({reason})") from error
    head = [name.strip() for name in lines[0]] if lines else []
    columns = [_column(path, head, (_TIME,))]
    for name, kind in zip(limits.names, limits.kinds, strict=True):
        unit = _UNITS[kind]
        columns.append(_column(path, head, (f"{name}_measured_{unit}", f"{name}_{unit}")))
    rows, lost = [], 0
    for number, line in enumerate(lines[1:], 2):
        if not line:  # an empty one, as editors leave it behind the last
            continue
        if len(line) != len(head):
            raise ConfigError(path, f"line {number}", f"want {len(head)} cells, got {len(line)}")
        cells = [line[i].strip() for i in columns]
        if "" in cells:
            lost += 1
            continue
        rows.append(_numbers(path, number, cells))
    table = np.array(rows, dtype=np.float64).reshape(-1, len(columns))
    falls = np.flatnonzero(np.diff(table[:, 0]) <= 0.0)
    if falls.size:
        raise ConfigError(path, _TIME, f"does not rise after {table[falls[0], 0]:g} s")
    return Recording(
        names=limits.names,
        t=table[:, 0],
        q=from_file_units(table[:, 1:], limits.kinds),
        lost=lost,
    )


def rows_text(recording: Recording, limits: JointLimits) -> str:
    """Give a recording as such a table."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    names = zip(limits.names, limits.kinds, strict=True)
    writer.writerow([_TIME, *(f"{name}_measured_{_UNITS[kind]}" for name, kind in names)])
    q: FloatArray = to_file_units(recording.q, limits.kinds)
    for t, row in zip(recording.t - recording.t[:1], q, strict=True):
        writer.writerow([f"{t:.6f}", *(f"{value:.9g}" for value in row)])
    return out.getvalue()


def _column(path: Path, head: list[str], names: tuple[str, ...]) -> int:
    for name in names:
        if head.count(name) == 1:
            return head.index(name)
    raise ConfigError(path, names[0], "is no column of the table, or is there twice")


def _numbers(path: Path, number: int, cells: list[str]) -> list[float]:
    try:
        values = [float(cell) for cell in cells]
    except ValueError:
        values = [np.nan]
    if not np.isfinite(values).all():
        raise ConfigError(path, f"line {number}", f"want finite numbers, got {', '.join(cells)}")
    return values
