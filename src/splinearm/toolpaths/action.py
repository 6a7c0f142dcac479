"""What a machine does: moves of the tool's tip, and what is switched between them.

It is what an NC program means when it is read, and what a toolpath is before it is written. Lengths
in m, speeds in m/s, times in s; places in coordinates of the machine, or of the work where there is
no machine yet.
"""

from dataclasses import dataclass
from math import hypot

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Step:
    """What all that a machine does has in common."""

    line: int = 0
    """The line of the program, from 1; 0 if no program says it."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Moving(Step):
    """What ways of the tool have in common; they are straight if they are nothing else."""

    start: FloatArray
    """Where it begins, shape (3,), m."""
    end: FloatArray
    """Where it ends, shape (3,), m."""

    @property
    def length(self) -> float:
        """How long it is, m."""
        return float(np.linalg.norm(self.end - self.start))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Rapid(Moving):
    """A straight way as quick as the machine is."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Cutting(Moving):
    """What ways that cut have in common."""

    feed: float | None
    """How fast, m/s; None: ``time`` says how long it takes."""
    time: float | None = None
    """How long it takes, s, where the program says that (G93)."""
    blend: float | None = None
    """How far corners may be cut, m; None: not at all (G61); inf: as far as it likes (G64)."""
    side: int = 0
    """Whether the tool shall be left (1) or right (-1) of the way by ``radius``: G41 and G42."""
    radius: float = 0.0
    """Radius of the tool that is left or right of the way, m."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Feed(Cutting):
    """A straight way."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ArcFeed(Cutting):
    """An arc, or with a rise a helix, about an axis of the machine."""

    centre: FloatArray
    """A point of its axis, level with the start, shape (3,), m."""
    axis: int
    """The axis about which it turns: 2 for G17, 1 for G18, 0 for G19."""
    turn: float
    """How far it turns by the right hand about that axis, rad; below 0: clockwise."""

    @property
    def radius_at_start(self) -> float:
        """Distance of the start from the axis, m."""
        return float(np.linalg.norm(self._arm(self.start)))

    @property
    def length(self) -> float:
        """How long it is, m."""
        radius = 0.5 * (self.radius_at_start + float(np.linalg.norm(self._arm(self.end))))
        return hypot(radius * self.turn, float((self.end - self.start)[self.axis]))

    def at(self, x: FloatArray) -> FloatArray:
        """Give places at shares of the way from 0 to 1, shape (m, 3), m.

        Where start and end differ a little in their distance from the axis, the distance changes
        evenly with the angle, as on the machine.
        """
        a, b = (self.axis + 1) % 3, (self.axis + 2) % 3
        first, last = self._arm(self.start), self._arm(self.end)
        begin = np.arctan2(first[b], first[a])
        radius = (1.0 - x) * np.linalg.norm(first) + x * np.linalg.norm(last)
        angle = begin + self.turn * x
        places = np.empty((len(x), 3))
        places[:, a] = self.centre[a] + radius * np.cos(angle)
        places[:, b] = self.centre[b] + radius * np.sin(angle)
        places[:, self.axis] = (1.0 - x) * self.start[self.axis] + x * self.end[self.axis]
        return places

    def _arm(self, place: FloatArray) -> FloatArray:
        arm = place - self.centre
        arm[self.axis] = 0.0
        return arm


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class SplineFeed(Cutting):
    """A way along a B-spline."""

    curve: BSpline
    """The curve, in space, m."""

    @property
    def length(self) -> float:
        """How long it is, m."""
        return float(self.curve.length())


@dataclass(frozen=True, slots=True, kw_only=True)
class Dwell(Step):
    """A rest."""

    time: float
    """How long, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Spindle(Step):
    """The spindle is switched."""

    speed: float
    """How fast it turns, rad/s: above 0 clockwise seen from the machine, below 0 the other way."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ToolChange(Step):
    """Another tool is taken."""

    tool: int
    """Its number; 0: none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Switch(Step):
    """Something else is switched: coolant, overrides, outputs."""

    code: str
    """The code, as in "M8"."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Pause(Step):
    """The program waits for a person, or ends."""

    code: str
    """M0, M1, M60, M2 or M30."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Message(Step):
    """Something is said to the person at the machine."""

    text: str
    """What is said."""


Move = Rapid | Feed | ArcFeed | SplineFeed
"""What moves the tool."""

Action = (
    Rapid | Feed | ArcFeed | SplineFeed | Dwell | Spindle | ToolChange | Switch | Pause | Message
)
"""What a program lets the machine do."""
