"""What came of a sequence, step by step and in all."""

from dataclasses import dataclass, field
from math import nan
from typing import Any

from splinearm.control.ending import Ending, Outcome
from splinearm.drivers.gripper import GripState
from splinearm.runner import RunResult

from .step import Place, PlannedSequence, Step

SCHEMA = "splinearm-sequence/1"
"""What the document says it is."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class StepRun:
    """A step that was begun."""

    place: Place
    """Where in the sequence it is."""
    step: Step
    """What was wanted."""
    ending: Ending
    """How it ended."""
    seconds: float
    """How long it took, s."""
    motion: RunResult | None = None
    """What came of a motion; None of what the gripper did."""
    grip: GripState | None = None
    """How the gripper stood in the end; None without one."""

    def document(self) -> dict[str, Any]:
        """Give it as values that JSON knows."""
        values: dict[str, Any] = {
            "name": self.step.name,
            "kind": self.step.kind.value,
            "round": self.place.round + 1,
            "seconds": self.seconds,
            "outcome": self.ending.outcome.value,
        }
        if self.motion is not None:
            whole = self.motion.document()
            values |= {key: whole[key] for key in ("stopped_at_s", "loop", "tracking")}
        if self.grip is not None:
            values["gripper"] = {
                "open_percent": self.grip.percent,
                "force_percent": self.grip.effort * 100.0,
                "holding": self.grip.holding,
            }
        return values


@dataclass(slots=True, kw_only=True)
class Totals:
    """What all motions of a sequence make together, of all rounds."""

    motions: int = 0
    """How many were begun."""
    cycles: int = 0
    """Cycles that were carried out."""
    missed: int = 0
    """Cycles that were skipped because their time had passed."""
    unanswered: int = 0
    """Cycles in which not every joint answered."""
    latest: float = 0.0
    """By how much a cycle began late at worst, s."""

    def add(self, run: RunResult) -> None:
        """Add a motion."""
        self.motions += 1
        self.cycles += run.loop.cycles
        self.missed += run.loop.missed
        self.unanswered += run.loop.unanswered
        if run.loop.cycles:
            self.latest = max(self.latest, run.loop.lateness.worst)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class SequenceResult:
    """A sequence that was carried out, or stopped."""

    planned: PlannedSequence
    """What was wanted."""
    ending: Ending
    """Whether it ran to its end, and if not, why."""
    place: Place
    """Where it ended; after a stop this step is what goes on."""
    runs: tuple[StepRun, ...]
    """The steps of the last round that was begun, in their order."""
    totals: Totals
    """What all motions make together."""
    seconds: float = field(default=nan)
    """How long all of it took, s."""

    @property
    def outcome(self) -> Outcome:
        """Whether it ran to its end."""
        return self.ending.outcome

    @property
    def rounds(self) -> int:
        """How many rounds were carried out to their end."""
        return self.place.round + (self.outcome is Outcome.FINISHED)

    @property
    def step(self) -> Step:
        """The step at which it ended."""
        return self.planned.every_step[self.place.step]

    def document(self) -> dict[str, Any]:
        """Give it as values that JSON knows; keys wear their units."""
        ending, totals = self.ending, self.totals
        finished = ending.outcome is Outcome.FINISHED
        return {
            "schema": SCHEMA,
            "outcome": ending.outcome.value,
            "error_code": int(ending.reason),
            "error_name": ending.reason.name,
            "error_string": "" if ending.fault is None else str(ending.fault),
            "stopped_in": None if finished else self.step.name,
            "stopped_at_s": None if ending.stopped is None else ending.stopped.t,
            "rounds": self.rounds,
            "seconds": self.seconds,
            "motions": totals.motions,
            "loop": {
                "cycles": totals.cycles,
                "missed": totals.missed,
                "unanswered": totals.unanswered,
                "latest_us": totals.latest * 1e6,
            },
            "pieces": [run.document() for run in self.runs],
        }
