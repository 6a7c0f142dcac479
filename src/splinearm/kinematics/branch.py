"""What a closed form answers: all branches of a target, and why there is none."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array

from .answer import IKStatus

_SAME = 1e-6


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Branches:
    """All joint positions within the limits that meet a target."""

    q: FloatArray
    """Joint positions, shape (m, n), rad (m where a joint slides), nearest to the seed first."""
    names: tuple[str, ...]
    """What each branch looks like: "shoulder left, elbow up, wrist flipped"."""
    position_error: FloatArray
    """Distance from the wanted position by forward kinematics, shape (m,), m."""
    orientation_error: FloatArray
    """Angle from what is wanted of the orientation, shape (m,), rad."""
    met: str
    """What of the target is met: "pose", "position, pitch and roll", "position and pitch" ..."""
    beyond: int
    """How many further branches the joint limits forbid."""
    status: IKStatus
    """REACHED if there is a branch, else what is in the way."""
    joint: str | None = None
    """The joint whose limit is in the way, if one is."""
    reason: str = ""
    """Why there is no branch, in the user's units; empty if there is one."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "q", frozen_array(self.q, (None, None), "q"))
        for name in ("position_error", "orientation_error"):
            values = frozen_array(getattr(self, name), (len(self.q),), name)
            object.__setattr__(self, name, values)

    def __len__(self) -> int:
        """Give the number of branches."""
        return len(self.q)

    @property
    def reached(self) -> bool:
        """Whether there is a branch."""
        return len(self.q) > 0

    def nearest(self, q_seed: ArrayInput) -> FloatArray:
        """Give the branch nearest to ``q_seed``, shape (n,), as it stands (no turns are added).

        Raises:
            ValueError: If there is no branch, or the seed has another shape.
        """
        if not self.reached:
            raise ValueError(f"branches: there is none: {self.reason}")
        seed = frozen_array(q_seed, (self.q.shape[1],), "q_seed")
        nearest: FloatArray = self.q[int(np.argmin(np.linalg.norm(self.q - seed, axis=1)))]
        return nearest


def nearest_first(
    q: FloatArray, near: FloatArray, allowed: "np.ndarray[tuple[Any, ...], np.dtype[np.bool_]]"
) -> list[int]:
    """Give the rows of q (m, n) that are allowed, nearest to a seed (n,) first, each but once."""
    kept: list[int] = []
    for i in np.argsort(np.linalg.norm(q - near, axis=1), kind="stable"):
        apart = [np.abs(np.sin(0.5 * (q[i] - q[j]))).max() > _SAME for j in kept]
        if allowed[i] and all(apart):
            kept.append(int(i))
    return kept
