"""A placed toolpath in time: parts that run through, and what is done between and during them."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import pi

from splinearm.joints import JointLimits
from splinearm.trajectories.guided import plan_guided
from splinearm.trajectories.limit import MotionLimits
from splinearm.trajectories.plan import Plan

from .action import Action, Dwell, Message, Pause, Spindle, ToolChange
from .placing import Placed
from .stage import rest_of

JERK_TIME = 0.05
"""Time in which accelerations grow to their limits where an arm says no jerk, s."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Event:
    """Something that is done besides moving, when the tool rests."""

    t: float
    """When, s from the part's start."""
    action: Action
    """What."""

    @property
    def words(self) -> str:
        """Say it."""
        return said(self.action)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Part:
    """What runs through without a person."""

    asks: tuple[Action, ...]
    """For what a person is needed before it: a pause, another tool."""
    plan: Plan
    """The motion."""
    events: tuple[Event, ...]
    """What is done besides, in order."""


def plan_program(
    placed: Placed,
    limits: JointLimits | MotionLimits | None = None,
    *,
    position_tolerance: float = 2e-5,
    progress: Callable[[float], object] | None = None,
) -> tuple[Part, ...]:
    """Plan a placed toolpath: as quick as limits allow, cuts at their feed where they allow it.

    The arm rests where the program says so, at corners that may not be rounded, and between rapid
    ways and cuts. A part ends where a person is needed.

    Args:
        placed: The toolpath.
        limits: What joints, torques and tool may do; None: the arm's limits. Where they say no jerk
            accelerations grow in 0.05 s.
        position_tolerance: How far the tool may be off its way, m.
        progress: Gets the share that is done, now and then.

    Raises:
        UnreachableError: If the arm cannot follow after all, with the line.
        TrajectoryError: If the motion cannot be made.
        ValueError: If limits are of other joints.
    """
    arm = placed.arm
    every = MotionLimits.of(arm, limits)
    if every.joints.qddd_max is None:
        every = replace(every, joints=every.joints.with_jerk_time(JERK_TIME))
    groups = _groups(placed)
    parts = list[Part]()
    whole, done = sum(len(way.near.s) for way in placed.ways), 0
    for asks, numbers in groups:
        ways = [placed.ways[i] for i in numbers]
        last = numbers[-1] == len(placed.ways) - 1
        share, begun = sum(len(way.near.s) for way in ways) / whole, done / whole

        def tell(part: float, share: float = share, begun: float = begun) -> None:
            if progress is not None:
                progress(begun + part * share)

        plan = plan_guided(
            arm,
            ways,
            every,
            position_tolerance=position_tolerance,
            rest=rest_of(placed.itinerary.after) if last else 0.0,
            progress=tell,
        )
        done += sum(len(way.near.s) for way in ways)
        parts.append(Part(asks=asks, plan=plan, events=_events(placed, numbers, plan, last=last)))
    return tuple(parts)


def said(action: Action) -> str:
    """Say what is done besides moving."""
    match action:
        case Spindle(speed=speed) if speed:
            turns = abs(speed) * 60.0 / (2.0 * pi)
            way = "clockwise" if speed > 0.0 else "counterclockwise"
            return f"line {action.line}: spindle {way} at {turns:.0f} rpm"
        case Spindle():
            return f"line {action.line}: spindle off"
        case ToolChange(tool=tool):
            return f"line {action.line}: tool {tool}" if tool else f"line {action.line}: no tool"
        case Message(text=text):
            return text
        case Dwell(time=time):
            return f"line {action.line}: rest of {time:g} s"
        case _:
            return f"line {action.line}: {getattr(action, 'code', type(action).__name__)}"


def _groups(placed: Placed) -> list[tuple[tuple[Action, ...], list[int]]]:
    """Give the stages that run through, and what a person is needed for before them."""
    groups = list[tuple[tuple[Action, ...], list[int]]]()
    for i, stage in enumerate(placed.itinerary.stages):
        # the first tool is the one that the arm holds
        asks = tuple(
            a for a in stage.before if isinstance(a, Pause) or (i and isinstance(a, ToolChange))
        )
        if i == 0 or asks:
            groups.append((asks, [i]))
        else:
            groups[-1][1].append(i)
    return groups


def _events(placed: Placed, numbers: list[int], plan: Plan, *, last: bool) -> tuple[Event, ...]:
    events = list[Event]()
    k = 0
    for i in numbers:
        stage = placed.itinerary.stages[i]
        t = float(plan.waypoint_times[k])
        rest = rest_of(stage.before)
        for action in stage.before:
            if not isinstance(action, Dwell):
                events.append(Event(t=max(t - rest, 0.0), action=action))
        for way, action in stage.within:
            events.append(Event(t=float(plan.waypoint_times[k + way]), action=action))
        k += len(placed.ways[i].way.places)
    if last:
        events += [
            Event(t=plan.trajectory.duration, action=a)
            for a in placed.itinerary.after
            if not isinstance(a, Dwell)
        ]
    return tuple(events)
