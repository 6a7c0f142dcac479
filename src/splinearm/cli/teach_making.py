"""What was led by hand, made into a job, and what is said of it."""

import argparse
import json
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from .output import console

if TYPE_CHECKING:
    from splinearm.config import Cell
    from splinearm.teaching.fitting import FitRule, Fitted
    from splinearm.teaching.job_file import Piece
    from splinearm.teaching.recording import Recording
    from splinearm.teaching.session import Grip


_MANY = 3000
"""So many samples take seconds."""


def say(line: str) -> None:
    """Print a line as it is; on a terminal that is gone nobody reads it."""
    with suppress(OSError):
        console.print(line, highlight=False, soft_wrap=True)


class Making:
    """Makes a job of what was led."""

    def __init__(self, args: argparse.Namespace, cell: "Cell", rule: "FitRule", file: Path) -> None:
        self._args, self._cell, self._file = args, cell, file
        # where jerk is limited the path's third derivative should not jump
        self._rule = replace(rule, smooth=cell.arm.limits.qddd_max is not None)
        self._said: list[dict[str, object]] = []
        self.exit_code = 0

    def take(self, led: "list[Recording | Grip] | list[Recording]") -> None:
        """Fit, write, tell.

        Raises:
            SplinearmError: If no piece can be made into a motion.
        """
        from splinearm.errors import ConfigError, SplinearmError, StillError
        from splinearm.teaching.fitting import fit_recording
        from splinearm.teaching.job_file import append_to_job, new_job

        pieces: list[Piece] = []
        refused: SplinearmError | None = None
        for number, one in enumerate(led, 1):
            if isinstance(one, str):
                pieces.append(one)
                self._tell(number, {"gripper": one}, f"gripper: {one}")
                continue
            self._promise(number, one)
            try:
                fitted = fit_recording(one, self._cell.arm, self._rule)
            except StillError as error:  # as between two marks of the gripper
                self._tell(number, {"left_out": str(error)}, f"{error}; it is left out")
                continue
            except SplinearmError as error:
                refused = refused or error
                self._refuse(number, one, error)
                continue
            pieces.append(fitted.motion)
            self._tell(number, document(fitted), *words(fitted, one))
            if self._args.tables:
                self._table(number, one)
        if all(isinstance(piece, str) for piece in pieces):
            if refused is not None:
                raise refused
            raise ConfigError(self._file, "", "is not written: nothing was led, nothing moves")
        if self._args.append is None:
            new_job(self._file, self._cell, pieces, self._args.name or self._file.stem)
        else:
            append_to_job(self._file, self._cell, pieces)
        if self._args.json:
            print(json.dumps({"job": str(self._file), "pieces": self._said}, indent=2))
        else:
            say(f"written: {self._file}; carry it out with: splinearm play {self._file}")

    def _promise(self, number: int, one: "Recording") -> None:
        """Say what takes a while."""
        if len(one.t) > _MANY and not self._args.json:
            say(f"piece {number}: a curve is made of {len(one.t)} samples, which takes a while ...")

    def _tell(self, number: int, said: dict[str, object], *lines: str) -> None:
        self._said.append({"piece": number, **said})
        if not self._args.json:
            for line in lines:
                say(f"piece {number}: {line}")

    def _refuse(self, number: int, one: "Recording", error: Exception) -> None:
        """Tell why a piece is none, and keep what was led."""
        self.exit_code = 1
        kept = "" if self._args.rows is not None else f"; kept as {self._table(number, one)}"
        self._tell(number, {"refused": str(error)}, f"{error}{kept}")

    def _table(self, number: int, one: "Recording") -> Path:
        from splinearm.config.folder import write_whole
        from splinearm.teaching.rows import rows_text

        stem, more = f"{self._file.stem}-piece-{number}", 1
        while (file := self._file.with_name(f"{stem}{f'-{more}' * (more > 1)}.csv")).exists():
            more += 1
        write_whole(file, rows_text(one, self._cell.arm.limits))
        return file


def document(fitted: "Fitted") -> dict[str, object]:
    """Give what was made as values that JSON knows."""
    return {
        "samples": fitted.samples,
        "control_points": fitted.points,
        "degree": fitted.motion.degree,
        "duration_s": fitted.motion.duration,
        "rests_s": [seconds for _, seconds in fitted.motion.rests],
        "tool_miss_mm": fitted.tool_miss * 1e3,
        "joint_miss_percent": fitted.joint_miss * 100.0,
        "wrong_samples_s": list(fitted.wrong),
        "scattered_samples": fitted.scattered,
        "notes": list(fitted.words),
    }


def words(fitted: "Fitted", recording: "Recording") -> list[str]:
    """Give what was made in lines for a person."""
    motion = fitted.motion
    rests = ", ".join(f"{seconds:.1f}" for _, seconds in motion.rests)
    lost = f"; readings lost and bridged: {recording.lost}" if recording.lost else ""
    return [
        f"{motion.duration:.1f} s, {fitted.samples} samples, {fitted.points} control points; the "
        f"tool is within {fitted.tool_miss * 1e3:.2f} mm"
        + (f"; rests of {rests} s" if rests else "")
        + lost,
        *fitted.words,
    ]
