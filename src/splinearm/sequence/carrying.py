"""A sequence carried out, step by step; after a stop it goes on with the rest of the step."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from splinearm.backends import Station
from splinearm.control.cycle import Cycle
from splinearm.control.ending import Ending, ExitReason, Outcome
from splinearm.control.forecast import StopForecast
from splinearm.control.record import Recorder
from splinearm.control.report import report_loop, report_tracking
from splinearm.control.servo_count import ServoCounter
from splinearm.runner import PlannedJob, RunResult, forecast_of, not_begun
from splinearm.stage import Audience, Stage, on_stage

from .hand import Hand
from .planning import steps_of
from .result import SequenceResult, StepRun, Totals
from .step import Place, PlannedSequence, Step, StepKind

Observer = Callable[[Step, Cycle], object]
"""Gets each step and its cycles, these in the time of the whole sequence."""


def carry_out_sequence(
    planned: PlannedSequence,
    station: Station,
    *,
    csv: Path | None = None,
    mcap: Path | None = None,
    observe: Observer | None = None,
    announce: Callable[[str], object] | None = None,
) -> SequenceResult:
    """Carry out a sequence on an open arm; Ctrl-C slows it down along its path and holds.

    All motions are checked before anything moves. A fault that stopped it is in the result.

    Args:
        planned: The sequence.
        station: The arm, open. Without a gripper the others' waits are kept.
        csv: Where every cycle of all motions is written; must not be there yet.
        mcap: Where it is written for Foxglove and PlotJuggler, likewise.
        observe: Gets every step and cycle, a little later, in a thread beside the loop.
        announce: Gets one line whenever a person should know, in that thread.

    Raises:
        SplinearmError: If the arm or its gripper cannot move at all; nothing has moved then.
    """
    return _carry_out(planned, station, _audience(csv, mcap, announce), observe, Place())


def resume_sequence(
    result: SequenceResult,
    station: Station,
    *,
    csv: Path | None = None,
    mcap: Path | None = None,
    observe: Observer | None = None,
    announce: Callable[[str], object] | None = None,
) -> SequenceResult:
    """Carry out what remains of a sequence that was stopped: the rest of its step, and the others.

    What the gripper was doing is done again. What stopped it must be over: see
    ``ServoArm.recover``, ``ServoArm.reconnect`` and ``Gripper.recover``.

    Args:
        result: What the stopped run gave.
        station: The arm.
        csv: As for ``carry_out_sequence``; a file of its own. So are the others.
        mcap: As for ``carry_out_sequence``.
        observe: As for ``carry_out_sequence``.
        announce: As for ``carry_out_sequence``.

    Raises:
        ValueError: If it was finished.
        SplinearmError: As for ``carry_out_sequence``.
    """
    if result.outcome is Outcome.FINISHED:
        raise ValueError("result: that sequence was finished, nothing of it remains")
    step = result.step
    if step.planned is not None and result.ending.stopped is not None:
        rest = result.ending.stopped.remaining()
        plan = replace(step.planned.plan, trajectory=rest)
        step = replace(step, planned=replace(step.planned, plan=plan))
    audience = _audience(csv, mcap, announce)
    return _carry_out(result.planned, station, audience, observe, result.place, step)


def _audience(
    csv: Path | None, mcap: Path | None, announce: Callable[[str], object] | None
) -> Audience:
    audience = Audience(csv=csv, mcap=mcap)
    return audience if announce is None else replace(audience, announce=announce)


def _carry_out(
    planned: PlannedSequence,
    station: Station,
    audience: Audience,
    observe: Observer | None,
    begin: Place,
    first: Step | None = None,
) -> SequenceResult:
    """Carry out a sequence from a place on, whose step is ``first`` if something of it is done."""
    forecasts = {id(t): forecast_of(s.planned) for s, t in steps_of(planned) if s.planned}
    with on_stage(planned.job, planned.cell, station, audience) as stage:
        show = _Show(
            stage=stage,
            planned=planned,
            hand=Hand(stage, station.gripper),
            forecasts=forecasts,
            observe=None if observe is None else stage.later(lambda told: observe(*told)),
            writes=audience.csv is not None,
        )
        show.prepare()
        ending, place = show.go(begin, first)
    return SequenceResult(
        planned=planned,
        ending=ending,
        place=place,
        runs=tuple(show.runs),
        totals=show.totals,
        seconds=station.clock.now() - show.begun,
    )


@dataclass(slots=True, eq=False, kw_only=True)
class _Show:
    """A sequence under way."""

    stage: Stage
    planned: PlannedSequence
    hand: Hand
    forecasts: dict[int, StopForecast]
    """What stops take, by the ``id`` of the motion."""
    observe: Callable[[tuple[Step, Cycle]], object] | None
    writes: bool
    """Whether cycles are written to a file."""
    runs: list[StepRun] = field(default_factory=list)
    totals: Totals = field(default_factory=Totals)
    begun: float = 0.0
    """When the first step began, s on the arm's clock."""
    written: int = 0
    """Cycles that the motions before took, skipped ones too."""

    def prepare(self) -> None:
        """Check everything before anything moves, and say what a stop takes."""
        stage = self.stage
        for _, trajectory in steps_of(self.planned):
            stage.loop.guard.admit(trajectory, stage.period)
        actions = [step.grip for step in self.planned.steps if step.grip is not None]
        self.hand.prepare(self.planned.job, actions)
        if self.forecasts:
            stage.say(max(self.forecasts.values(), key=lambda forecast: forecast.time).words)
        self.begun = stage.station.clock.now()

    def go(self, begin: Place, first: Step | None) -> tuple[Ending, Place]:
        """Do step after step; give how it ended, and where."""
        place = begin
        todo = [first or self.planned.every_step[begin.step]]
        todo += self.planned.every_step[begin.step + 1 :]
        ending = self._approach_first(todo)
        if ending.outcome is not Outcome.FINISHED:
            return ending, begin
        self.hand.must_hold = self._must_hold(begin)
        self.begun = self.stage.station.clock.now()
        for place, step in self.planned.walk(begin):
            if self.runs and self.runs[-1].place.round != place.round:
                self.runs.clear()  # a sequence without end shall not fill the memory
            wanted = first if first is not None and place == begin else step
            ending = self._do(place, wanted)
            if ending.outcome is not Outcome.FINISHED:
                break
        return ending, place

    def _approach_first(self, todo: Sequence[Step]) -> Ending:
        """Bring the arm to its begin before the gripper does anything there."""
        motions = [step.planned.plan for step in todo if step.planned is not None]
        if not motions:
            return Ending(outcome=Outcome.FINISHED, reason=ExitReason.SUCCESSFUL)
        ending = self.stage.approach(motions[0].trajectory.q_start)
        if ending.outcome is Outcome.FINISHED:
            return ending
        if todo[0].planned is not None:
            return not_begun(ending, motions[0])
        return replace(ending, stopped=None)

    def _must_hold(self, begin: Place) -> bool:
        """Tell whether the gripper shall hold something by what it did last before a place."""
        before = self.planned.steps[: begin.step]
        if begin.round > 0:
            before = (*self.planned.steps, *before)
        done = [step.grip for step in before if step.grip is not None]
        return bool(done) and done[-1].must_hold

    def _do(self, place: Place, step: Step) -> Ending:
        clock = self.stage.station.clock
        begun = clock.now()
        if self.stage.stop.requested:
            ending = Ending(outcome=Outcome.STOPPED, reason=ExitReason.GOAL_TOLERANCE_VIOLATED)
            return ending if step.planned is None else not_begun(ending, step.planned.plan)
        if step.grip is not None:
            words = step.grip.words
            self.stage.say(step.name if words in step.name else f"{step.name}, {words}")
            ending, state = self.hand.act(step.grip)
            run = StepRun(
                place=place, step=step, ending=ending, seconds=clock.now() - begun, grip=state
            )
        else:
            motion = self._move(step, _planned(step))
            ending, seconds = motion.ending, clock.now() - begun
            run = StepRun(place=place, step=step, ending=ending, seconds=seconds, motion=motion)
            self.totals.add(motion)
        self.runs.append(run)
        return ending

    def _move(self, step: Step, planned: PlannedJob) -> RunResult:
        """Carry out a motion."""
        stage, trajectory = self.stage, planned.plan.trajectory
        self._tell(step, trajectory.duration)
        limits = stage.cell.arm.limits
        recorder = Recorder(limits.names, limits.kinds)
        counter = ServoCounter(stage.station.driver, stage.cell.chain)
        ending = stage.approach(trajectory.q_start)
        if ending.outcome is Outcome.FINISHED:
            loop = stage.watched(recorder, self._keeper(step), self.hand.watch)
            ending = self.hand.judged(loop.carry_out(trajectory, stage.stop), trajectory)
        else:
            ending = not_begun(ending, planned.plan)
        known = self.forecasts.get(id(trajectory))
        return RunResult(
            ending=ending,
            planned=planned,
            recorder=recorder,
            tracking=report_tracking(stage.cell.arm, planned.plan, recorder),
            loop=report_loop(recorder.cycles, stage.period, counter.counts()),
            forecast=forecast_of(planned) if known is None else known,
            footing=stage.footing,
        )

    def _tell(self, step: Step, duration: float) -> None:
        slowly = "slowly " if step.kind is StepKind.TRANSITION else ""
        self.stage.say(f"{slowly}{step.name}: {duration:.2f} s")

    def _keeper(self, step: Step) -> Callable[[Cycle], None]:
        """Give what keeps the cycles of a step in the time of the whole sequence."""
        stage = self.stage
        since = max(stage.station.clock.now() - self.begun, self.written * stage.period)
        ahead = round(since / stage.period)
        tell, kept = self.observe, stage.rows.cycles

        def keep(cycle: Cycle) -> None:
            later = replace(cycle, index=cycle.index + ahead, t=cycle.t + since)
            self.written = later.index + 1
            if self.writes:
                stage.rows(later)
                del kept[:-1]
            for watcher in stage.watchers:
                watcher(later)
            if tell is not None:
                tell((step, later))

        return keep


def _planned(step: Step) -> PlannedJob:
    if step.planned is None:
        raise ValueError("step: want a motion or something for the gripper, got neither")
    return step.planned
