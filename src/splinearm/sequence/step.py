"""What a sequence is made of: motions, the ways between them, and what the gripper does."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from itertools import count
from typing import NamedTuple

from splinearm.config import Cell, Job
from splinearm.config.piece import GripAction
from splinearm.runner import PlannedJob


class StepKind(Enum):
    """What happens in a step."""

    MOTION = "motion"
    """The arm moves as a piece says."""

    TRANSITION = "transition"
    """The arm goes slowly to where the next piece begins."""

    GRIPPER = "gripper"
    """The gripper moves; the arm holds."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Step:
    """One step of a sequence: a motion, or something that the gripper does."""

    name: str
    """What people call it."""
    kind: StepKind
    """What happens."""
    planned: PlannedJob | None = None
    """The motion; None for what the gripper does."""
    grip: GripAction | None = None
    """What the gripper does; None for a motion."""

    @property
    def duration(self) -> float:
        """How long it takes, s; of the gripper only what is waited besides."""
        if self.planned is not None:
            return self.planned.plan.trajectory.duration
        return 0.0 if self.grip is None else self.grip.wait


class Place(NamedTuple):
    """Where in a sequence something happens."""

    round: int = 0
    """Number of the round, from 0."""
    step: int = 0
    """Number of the step in it, from 0; the way back to the first comes after the last."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PlannedSequence:
    """A job whose steps are all known."""

    job: Job
    """What the file says."""
    cell: Cell
    """The arm of the job."""
    steps: tuple[Step, ...]
    """The steps of a round, in their order."""
    back: Step | None
    """The way from the end of a round to the begin of the next; None if they are the same."""

    @property
    def duration(self) -> float:
        """How long a round takes, without what the gripper takes, s."""
        return sum(step.duration for step in self.steps)

    @property
    def every_step(self) -> tuple[Step, ...]:
        """The steps, and the way back."""
        return self.steps if self.back is None else (*self.steps, self.back)

    def walk(self, begin: Place) -> Iterator[tuple[Place, Step]]:
        """Give the steps that are to be done, from a place on; without end if the job has none."""
        times = self.job.times
        for number in count(begin.round):
            last = times is not None and number + 1 >= times
            steps = self.steps if last else self.every_step
            first = begin.step if number == begin.round else 0
            for i in range(first, len(steps)):
                yield Place(number, i), steps[i]
            if last:
                return

    @property
    def uses_gripper(self) -> bool:
        """Whether the gripper does something."""
        return any(step.grip is not None for step in self.steps)
