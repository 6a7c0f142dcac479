"""A place the tool or the joints shall pass, and how to get there."""

import operator
from dataclasses import dataclass
from enum import Enum
from math import inf, isfinite

from splinearm.arrays import FloatArray, frozen_array
from splinearm.kinematics.pose import Pose


class Move(Enum):
    """How the arm gets to a waypoint."""

    BSPLINE = "bspline"
    """The tool follows one smooth curve (C2) through this and the neighbouring such waypoints."""

    LINE = "line"
    """The tool goes straight."""

    ARC = "arc"
    """The tool goes along a circular arc or a helix; ``Waypoint.arc`` says which."""

    JOINT = "joint"
    """The joints go straight from angle to angle; the tool goes where they carry it."""


class Facing(Enum):
    """How the tool stands on the way to a waypoint that gives a position only."""

    FREE = "free"
    """As suits the joints."""

    KEPT = "kept"
    """As it did before."""

    TANGENT = "tangent"
    """It turns with the direction of its way as a bead on a bent rod that does not spin about it
    (rotation-minimising). Where the tool stops at a corner it does not turn."""


@dataclass(frozen=True, slots=True, eq=False)
class ArcThrough:
    """The circular arc through a point on the way."""

    via: FloatArray
    """The point, shape (3,), m in base."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "via", frozen_array(self.via, (3,), "via"))


@dataclass(frozen=True, slots=True, eq=False)
class ArcAbout:
    """The arc about an axis, by the right hand; a helix if the end is farther along the axis.

    If the end is where the start is, or straight along the axis from there, it is a full turn.
    """

    centre: FloatArray
    """A point of the axis, shape (3,), m in base."""
    normal: FloatArray
    """Direction of the axis, shape (3,), in base, of any length above 0."""
    turns: int = 0
    """Full turns besides."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", frozen_array(self.centre, (3,), "centre"))
        object.__setattr__(self, "normal", frozen_array(self.normal, (3,), "normal"))
        if not self.normal.any():
            raise ValueError(f"normal: want a direction, got {self.normal.tolist()}")
        if operator.index(self.turns) < 0:
            raise ValueError(f"turns: want 0 or more, got {self.turns}; turn the normal about")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Waypoint:
    """A place to pass, said in exactly one way: a pose, a position or joint angles."""

    pose: Pose | None = None
    """Where the tool shall be and how it shall stand, T_base_tool."""
    position: FloatArray | None = None
    """Where the tool shall be, shape (3,), m in base; its orientation is free."""
    q: FloatArray | None = None
    """Joint positions, shape (n,), rad or m. In a Cartesian move: where they carry the tool."""
    move: Move = Move.BSPLINE
    """How to get here."""
    arc: ArcThrough | ArcAbout | None = None
    """Which arc leads here; given for that move and for no other."""
    facing: Facing = Facing.FREE
    """How the tool stands on the way here if only a position is given."""
    speed: float | None = None
    """Highest speed of the tool on the way here, m/s; None: as fast as the joints can."""
    blend: float = 0.0
    """How near to this corner the tool may begin to round it off, m; 0: it stops at the corner."""
    stop: bool = False
    """Whether the arm comes to rest here. At the last waypoint it does in any case."""
    dwell: float = 0.0
    """How long it rests here, s; above 0 it stops."""
    name: str = ""
    """What messages call it."""

    def __post_init__(self) -> None:
        self._check_place()
        if not isinstance(self.move, Move):
            choices = ", ".join(str(move) for move in Move)
            raise TypeError(f"move: want one of {choices}, got {self.move!r}")
        if (self.arc is not None) != (self.move is Move.ARC):
            given = "none" if self.arc is None else type(self.arc).__name__
            raise ValueError(f"arc: want one for {Move.ARC} only, got {given} for {self.move}")
        if self.facing is not Facing.FREE and (self.position is None or self.move is Move.JOINT):
            raise ValueError(
                f"facing: {self.facing} is for tool moves to a position; a pose or joints say "
                "how the tool stands"
            )
        if self.speed is not None and not 0.0 < self.speed < inf:
            raise ValueError(f"speed: want a number above 0 m/s, got {self.speed}")
        for name in ("blend", "dwell"):
            value = getattr(self, name)
            if not (isfinite(value) and value >= 0.0):
                raise ValueError(f"{name}: want a number of at least 0, got {value}")
        if self.blend > 0.0 and self.stops:
            raise ValueError(
                f"blend {self.blend} m: an arm that stops here cannot round the corner"
            )
        if self.blend > 0.0 and self.move is Move.BSPLINE:
            raise ValueError(
                f"blend {self.blend} m: a B-spline passes its waypoints without a corner; "
                "blend is for lines and joint moves"
            )

    def _check_place(self) -> None:
        given = [name for name in ("pose", "position", "q") if getattr(self, name) is not None]
        if len(given) != 1:
            got = " and ".join(given) or "none of them"
            raise ValueError(f"waypoint: want exactly one of pose, position and q, got {got}")
        if self.pose is not None and not isinstance(self.pose, Pose):
            raise TypeError(f"pose: want a Pose, got {type(self.pose).__name__}")
        if self.position is not None:
            object.__setattr__(self, "position", frozen_array(self.position, (3,), "position"))
        if self.q is not None:
            object.__setattr__(self, "q", frozen_array(self.q, (None,), "q"))

    @property
    def stops(self) -> bool:
        """Whether the arm comes to rest here because it is asked to."""
        return self.stop or self.dwell > 0.0
