"""How servos have answered, and what they last said."""

from dataclasses import dataclass

from splinearm.arrays import FloatArray


@dataclass(slots=True)
class ServoStats:
    """How one servo has answered so far."""

    reads: int = 0
    """Reads that it was asked for; some may be hidden by the loss of another servo."""
    timeouts: int = 0
    """Reads that it did not answer."""
    crc_errors: int = 0
    """Answers that came damaged."""
    retries: int = 0
    """Single instructions that had to be sent again."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class LastSeen:
    """The last that each joint said, also of joints that the last read has lost."""

    t: FloatArray
    """When, shape (n,), s on the monotonic clock; -inf: never."""
    q: FloatArray
    """Position, shape (n,), rad; NaN: never seen."""
    qd: FloatArray
    """Velocity, shape (n,), rad/s; NaN: never seen."""
    current: FloatArray
    """Current, shape (n,), A; NaN: never seen, or not measured."""
