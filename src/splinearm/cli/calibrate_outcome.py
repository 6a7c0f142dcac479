"""What comes out of ``splinearm calibrate``: shown, written, kept."""

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from splinearm.commissioning.calibration_bench import CalibrationBench, as_calibration
from splinearm.commissioning.calibration_zero import check_zero
from splinearm.config import Cell
from splinearm.config.calibration import (
    DEFAULT,
    calibration_file,
    find_calibration,
    fitting,
    save_calibration,
)
from splinearm.config.calibration_table import Calibration, ServoCalibration, apply_calibration
from splinearm.config.folder import is_there
from splinearm.errors import ConfigError
from splinearm.units import DEG

from .setup_person import NARROW

if TYPE_CHECKING:
    from splinearm.commissioning.calibration_placement import Placement

_RIGHT = ("now", "lowest", "highest", "travel", "old", "new", "deg", "zero at")


class Shown:
    """What a person sees, who may have gone."""

    def __init__(self, console: Console) -> None:
        self.console = console
        """Where it is shown."""

    def say(self, words: str, style: str = "") -> None:
        """Show a line."""
        with suppress(OSError):  # of a terminal that is gone
            self.console.print(Text(words, style=style))

    def tell_file(self, words: str, file: Path) -> None:
        """Show where a file is, in one piece."""
        with suppress(OSError):
            self.console.print(f"{words}: {file}", soft_wrap=True, markup=False, highlight=False)


class Outcome:
    """A calibration that is about to be made; nothing is written before ``carry_out``."""

    def __init__(
        self,
        cell: Cell,
        bench: CalibrationBench,
        fresh: Calibration,
        shown: Shown,
        *,
        rehearsal: bool,
    ) -> None:
        """Take an arm whose joints were turned.

        Args:
            cell: The arm, as its file says.
            bench: Its servos.
            fresh: The calibration, still without servos.
            shown: Where to show things.
            rehearsal: Whether nothing is kept.
        """
        self._cell, self._bench, self._shown = cell, bench, shown
        self._rehearsal = rehearsal
        self._made = fresh if rehearsal else self._begun(fresh)
        self._steps: list[list[tuple[Placement, ServoCalibration]]] = []
        self._contradictions: dict[str, str] = {}

    def work_out(
        self,
        zeros: Mapping[str, float],
        signs: Mapping[str, int],
        zero_by: str,
        ends: tuple[float, float] | None,
    ) -> None:
        """Say what all servos are to be set to.

        Args:
            zeros: By joint its leader's count at joint zero, ticks.
            signs: By joint 1 if that count grows with it, else -1.
            zero_by: How zero was found.
            ends: The gripper's count open and closed, ticks; None: it is not calibrated.

        Raises:
            CalibrationError: If the arm cannot be used as it is mounted or was moved.
            ConfigError: If what comes out would not fit the arm's file.
        """
        for joint in self._bench.joints:
            placements = self._bench.place(joint, zeros[joint], signs[joint])
            self._steps.append([(p, as_calibration(p, zero_by)) for p in placements])
            leader = self._bench.leaders[joint].name
            turned = self._bench.turned(joint, signs[joint])
            self._contradictions[leader] = check_zero(turned, zeros[joint])
        if ends is not None:
            grip, opened, closed = self._bench.place_gripper(*ends)
            self._steps.append([(grip, as_calibration(grip, ends=(opened, closed)))])
        whole = self._made.with_servos(*(servo for step in self._steps for _, servo in step))
        apply_calibration(self._cell, whole, calibration_file(whole.arm, whole.name))

    def show(self) -> None:
        """Show what comes out, and every register that changes: what it holds, what it will."""
        console = self._shown.console
        if console.width < NARROW:  # no column of a table may be lost
            self._show_lines()
        else:
            console.print(self._table())
        for placement in self._placements:
            for note in (*placement.notes, self._contradictions.get(placement.spec.name, "")):
                if note:
                    self._shown.say(f"{placement.spec.name}: {note}", style="yellow")

    def carry_out(self) -> Calibration:
        """Keep the servos as they were, write, and keep the calibration joint by joint; give it.

        Raises:
            BusError: If a servo does not answer or refuses.
            CalibrationError: If a position is another than foreseen.
            ConfigError: If a file cannot be written.
        """
        if not self._rehearsal and any(map(self._bench.changes, self._placements)):
            self._shown.tell_file("The servos as they were", self._bench.line.back_up())
        kept: Calibration | None = None
        for step in self._steps:
            for placement, _ in step:
                self._bench.write(placement)
            self._made = self._made.with_servos(*(servo for _, servo in step))
            if not self._rehearsal:
                save_calibration(self._made, over=kept)
                kept = self._made
        return self._made

    def end(self, arm: str) -> None:
        """Say where the calibration is, and what comes next for whoever calls the arm so."""
        made = self._made
        if self._rehearsal:
            self._shown.say("A rehearsal: nothing was kept.")
            return
        self._shown.tell_file("Kept", calibration_file(made.arm, made.name))
        words = f"`splinearm calibrate {arm} --use {made.name}` takes it in use."
        if made.name == DEFAULT:
            doctor = f"splinearm doctor {self._bench.line.port} --arm {arm}"
            words = f"Next: `{doctor}`, then `splinearm jog {arm}`."
        self._shown.say(words)

    @property
    def _placements(self) -> "list[Placement]":
        return [placement for step in self._steps for placement, _ in step]

    def _begun(self, fresh: Calibration) -> Calibration:
        """Give the new calibration with what one of its name says of other servos."""
        if not is_there(calibration_file(fresh.arm, fresh.name)):
            return fresh
        try:
            former = find_calibration(fresh.arm, fresh.name)
        except ConfigError as error:
            self._shown.say(f"{error}; it is put aside")
            return fresh
        return fresh if former is None else fresh.with_servos(*fitting(self._cell, former).servos)

    def _table(self) -> Table:
        table = live_table("servo", "zero at", "travel", "register", "old", "new")
        for placement in self._placements:
            changes = self._bench.changes(placement)
            for k, change in enumerate(changes):
                told = _head(placement) if k == 0 else ("", "", "")
                table.add_row(*told, change.register.name, str(change.old), str(change.new))
            if not changes:
                table.add_row(*_head(placement), "nothing to write", "", "")
        return table

    def _show_lines(self) -> None:
        for placement in self._placements:
            name, zero, travel = _head(placement)
            self._shown.say(f"{name}: zero at {zero}, travel {travel}")
            changes = self._bench.changes(placement)
            for change in changes:
                self._shown.say(f"  {change.register.name}: {change.old} -> {change.new}")
            if not changes:
                self._shown.say("  nothing to write")


def live_table(*columns: str) -> Table:
    """Give a table without rows, numbers to the right."""
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    for name in columns:
        right = name in _RIGHT
        table.add_column(name, justify="right" if right else "left", overflow="fold")
    return table


def _head(placement: "Placement") -> tuple[str, str, str]:
    """Give a servo's name, where it is zero, and its travel."""
    low, high = (q / DEG for q in placement.travel)
    return placement.spec.name, str(placement.zero_ticks), f"{low:.1f} .. {high:.1f} deg"
