"""What happened in one turn of the loop."""

from dataclasses import dataclass

from splinearm.joints import JointSetpoint, JointState


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Cycle:
    """One turn of the loop."""

    index: int
    """Number of the cycle, from 0; a skipped one leaves a gap."""
    t: float
    """When it was due, s since the loop began."""
    lateness: float
    """By how much it began late, s."""
    setpoint: JointSetpoint
    """What was written; its ``t`` is time along the motion."""
    state: JointState | None
    """What was measured before that; None if no full answer came."""
    busy: float
    """How long reading, checking and writing took, s."""
    stride: int = 1
    """How many cycles after the last it was due: more than one once the rate was lowered."""
