"""What happened, cycle by cycle: in memory for the report, as CSV for everything else."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, Self

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import ConfigError
from splinearm.joints import JointKind, JointSetpoint, JointState
from splinearm.units import DEG, MM

_FLUSH_EVERY = 50


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Cycle:
    """One turn of the loop."""

    index: int
    """Number of the cycle, from 0; a skipped one leaves a gap."""
    t: float
    """When it was due, s since the loop began."""
    lateness: float
    """By how much it began late, s."""
    setpoint: JointSetpoint
    """What was written; its ``t`` is time along the motion."""
    state: JointState | None
    """What was measured before that; None if no full answer came."""
    busy: float
    """How long reading, checking and writing took, s."""


class Recorder:
    """Keeps every cycle, and writes it to a CSV file when given one.

    In the file angles are in degrees, lengths in millimetres, times in seconds or milliseconds, as
    each column's name says. A cell is empty where nothing was measured.
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
        self._file: IO[str] | None = None
        units = ["mm" if kind is JointKind.PRISMATIC else "deg" for kind in kinds]
        self._per_unit = np.array([MM if unit == "mm" else DEG for unit in units])
        if file is not None:
            self._open(file, names, units)

    def _open(self, file: Path, names: Sequence[str], units: Sequence[str]) -> None:
        try:
            self._file = file.open("x", newline="", encoding="utf-8")
        except FileExistsError as error:
            raise ConfigError(
                file, "", "is there already and is not overwritten; name another file"
            ) from error
        except OSError as error:
            raise ConfigError(file, "", f"cannot be written: {error.strerror}") from error
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
        self._csv = csv.writer(self._file)
        self._csv.writerow(columns)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._file is not None:
            self._file.close()
            if not self.cycles:
                Path(self._file.name).unlink()

    def __call__(self, cycle: Cycle) -> None:
        """Keep one cycle."""
        self.cycles.append(cycle)
        if self._file is None:
            return
        self._csv.writerow(self._row(cycle))
        if len(self.cycles) % _FLUSH_EVERY == 0:
            self._file.flush()

    def _row(self, cycle: Cycle) -> list[str]:
        row = [
            str(cycle.index),
            f"{cycle.t:.6f}",
            f"{cycle.setpoint.t:.6f}",
            f"{cycle.lateness * 1e3:.4f}",
            f"{cycle.busy * 1e3:.4f}",
        ]
        wanted, state = cycle.setpoint, cycle.state
        for values in (wanted.q, wanted.qd, wanted.qdd):
            row += [f"{value:.9g}" for value in values / self._per_unit]
        if state is None:
            return row + [""] * (3 * wanted.q.size)
        for values in (state.q, state.qd):
            row += [f"{value:.9g}" for value in values / self._per_unit]
        return row + ["" if np.isnan(value) else f"{value:.5g}" for value in state.current]

    def measured(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Give the cycles that measured: time (m,), wanted (m,n), measured (m,n), current (m,n)."""
        full = [(c, c.state) for c in self.cycles if c.state is not None]
        if not full:
            empty = np.empty((0, self._per_unit.size))
            return np.empty(0), empty, empty, empty
        return (
            np.array([cycle.t for cycle, _ in full]),
            np.array([cycle.setpoint.q for cycle, _ in full]),
            np.array([state.q for _, state in full]),
            np.array([state.current for _, state in full]),
        )
