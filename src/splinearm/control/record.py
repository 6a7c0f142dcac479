"""What happened, cycle by cycle: in memory for the report, as CSV for everything else."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import IO, Self

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import ConfigError
from splinearm.joints import JointKind

from .cycle import Cycle as Cycle
from .row_pipe import RowPipe


class Recorder:
    """Keeps every cycle, and writes it to a CSV file when given one; use it in a with-block.

    In the file angles are in degrees, lengths in millimetres, times in seconds or milliseconds, as
    each column's name says. A cell is empty where nothing was measured. A process of its own writes
    it: the loop never waits for the disk, and rows of a program that is killed are not lost.
    """

    def __init__(
        self, names: Sequence[str], kinds: Sequence[JointKind], file: Path | None = None
    ) -> None:
        """Take the joints and the file.

        Args:
            names: Names of the joints.
            kinds: How each moves, for the columns' units.
            file: Where to write; it must not be there yet, and without a cycle it will not be.

        Raises:
            ConfigError: If the file is there already or cannot be written.
        """
        self.cycles: list[Cycle] = []
        self._n = len(names)
        self._path = file
        self._pipe: RowPipe | None = None
        if file is not None:
            units = ["mm" if kind is JointKind.PRISMATIC else "deg" for kind in kinds]
            with _open(file) as stream:
                stream.write(_headings(names, units).encode())
                stream.flush()
                self._pipe = RowPipe("csv_scribe", (",".join(units),), len(names), stream)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._pipe is None or self._path is None:
            return
        self._pipe.close()
        if not self.cycles:
            self._path.unlink()

    def __call__(self, cycle: Cycle) -> None:
        """Keep one cycle."""
        self.cycles.append(cycle)
        if self._pipe is not None:
            self._pipe.send(cycle)

    def measured(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Give the cycles that measured: time (m,), wanted (m,n), measured (m,n), current (m,n)."""
        full = [(c, c.state) for c in self.cycles if c.state is not None]
        if not full:
            empty = np.empty((0, self._n))
            return np.empty(0), empty, empty, empty
        return (
            np.array([cycle.t for cycle, _ in full]),
            np.array([cycle.setpoint.q for cycle, _ in full]),
            np.array([state.q for _, state in full]),
            np.array([state.current for _, state in full]),
        )


def _open(file: Path) -> IO[bytes]:
    try:
        return file.open("xb")
    except FileExistsError as error:
        raise ConfigError(
            file, "", "is there already and is not overwritten; name another file"
        ) from error
    except OSError as error:
        raise ConfigError(file, "", f"cannot be written: {error.strerror}") from error


def _headings(names: Sequence[str], units: Sequence[str]) -> str:
    """Give the first line: what stands in each column, and in which unit."""
    columns = ["cycle", "t_s", "motion_t_s", "lateness_ms", "busy_ms"]
    for what, suffix in (
        ("wanted", ""),
        ("wanted_rate", "_s"),
        ("wanted_accel", "_s2"),
        ("measured", ""),
        ("measured_rate", "_s"),
    ):
        columns += [f"{n}_{what}_{u}{suffix}" for n, u in zip(names, units, strict=True)]
    columns += [f"{name}_current_a" for name in names]
    line = io.StringIO()
    csv.writer(line).writerow(columns)
    return line.getvalue()
