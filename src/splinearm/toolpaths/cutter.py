"""Cutters: how wide they are, how fast and how deep they may go."""

from dataclasses import dataclass
from enum import StrEnum
from math import inf, isfinite, pi, tan


class Tip(StrEnum):
    """The shape of a cutter's end."""

    FLAT = "flat"
    """Level: an end mill."""
    BALL = "ball"
    """Half a ball."""
    POINT = "point"
    """A cone: an engraver or a drill."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cutter:
    """A cutter and what it may do in the material at hand."""

    number: int
    """Its place in the machine's table."""
    name: str
    """What a person calls it."""
    diameter: float
    """Diameter, m."""
    tip: Tip = Tip.FLAT
    """The shape of its end."""
    tip_angle: float = pi
    """The whole angle of a pointed end, rad."""
    cutting_length: float = inf
    """How deep it can go, m."""
    feed: float
    """How fast it goes sideways, m/s."""
    plunge: float
    """How fast it goes down, m/s."""
    speed: float = 0.0
    """How fast the spindle turns, rad/s, above 0 clockwise; 0: it does not, as a pen."""
    step_down: float
    """How deep a pass may be, m."""
    step_over: float
    """How far passes beside each other may be apart, m."""

    def __post_init__(self) -> None:
        for name in ("diameter", "feed", "plunge", "step_down", "step_over"):
            value = getattr(self, name)
            if not (isfinite(value) and value > 0.0):
                raise ValueError(f"{name}: want a finite number above zero, got {value}")
        if not isfinite(self.speed):
            raise ValueError(f"speed: want a finite number, got {self.speed}")
        if self.step_over > self.diameter:
            raise ValueError(
                f"step_over: want at most the diameter, {self.diameter * 1e3:g} mm, got "
                f"{self.step_over * 1e3:g} mm: it would leave ridges"
            )
        if not 0.0 < self.tip_angle <= pi:
            raise ValueError(f"tip_angle: want above 0 and at most pi, got {self.tip_angle}")
        if not self.cutting_length > 0.0:
            raise ValueError(f"cutting_length: want above zero, got {self.cutting_length}")
        if self.number < 0:
            raise ValueError(f"number: want 0 or more, got {self.number}")

    @property
    def radius(self) -> float:
        """Half its diameter, m."""
        return 0.5 * self.diameter

    def radius_at(self, depth: float) -> float:
        """Give the radius of what it cuts at the surface when its tip is that deep, m."""
        if self.tip is Tip.FLAT:
            return self.radius
        if self.tip is Tip.BALL:
            inside = min(depth, self.radius)
            return float((inside * (self.diameter - inside)) ** 0.5)
        return min(self.radius, depth * tan(0.5 * self.tip_angle))
