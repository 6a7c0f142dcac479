"""Stretches of a plan: a joint move and the moves of the tool that its end has to carry.

An arm that stands in one configuration follows a way of the tool, or it does not; it never jumps
to another on the way. So the configuration in which a joint move ends is chosen with the moves of
the tool behind it in view: the nearest one if it can follow them, otherwise the one that follows
them with the least way of the joints.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import UnreachableError
from splinearm.kinematics.arm import Arm

from . import branch_choice, place
from .leg import Leg, ToolWay, course_ways, joint_legs, spline_way
from .place import Place, Run, Start
from .resolve import Tolerance
from .waypoint import Move, Waypoint


class RunLegs(NamedTuple):
    """A run of equal moves as the arm carries it out."""

    places: list[Place]
    """Where it goes through, its start first."""
    legs: list[Leg]
    """Its ways from rest to rest; none if it stays where it is."""


def run_legs(
    arm: Arm, waypoints: Sequence[Waypoint], start: Start, tolerance: Tolerance
) -> list[RunLegs]:
    """Give all runs of equal moves through waypoints, one after the other.

    Args:
        arm: The arm.
        waypoints: Where it shall go.
        start: Where it stands.
        tolerance: How far the tool may be off.

    Raises:
        UnreachableError: If the arm cannot get to a waypoint, or follow the way to it from any
            configuration that it may take; it says whether it could from another one.
        CurveError: If the waypoints make no such way.
        ValueError: If a run of tool moves mixes poses and positions.
    """
    made: list[RunLegs] = []
    for runs in _stretches(place.runs_of(waypoints)):
        made += _Stretch(arm, waypoints, runs, start, tolerance).legs()
        start = _end_of(made[-1], start)
    return made


def follow(
    arm: Arm, ways: Sequence[ToolWay], q_start: FloatArray, tolerance: Tolerance
) -> list[Leg]:
    """Give the legs of ways of the tool, each of which starts where the one before it ends.

    Args:
        arm: The arm.
        ways: The ways.
        q_start: Joint positions at the start of the first, shape (n,).
        tolerance: How far the tool may be off.

    Raises:
        UnreachableError: If the arm cannot follow; it says whether it could from another
            configuration.
    """
    try:
        return _carried(arm, ways, q_start, tolerance)
    except UnreachableError as error:
        raise _refusal(arm, ways, q_start, tolerance, error) from error


def _stretches(runs: Sequence[Run]) -> Iterator[list[Run]]:
    """Give the runs that belong together: from one joint move to the next."""
    together: list[Run] = []
    for run in runs:
        if run.move is Move.JOINT and together:
            yield together
            together = []
        together.append(run)
    yield together


def _end_of(made: RunLegs, start: Start) -> Start:
    return Start(made.legs[-1].q_goal if made.legs else start.q, made.places[-1].name)


def _carried(
    arm: Arm, ways: Sequence[ToolWay], q_start: FloatArray, tolerance: Tolerance
) -> list[Leg]:
    legs: list[Leg] = []
    for way in ways:
        legs.append(way.leg(arm, legs[-1].q_goal if legs else q_start, tolerance))
    return legs


def _refusal(
    arm: Arm,
    ways: Sequence[ToolWay],
    q_start: FloatArray,
    tolerance: Tolerance,
    error: UnreachableError,
) -> UnreachableError:
    """Give the error of ways that cannot be followed, with what another start would do."""
    choice = branch_choice.choose(arm, [way.path for way in ways], q_start)
    if choice.q is not None:
        try:
            _carried(arm, ways, choice.q, tolerance)
        except UnreachableError:
            choice = branch_choice.NONE
    return branch_choice.explained(arm, error, choice)


class _Stretch:
    """A joint move, or none, and the moves of the tool behind it."""

    def __init__(
        self,
        arm: Arm,
        waypoints: Sequence[Waypoint],
        runs: Sequence[Run],
        start: Start,
        tolerance: Tolerance,
    ) -> None:
        self.arm = arm
        self.waypoints = waypoints
        self.start = start
        self.tolerance = tolerance
        self.joint = runs[0] if runs[0].move is Move.JOINT else None
        self.tools = runs if self.joint is None else runs[1:]
        self.ways: list[ToolWay] = []
        """The ways of the tool, up to the one that could not be followed."""

    def legs(self) -> list[RunLegs]:
        """Give the runs, in the configuration that can follow them."""
        try:
            return self._tried(None)
        except UnreachableError as error:
            if not self.ways:
                raise
            if not self._may_choose():
                q_begin = self._q_begin()
                raise _refusal(self.arm, self.ways, q_begin, self.tolerance, error) from error
            choice = branch_choice.choose(
                self.arm, [way.path for way in self.ways], self._q_before_goal()
            )
            if choice.q is None:
                raise branch_choice.explained(self.arm, error, choice) from error
            try:
                return self._tried(choice.q)
            except UnreachableError:
                raise branch_choice.explained(self.arm, error, branch_choice.NONE) from error

    def _tried(self, q_goal: FloatArray | None) -> list[RunLegs]:
        """Give the runs if the joint move ends at some joint positions, by default the nearest."""
        here = self.start
        made: list[RunLegs] = []
        self.ways = []
        if self.joint is not None:
            places = self._joint_places(q_goal)
            legs = joint_legs(self.arm, places) if len(places) > 1 else []
            made.append(RunLegs(places, legs))
            here = _end_of(made[-1], here)
        for run in self.tools:
            places = place.tool_run(self.arm, self.waypoints, run.numbers, here)
            legs = self._tool_legs(run, places, here.q) if len(places) > 1 else []
            made.append(RunLegs(places, legs))
            here = _end_of(made[-1], here)
        return made

    def _joint_places(self, q_goal: FloatArray | None) -> list[Place]:
        numbers = [] if self.joint is None else self.joint.numbers
        return place.joint_run(self.arm, self.waypoints, numbers, self.start, q_goal)

    def _tool_legs(self, run: Run, places: list[Place], q: FloatArray) -> list[Leg]:
        if run.move is Move.LINE:
            ways = course_ways(self.arm, places, q, tangent=run.tangent)
        else:
            ways = [spline_way(self.arm, places, q, tangent=run.tangent)]
        self.ways += ways
        return _carried(self.arm, ways, q, self.tolerance)

    def _may_choose(self) -> bool:
        """Tell whether the joint move leads to a place of the tool and not to joint positions."""
        return self.joint is not None and self.waypoints[self.joint.numbers[-1]].q is None

    def _q_begin(self) -> FloatArray:
        """Give where the joints are where the ways of the tool begin."""
        q = self._joint_places(None)[-1].q
        return self.start.q if q is None else q

    def _q_before_goal(self) -> FloatArray:
        """Give from where the joints move to where the ways of the tool begin."""
        numbers = [] if self.joint is None else self.joint.numbers[:-1]
        q = place.joint_run(self.arm, self.waypoints, numbers, self.start)[-1].q
        return np.asarray(self.start.q if q is None else q)
