"""What a search for joint positions answers."""

from dataclasses import dataclass, fields
from enum import Enum

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array


class IKStatus(Enum):
    """How a search for joint positions ended."""

    REACHED = "reached"
    """The answer meets the target and the limits; forward kinematics has confirmed it."""

    OUT_OF_REACH = "out of reach"
    """The position cannot be reached, whatever the limits are."""

    ORIENTATION = "orientation"
    """The position is reached, but the arm cannot turn the tool as wanted there."""

    JOINT_LIMIT = "joint limit"
    """The target would be reached if a joint could move on beyond its limit."""

    NOT_CONVERGED = "not converged"
    """The search found no answer and cannot say that there is none."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class IKResult:
    """The best joint positions that a search found, and how good they are."""

    q: FloatArray
    """Joint positions, within the limits, shape (n,), rad (m where a joint slides)."""
    position_error: float
    """Distance of the tool from the wanted position, m."""
    orientation_error: float
    """Angle of the tool from the wanted orientation, rad; 0 when any would do."""
    iterations: int
    """Steps that the search took, without those that only looked for the reason of a miss."""
    status: IKStatus
    """How the search ended."""
    joint: str | None = None
    """The joint whose limit is in the way, if one is."""
    reason: str = ""
    """By how much and why the target is missed, in the user's units; empty if it is met."""
    cause: str = ""
    """The reason without by how much."""

    def __post_init__(self) -> None:
        # what a kernel has confirmed comes frozen already; a check takes as long as a descent
        if not _is_frozen(self.q):
            object.__setattr__(self, "q", frozen_array(self.q, (None,), "q"))

    @property
    def reached(self) -> bool:
        """Whether the target is met."""
        return self.status is IKStatus.REACHED


def confirmed(
    q: FloatArray, position_error: float, orientation_error: float, iterations: int
) -> IKResult:
    """Give the result of joint positions that a kernel has confirmed; ``q`` is frozen, not copied.

    It is what `IKResult` gives, in a third of the time: all that is checked there is known here.
    """
    q.setflags(write=False)
    result = object.__new__(IKResult)
    _set_q(result, q)
    _set_position_error(result, position_error)
    _set_orientation_error(result, orientation_error)
    _set_iterations(result, iterations)
    _set_status(result, IKStatus.REACHED)
    _set_joint(result, None)
    _set_reason(result, "")
    _set_cause(result, "")
    return result


(
    _set_q,
    _set_position_error,
    _set_orientation_error,
    _set_iterations,
    _set_status,
    _set_joint,
    _set_reason,
    _set_cause,
) = (vars(IKResult)[each.name].__set__ for each in fields(IKResult))


def _is_frozen(q: ArrayInput) -> bool:
    return (
        isinstance(q, np.ndarray)
        and q.dtype == np.float64
        and q.ndim == 1
        and not q.flags.writeable
    )
