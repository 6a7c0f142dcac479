"""Where a joint is zero: by a pose that the arm is put in, or by the two ends of its travel."""

from dataclasses import dataclass

from splinearm.drivers.model import ServoModel
from splinearm.errors import CalibrationError
from splinearm.units import DEG

_ENDS = 3.0 * DEG
"""By how much the travel may differ from what the limits span for its ends to be those, rad."""

_AGREE = 5.0 * DEG
"""By how much the ends may say zero is elsewhere than the pose does, rad: so well is a pose met."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Turned:
    """A joint that was turned by hand from one end to the other."""

    joint: str
    """The joint."""
    model: ServoModel
    """Its servo's model."""
    low: int
    """The lowest position, counted on, ticks."""
    high: int
    """The highest position, ticks."""
    sign: int
    """1: the count grows with the joint; -1: it falls."""
    q_min: float
    """Its lower limit in the arm's file, rad."""
    q_max: float
    """Its upper limit, rad."""

    @property
    def short(self) -> float:
        """By how much the travel is less than the limits span, rad."""
        return self.q_max - self.q_min - (self.high - self.low) / self.model.pulses_per_rad

    @property
    def ends_fit(self) -> bool:
        """Whether the ends of the travel can be the limits."""
        return abs(self.short) <= _ENDS


def zero_by_pose(count: float, q: float, sign: int, model: ServoModel) -> float:
    """Give the count at joint zero, of the count at ``q``, rad."""
    return count - sign * q * model.pulses_per_rad


def zero_by_ends(turned: Turned) -> float:
    """Give the count at joint zero, if the ends of the travel are the joint's limits.

    Raises:
        CalibrationError: If they cannot be: with how far it was turned and what the limits span.
    """
    if not turned.ends_fit:
        raise CalibrationError(
            f"joint {turned.joint!r}",
            f"was turned by {(turned.q_max - turned.q_min - turned.short) / DEG:.1f} deg, its "
            f"limits span {(turned.q_max - turned.q_min) / DEG:.1f} deg: turn it from stop to "
            "stop; if its limits are no stops, say where zero is by a pose",
        )
    middle = (turned.low + turned.high) / 2.0
    half = (turned.q_min + turned.q_max) / 2.0 * turned.model.pulses_per_rad
    return middle - turned.sign * half


def check_zero(turned: Turned, zero: float) -> str:
    """Give in words how the ends of the travel contradict a zero found by a pose; empty: not.

    Where the travel is not what the limits span they say nothing, as limits need not be stops.
    """
    if not turned.ends_fit:
        return ""
    off = (zero_by_ends(turned) - zero) / turned.model.pulses_per_rad
    if abs(off) <= _AGREE:
        return ""
    return (
        f"the ends of its travel say that zero is {abs(off) / DEG:.1f} deg from where the pose "
        "says; is it in its pose, and does it count the right way?"
    )
