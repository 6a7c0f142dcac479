"""Motions that were led by hand: a curve of the joints by the time it was led in, and its rests."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal

import numpy as np

from splinearm.arrays import FloatArray, frozen_array
from splinearm.curves.box import bounding_box
from splinearm.curves.bspline import BSpline
from splinearm.errors import LimitError
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics.arm import Arm

from .constraint import SpeedCap
from .joint_path import JointPath
from .law_choice import quickest_law
from .limit import MotionLimits
from .plan import Plan
from .section import Section
from .time_law import TimeLaw
from .tool_path import CarriedPath, ToolPath
from .trajectory import JointTrajectory

Timing = Literal["recorded", "fastest"]
"""How a taught motion is run through."""

TIMINGS: tuple[Timing, ...] = ("recorded", "fastest")
"""Recorded: as it was led, slower only where limits want it. Fastest: as quick as limits allow."""

_ROUNDING = 1e-9
"""So far beyond a limit rounding may carry a joint, rad or m."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class TaughtMotion:
    """Joints led by hand, as a B-spline by u, the time in which they moved."""

    names: tuple[str, ...]
    """The joints, base to tool."""
    degree: int
    """Degree."""
    knots: FloatArray
    """Knots, from 0 to how long the joints moved, shape (m + degree + 1,), s."""
    points: FloatArray
    """Control points, shape (m, n), rad or m."""
    rests: tuple[tuple[float, float], ...] = ()
    """Where the hand paused, and for how long, each in s: u rises, within the knots."""
    words: str = ""
    """How near to the recording it is, in words."""
    curve: BSpline = field(init=False, repr=False)
    """The way of the joints."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(self.names))
        points = frozen_array(self.points, (None, len(self.names)), "points")
        curve = BSpline(self.knots, points, self.degree)
        first, last = curve.domain
        if first != 0.0:
            raise ValueError(f"knots: want a curve that begins at 0, got one from {first}")
        rests = tuple((float(u), float(seconds)) for u, seconds in self.rests)
        places = [u for u, _ in rests]
        if any(not 0.0 <= u <= last for u in places) or any(b <= a for a, b in pairwise(places)):
            raise ValueError(f"rests: want them rising from 0 to {last} s, got {places}")
        if any(not 0.0 < seconds < np.inf for _, seconds in rests):
            raise ValueError(f"rests: want times above 0 s, got {[s for _, s in rests]}")
        object.__setattr__(self, "knots", curve.knots)
        object.__setattr__(self, "points", curve.points)
        object.__setattr__(self, "rests", rests)
        object.__setattr__(self, "curve", curve)

    @property
    def moving(self) -> float:
        """How long the joints moved, without the rests, s."""
        return float(self.curve.domain[1])

    @property
    def duration(self) -> float:
        """How long it was led, with the rests, s."""
        return self.moving + sum(seconds for _, seconds in self.rests)

    @property
    def q_start(self) -> FloatArray:
        """Where it starts, shape (n,), rad or m."""
        return self.curve.at(0.0)

    @property
    def q_goal(self) -> FloatArray:
        """Where it ends, shape (n,), rad or m."""
        return self.curve.at(self.moving)


def plan_taught(
    taught: TaughtMotion,
    arm: Arm,
    limits: JointLimits | MotionLimits | None = None,
    *,
    timing: Timing = "recorded",
) -> Plan:
    """Plan a taught motion: its way exactly, from rest to rest, with its rests.

    Args:
        taught: The motion.
        arm: The arm.
        limits: What joints, torques and tool may do; None: the arm's own limits of the joints.
        timing: "recorded": as it was led, slower only where limits want it; "fastest": as quick as
            they allow.

    Returns:
        The plan; its ``waypoint_times`` are when each rest begins.

    Raises:
        LimitError: If the way leaves the limits of position.
        TrajectoryError: If no law within the limits is found.
        ValueError: If it is of other joints, or the timing is not known.
    """
    every = MotionLimits.of(arm, limits)
    if taught.names != arm.joint_names:
        raise ValueError(f"taught: want joints {arm.joint_names}, got {taught.names}")
    if timing not in TIMINGS:
        raise ValueError(f"timing: want one of {', '.join(TIMINGS)}, got {timing!r}")
    check_within(taught.curve, every.joints)
    path, span = JointPath(taught.curve), taught.curve.domain
    sections: list[Section] = []
    if path.is_still:
        dwell = sum(seconds for _, seconds in taught.rests)
        sections += [_still(path, 0.0, dwell)] if dwell > 0.0 else []
        return _planned(sections, path, arm, every)
    cap = None
    if timing == "recorded":
        # ds/dt is never above 1: no quicker than it was led
        cap = SpeedCap(edges=np.array(span), speeds=np.ones(1), rate=np.ones_like)
    rests = dict(taught.rests)
    edges = np.unique([*span, *rests])
    if span[0] in rests:
        sections.append(_still(path, span[0], rests[span[0]]))
    for begin, end in pairwise(edges.tolist()):
        law = quickest_law(path, every, (begin, end), cap)
        sections.append(Section(path, law, rests.get(end, 0.0)))
    return _planned(sections, path, arm, every)


def check_within(curve: BSpline, limits: JointLimits) -> None:
    """Pass a way of the joints that keeps their limits of position everywhere.

    Raises:
        LimitError: With the joint that goes farthest beyond, and how far.
    """
    least, largest = bounding_box(curve)
    beyond = np.maximum(limits.q_min - least, largest - limits.q_max)
    j = int(np.argmax(beyond))
    if beyond[j] <= _ROUNDING:
        return
    above = largest[j] > limits.q_max[j] + _ROUNDING
    raise LimitError(
        limits.names[j],
        "position",
        float(largest[j] if above else least[j]),
        float(limits.q_max[j] if above else limits.q_min[j]),
        linear=limits.kinds[j] is JointKind.PRISMATIC,
    )


def _still(path: JointPath, s: float, dwell: float) -> Section:
    return Section(path, TimeLaw(np.array([s]), np.zeros(1)), dwell)


def _planned(sections: Iterable[Section], path: JointPath, arm: Arm, limits: MotionLimits) -> Plan:
    """Give the plan of sections of one path."""
    q = path.at(path.domain[0])[0]
    motion = JointTrajectory(tuple(sections), q, limits.joints)
    begun = [
        start + section.law.duration
        for start, section in zip(motion.starts, motion.sections, strict=True)
        if section.dwell > 0.0
    ]
    tool = ToolPath((CarriedPath(arm, path),), arm.fk(q)[:3, 3])
    return Plan(motion, tool, np.array(begun, dtype=np.float64), limits)
