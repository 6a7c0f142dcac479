"""A toolpath or an NC program from its file to the end of its motion, on any arm."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from typing import Protocol

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.backends import Station
from splinearm.config import Cell, Job
from splinearm.config.nc_program import NcProgram
from splinearm.control.cycle import Cycle
from splinearm.control.ending import Outcome
from splinearm.errors import ConfigError, UnreachableError
from splinearm.kinematics import space
from splinearm.runner import PlannedJob, RunResult, carry_out_job, limits_of, resume
from splinearm.toolpaths.action import Action
from splinearm.toolpaths.gcode_compensation import compensate
from splinearm.toolpaths.gcode_interpreter import run_gcode
from splinearm.toolpaths.gcode_machine import NcMachine, NcTool
from splinearm.toolpaths.place_search import find_place
from splinearm.toolpaths.placing import Placed, place
from splinearm.toolpaths.program import Part, plan_program, said
from splinearm.toolpaths.setting import Setting, tool_axis_of
from splinearm.units import MM

SUFFIXES = (".ngc", ".nc", ".gcode", ".tap", ".cnc")
"""What files of NC programs are called."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PlannedProgram:
    """A program whose motion is known."""

    placed: Placed
    """Where its tool goes, and how it stands."""
    parts: tuple[Part, ...]
    """What runs through without a person."""
    jobs: tuple[PlannedJob, ...]
    """The same as jobs to be carried out."""

    @property
    def duration(self) -> float:
        """How long its motions take together, s."""
        return sum(part.plan.trajectory.duration for part in self.parts)


class Person(Protocol):
    """Somebody at the machine."""

    def ask(self, words: str) -> bool:
        """Have something done, and say whether to go on."""
        ...

    def go_on(self, result: RunResult) -> bool:
        """Say whether a motion that was stopped shall go on from where it rests."""
        ...


def nc_job(
    program: NcProgram,
    cell: Cell,
    *,
    rate: float = 100.0,
    limits_share: float = 1.0,
    position_tolerance: float = 2e-5,
) -> Job:
    """Give the job of carrying out an NC program, as a job file would say it.

    Args:
        program: The program, and where its work lies.
        cell: The arm.
        rate: Setpoints a second, Hz.
        limits_share: Share of the arm's speed limits that it may use, above 0 and at most 1.
        position_tolerance: How far the tool may be off its way, m.
    """
    return Job(
        name=program.file.stem,
        title=program.file.name,
        file=program.file,
        arm=cell.file,
        q_start=cell.poses["home"],
        waypoints=(),
        closed=False,
        limits_share=limits_share,
        rate=rate,
        position_tolerance=position_tolerance,
        program=program,
    )


def read_actions(program: NcProgram) -> tuple[Action, ...]:
    """Give what an NC program lets its machine do, the tool's radius compensated.

    Raises:
        GcodeError: If it says what cannot be understood or done.
        GougeError: If a tool is too wide for its contour.
    """
    machine = NcMachine(
        tools={number: NcTool(diameter=tool.diameter) for number, tool in program.tools.items()},
        inches=program.inches,
    )
    return compensate(run_gcode(program.file, machine)).actions


def setting_of(program: NcProgram) -> Setting:
    """Give how the work of a toolpath lies."""
    return Setting(
        T_base_work=program.T_base_work,
        direction=program.direction,
        turn=program.turn,
        clearance=program.clearance,
    )


def with_tool(cell: Cell, setting: Setting, length: float) -> Cell:
    """Give a cell whose arm holds a tool that is longer along its pointing axis.

    Args:
        cell: The cell.
        setting: How the work lies, which says where the tool points.
        length: By how much its tip is beyond the tool frame of the arm's file, m.

    Raises:
        ValueError: If the length is not finite or below 0.
    """
    if not 0.0 <= length < inf:
        raise ValueError(f"length: want a length of at least 0, got {length}")
    along = space.translation(length * tool_axis_of(cell.arm, setting))
    return replace(cell, arm=replace(cell.arm, T_flange_tool=cell.arm.T_flange_tool @ along))


def plan_nc_job(
    job: Job,
    cell: Cell,
    *,
    find: bool = False,
    progress: Callable[[float], object] | None = None,
) -> PlannedProgram:
    """Plan the motion of a job that carries out an NC program.

    Args:
        job: The job, with a toolpath.
        cell: Its arm, without the tool that the toolpath adds.
        find: Whether to look for a place of the work where all of it can be reached.
        progress: Gets the share that is done, now and then.

    Raises:
        UnreachableError: If the arm cannot follow; its message begins with the program.
        ToolpathError: If the program cannot be understood, or no place is found for it.
        ConfigError: If program, work and arm do not go together.
        TrajectoryError: If the motion cannot be made.
        ValueError: If the job has no toolpath.
    """
    program = job.program
    if program is None:
        raise ValueError("job: want one with a toolpath, got one of waypoints")
    actions = read_actions(program)
    try:
        setting = setting_of(program)
        cell = with_tool(cell, setting, program.tool_length)
        if find:
            setting = find_place(actions, setting, cell.arm, job.q_start)
        placed = place(actions, setting, cell.arm, job.q_start)
        parts = plan_program(
            placed,
            limits_of(job, cell),
            position_tolerance=job.position_tolerance,
            progress=progress,
        )
    except UnreachableError as error:
        raise UnreachableError(
            error.position_error,
            error.orientation_error,
            error.joint,
            error.reason,
            what=f"{program.file}: {error.what}",
        ) from error
    except ValueError as error:
        # what job, program and arm say is right by itself, but does not go together
        raise ConfigError(job.file, "", str(error)) from error
    return PlannedProgram(placed=placed, parts=parts, jobs=tuple(_jobs(job, cell, parts)))


def _jobs(job: Job, cell: Cell, parts: tuple[Part, ...]) -> Iterator[PlannedJob]:
    """Give the parts of a program as jobs of their own."""
    for i, part in enumerate(parts):
        title = job.title if len(parts) == 1 else f"{job.title}, part {i + 1} of {len(parts)}"
        one = replace(job, title=title, q_start=part.plan.trajectory.q_start)
        yield PlannedJob(one, cell, part.plan)


def carry_out_program(
    planned: PlannedProgram,
    station: Station,
    person: Person | None = None,
    *,
    announce: Callable[[str], object] = print,
    observe: Callable[[int, Cycle], object] | None = None,
    files: Callable[[int, str], Path | None] | None = None,
) -> tuple[RunResult, ...]:
    """Carry out a program on an open arm, part by part; Ctrl-C slows it down, and it holds.

    Args:
        planned: The program.
        station: The arm, open.
        person: Who is there to be asked; None: nobody.
        announce: Gets a line for all that is switched, and whatever a person should know.
        observe: Gets the number of the part and each of its cycles, a little later.
        files: Says for a part and "csv" or "mcap" where its cycles are written.

    Returns:
        What came of each part that was begun; of the last one also a fault that stopped it.

    Raises:
        ConfigError: If a person is needed and nobody is there; nothing has moved then.
        SplinearmError: If the arm cannot move at all.
    """
    if person is None:
        require_nobody(planned)
    results = list[RunResult]()
    for i, (part, job) in enumerate(zip(planned.parts, planned.jobs, strict=True)):
        if part.asks and person is not None and not person.ask("; ".join(map(said, part.asks))):
            break
        caller = _Caller(i, part, announce, observe)
        caller.say(0.0)
        result = carry_out_job(
            job,
            station,
            csv=None if files is None else files(i, "csv"),
            mcap=None if files is None else files(i, "mcap"),
            observe=caller,
            announce=announce,
        )
        while result.ending.stopped is not None and person is not None and person.go_on(result):
            caller.done = result.ending.stopped.t
            result = resume(result, station, observe=caller, announce=announce)
        results.append(result)
        if result.outcome is not Outcome.FINISHED:
            break
        caller.say(inf)
    return tuple(results)


def require_nobody(planned: PlannedProgram) -> None:
    """Refuse a program that needs a person on its way.

    Raises:
        ConfigError: With the line.
    """
    waits = [action for part in planned.parts for action in part.asks]
    if waits:
        raise ConfigError(
            planned.jobs[0].job.file,
            "",
            f"{said(waits[0])} waits for a person, and nobody is there; run it at a terminal, or "
            "take that out of the program",
        )


class _Caller:
    """Says what is switched when its time comes."""

    def __init__(
        self,
        number: int,
        part: Part,
        announce: Callable[[str], object],
        observe: Callable[[int, Cycle], object] | None,
    ) -> None:
        self.done = 0.0
        """How much of the part had been done when it was taken up again, s."""
        self._number = number
        self._events = list(part.events)
        self._announce = announce
        self._observe = observe

    def __call__(self, cycle: Cycle) -> None:
        """Say what is due at a cycle."""
        self.say(self.done + cycle.setpoint.t)
        if self._observe is not None:
            self._observe(self._number, cycle)

    def say(self, t: float) -> None:
        """Say all that is due at a time of the part."""
        while self._events and self._events[0].t <= t:
            self._announce(self._events.pop(0).words)


def parse_place(text: str) -> FloatArray:
    """Give T_base_work of "x,y,z" or "x,y,z,rx,ry,rz", in mm and deg about fixed axes, (4, 4).

    Raises:
        ValueError: If it is something else.
    """
    try:
        values = np.array([float(word) for word in text.split(",")])
    except ValueError as error:
        raise ValueError(f"want x,y,z or x,y,z,rx,ry,rz in mm and deg, got {text!r}") from error
    if values.size not in (3, 6) or not np.isfinite(values).all():
        raise ValueError(f"want x,y,z or x,y,z,rx,ry,rz in mm and deg, got {text!r}")
    turn = np.radians(values[3:]) if values.size == 6 else np.zeros(3)
    T = space.rotation_z(turn[2]) @ space.rotation_y(turn[1]) @ space.rotation_x(turn[0])
    T[:3, 3] = values[:3] * MM
    return T
