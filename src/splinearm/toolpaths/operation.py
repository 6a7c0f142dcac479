"""What all operations of a cutter have in common: how deep, how it enters, and what they give."""

from dataclasses import dataclass, field
from enum import StrEnum
from math import ceil, isfinite, pi
from typing import Protocol

from splinearm.arrays import FloatArray

from .action import Action
from .contour import Contour
from .cutter import Cutter
from .spline_leg import Leg

_WHOLE = 1e-9
_FLATTEST = 0.01 * pi / 180.0
"""Flatter ramps would be longer than any part is wide."""
_MOST_PASSES = 1000
"""What takes more is a slip of the pen."""


class Entry(StrEnum):
    """How the cutter comes down into the material."""

    PLUNGE = "plunge"
    """Straight down."""
    RAMP = "ramp"
    """Down along what it then cuts."""
    HELIX = "helix"
    """Down a helix that ends where it begins to cut; where none has room, a ramp."""


class Side(StrEnum):
    """On which side of a contour the cutter goes."""

    OUTSIDE = "outside"
    """Around what is kept: outside of outlines, inside of their openings."""
    INSIDE = "inside"
    """Within what is opened: inside of outlines, around their islands."""
    ON = "on"
    """Its middle on the line."""


class Barrier(Protocol):
    """What the middle of a cutter keeps away from."""

    def is_clear(self, start: FloatArray, end: FloatArray, bulge: float = 0.0) -> bool:
        """Say whether a line or an arc keeps its distance."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Milling:
    """A cutter and how it is used."""

    cutter: Cutter
    """The cutter."""
    depth: float
    """How deep it goes in the end, below ``top``, m."""
    top: float = 0.0
    """Where the material begins, m above the top of the stock: below 0 in a pocket."""
    step_down: float | None = None
    """How deep a pass may be, m; None: what the cutter may."""
    step_over: float | None = None
    """How far passes beside each other are apart, m; None: what the cutter may."""
    climb: bool = True
    """Whether the edge comes out of the material where the chip is thin; else conventional."""
    safe: float = 5e-3
    """Where rapid ways go, m above the top of the stock."""
    gap: float = 0.5e-3
    """How far above the material rapid ways down end, m."""
    entry: Entry = Entry.PLUNGE
    """How it comes down."""
    ramp_angle: float = 3.0 * pi / 180.0
    """How steep ramps and helices are, rad."""
    lead: float = 0.0
    """Radius of the arcs by which a contour is entered and left, m; 0: none."""
    blend: float | None = None
    """How far a controller may cut corners to keep its pace, m; None: not at all."""
    stock: float = 0.0
    """What is left on the sides, m."""
    slack: float = 0.0
    """How much farther ways keep off sides, m: by what contours may differ from the drawing."""
    finish: bool = False
    """Whether what was left on the sides is taken off in a last pass, at full depth."""

    def __post_init__(self) -> None:
        for name in ("depth", "safe", "gap", "ramp_angle"):
            _require(name, getattr(self, name), above=True)
        for name in ("lead", "stock", "slack"):
            _require(name, getattr(self, name), above=False)
        for name in ("step_down", "step_over", "blend"):
            if getattr(self, name) is not None:
                _require(name, getattr(self, name), above=True)
        if not _FLATTEST <= self.ramp_angle < 0.5 * pi:
            raise ValueError(
                f"ramp_angle: want {_FLATTEST * 180.0 / pi:g} to below 90 deg, got "
                f"{self.ramp_angle * 180.0 / pi:.3g} deg"
            )
        if self.over > self.cutter.diameter:
            raise ValueError(
                f"step_over: want at most the diameter, {self.cutter.diameter * 1e3:g} mm, got "
                f"{self.over * 1e3:g} mm: it would leave ridges"
            )
        if self.finish and self.stock == 0.0:
            raise ValueError("finish: nothing is left for it; want a stock above 0")
        self._check_depth()

    def _check_depth(self) -> None:
        """Refuse a depth that cannot be reached, or takes too many passes."""
        if self.depth > self.cutter.cutting_length:
            raise ValueError(
                f"depth: {self.depth * 1e3:g} mm is deeper than the cutter can go, "
                f"{self.cutter.cutting_length * 1e3:g} mm"
            )
        if not (isfinite(self.top) and self.top <= 0.0):
            raise ValueError(f"top: want at most 0, the top of the stock, got {self.top}")
        if self.depth / self.down > _MOST_PASSES:
            raise ValueError(
                f"step_down: {self.down * 1e3:.3g} mm is more than {_MOST_PASSES} passes down to "
                f"{self.depth * 1e3:g} mm; take deeper ones"
            )

    @property
    def reach(self) -> float:
        """How far the cutter's middle stays from sides until they are finished, m."""
        return self.cutter.radius + self.slack + self.stock

    @property
    def over(self) -> float:
        """How far passes beside each other are apart, m."""
        return self.cutter.step_over if self.step_over is None else self.step_over

    @property
    def down(self) -> float:
        """How deep a pass may be, m."""
        return self.cutter.step_down if self.step_down is None else self.step_down

    @property
    def levels(self) -> tuple[float, ...]:
        """The heights of the passes, m, falling, all steps alike, the last exactly at the depth."""
        count = max(1, ceil(self.depth / self.down - _WHOLE))
        between = [self.top - self.depth * k / count for k in range(1, count)]
        return (*between, self.top - self.depth)

    @property
    def wall(self) -> int:
        """On which side of its way the cutter has what stays: 1 left, -1 right."""
        # a cutter that turns clockwise climbs with the wall to its right
        clockwise = self.cutter.speed >= 0.0
        return -1 if self.climb == clockwise else 1


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """A way of the cutter's middle in the plane."""

    path: Contour
    """The way, open; one around ends where it begins."""
    wall: int = 0
    """On which side of it stays what is cut along: 1 left, -1 right, 0 neither."""
    link: bool = False
    """Whether it only leads from one way to the next."""
    lifted: tuple[tuple[float, float], ...] = ()
    """From where to where along it tabs stay and the cutter goes over them, m, rising."""
    legs: tuple[Leg, ...] = ()
    """What the way is where splines are, of which ``path`` has the lines and arcs beside them."""

    @property
    def around(self) -> bool:
        """Whether it ends where it begins."""
        return bool((self.path.vertices[0] == self.path.vertices[-1]).all())


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """Ways one after the other that are cut without lifting the cutter."""

    tracks: tuple[Track, ...]
    """The ways; each begins where the one before it ends."""


@dataclass(frozen=True, slots=True, eq=False)
class Milled:
    """What an operation gives."""

    actions: tuple[Action, ...]
    """What the machine does, in coordinates of the work."""
    notes: tuple[str, ...] = ()
    """What the person should know: what could not be done as asked."""


@dataclass(slots=True)
class Notes:
    """What there is to be told, each thing once, with how often it came."""

    counts: dict[str, int] = field(default_factory=dict)
    """How often each was told."""

    def add(self, text: str) -> None:
        """Tell something."""
        self.counts[text] = self.counts.get(text, 0) + 1

    def given(self) -> tuple[str, ...]:
        """Give what was told."""
        return tuple(f"{t} ({n} times)" if n > 1 else t for t, n in self.counts.items())


def _require(name: str, value: float, *, above: bool) -> None:
    if not (isfinite(value) and (value > 0.0 if above else value >= 0.0)):
        wanted = "above zero" if above else "of zero or more"
        raise ValueError(f"{name}: want a finite number {wanted}, got {value}")
