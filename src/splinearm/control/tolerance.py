"""How far an arm may be from where it is wanted, for all joints or for each."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointKind
from splinearm.units import DEG, MM

PerJoint = float | FloatArray
"""One number for all joints, or one a joint, shape (n,)."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Tolerances:
    """How far an arm may be from where it is wanted, rad (m for a sliding joint)."""

    start: PerJoint = 0.25 * DEG
    """From the first setpoint, where the arm is held before anything moves: so far it may jump."""
    path: PerJoint | None = 8.0 * DEG
    """From the setpoint, during the motion, besides ``lag``; None: not watched."""
    lag: PerJoint = 0.1
    """How long behind its setpoint a joint may be while it moves, s: a plain position servo lags
    by its speed times such a time, 0.045 s for an XM430-W350 with the gains it is sold with."""
    goal: PerJoint | None = 5.0 * DEG
    """From the last setpoint, at the end; None: not watched."""
    settle: PerJoint = 1.0
    """How long a joint may take to come within ``goal`` after the motion, s."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.lag) & (np.asarray(self.lag) >= 0.0)).all():
            raise ValueError(f"lag: want a time of at least zero, got {self.lag}")
        for name in ("start", "path", "goal", "settle"):
            value = getattr(self, name)
            if value is not None and not (np.asarray(value) > 0.0).all():
                raise ValueError(f"{name}: want a number above zero or None, got {value}")

    @classmethod
    def usual(cls, kinds: Sequence[JointKind]) -> "Tolerances":
        """Give those above for joints that turn; a joint that slides may be off by some mm."""
        slides = np.array([kind is JointKind.PRISMATIC for kind in kinds])
        return cls(
            start=np.where(slides, 0.5 * MM, 0.25 * DEG),
            path=np.where(slides, 20.0 * MM, 8.0 * DEG),
            goal=np.where(slides, 10.0 * MM, 5.0 * DEG),
        )
