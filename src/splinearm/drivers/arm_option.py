"""How an arm of servos shall behave: what a program may say, and what holds if it says nothing."""

from dataclasses import dataclass, field
from typing import TypedDict

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.units import DEG

from .base import Feedforward


class ArmOptions(TypedDict, total=False):
    """The fields of ``ArmManner``, as keywords."""

    watchdog: float | None
    hold_tolerance: float
    near: ArrayInput | None
    feedforward: Feedforward | None


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ArmManner:
    """How an arm of servos shall behave."""

    watchdog: float | None = 0.04
    """Silence after which the servos stop by themselves, s, in steps of 20 ms; None: they do not.
    A program that is killed leaves them moving for that time, one that is late has them stop."""
    hold_tolerance: float = field(default=6.0 * DEG)
    """How far from its goal a joint may be for ``hold`` to keep that goal, rad. With the gains of
    the factory an arm hangs 1 to 3 degrees below its goals."""
    near: ArrayInput | None = None
    """Where the joints stand, to less than half a turn, shape (n,), rad; NaN of those where that is
    not known. Only joints of more than one turn need it, whose servos forget with the power which
    turn they are in."""
    feedforward: Feedforward | None = None
    """By how much the goals are ahead of the setpoints; None: not at all. Limits count for the
    setpoint; a goal that is ahead of it may be beyond a joint's limit. At the end of what the servo
    takes the goal stays there, which is told once a joint."""

    def __post_init__(self) -> None:
        if not self.hold_tolerance > 0.0:
            raise ValueError(f"hold_tolerance: want above zero, got {self.hold_tolerance}")


def known_angles(near: ArrayInput | None, n: int) -> FloatArray:
    """Give where n joints are known to be, rad, NaN of those where it is not.

    Raises:
        ValueError: If there is not one angle, or NaN, a joint.
    """
    if near is None:
        return np.full(n, np.nan)
    known = np.array(near, dtype=np.float64)
    if known.shape != (n,) or np.isinf(known).any():
        raise ValueError(f"near: want {n} angles, NaN where one is not known, got {near}")
    return known
