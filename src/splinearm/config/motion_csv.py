"""Motions as tables: a row a moment, in degrees, millimetres and seconds."""

import csv
import io

import numpy as np

from splinearm.joints import JointLimits
from splinearm.trajectories.sampled import Rows, trajectory_of
from splinearm.trajectories.trajectory import JointTrajectory

from .unit import from_file_units, positions_key, to_file_units

_TIME = "t_s"
_RATES = ("", "_s", "_s2")


def to_text(limits: JointLimits, rows: Rows) -> str:
    """Give rows as CSV with a line of names; numbers as exact as they are."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    columns = [values for values in (rows.q, rows.qd, rows.qdd) if values is not None]
    writer.writerow([_TIME, *_names(limits, len(columns))])
    tables = [to_file_units(values, limits.kinds) for values in columns]
    for row in np.column_stack((rows.t, *tables)).tolist():
        writer.writerow([repr(value) for value in row])
    return out.getvalue()


def from_text(text: str, limits: JointLimits) -> JointTrajectory:
    """Give the motion through the rows of a table.

    Raises:
        ValueError: With the line that is not right.
    """
    lines = list(csv.reader(io.StringIO(text)))
    if not lines:
        raise ValueError("is empty")
    head = [name.strip() for name in lines[0]]
    known = {1 + count * limits.n: count for count in (1, 2, 3)}
    count = known.get(len(head), 0)
    wanted = [_TIME, *_names(limits, max(count, 1))]
    if head != wanted:
        raise ValueError(f"line 1: want columns {','.join(wanted)}, got {','.join(head)}")
    values = np.array([_numbers(line, i, len(head)) for i, line in enumerate(lines[1:], 2)])
    values = values.reshape(-1, len(head))
    parts = np.split(values[:, 1:], count, axis=1)
    return trajectory_of(
        limits, values[:, 0], *(from_file_units(part, limits.kinds) for part in parts)
    )


def _names(limits: JointLimits, count: int) -> list[str]:
    """Give the columns of positions, velocities and accelerations, as many of them as there are."""
    return [
        positions_key(name, (kind,)).replace("_deg_mm", "_mm") + suffix
        for suffix in _RATES[:count]
        for name, kind in zip(limits.names, limits.kinds, strict=True)
    ]


def _numbers(line: list[str], number: int, width: int) -> list[float]:
    if len(line) != width:
        raise ValueError(f"line {number}: want {width} numbers, got {len(line)}")
    try:
        return [float(value) for value in line]
    except ValueError as error:
        raise ValueError(f"line {number}: want numbers, got {','.join(line)}") from error
