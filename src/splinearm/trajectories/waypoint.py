"""A place the tool or the joints shall pass, and how to get there."""

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

    JOINT = "joint"
    """The joints go straight from angle to angle; the tool goes where they carry it."""


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
