"""The planar arm of two turning joints, solved in closed form.

Seen from the tip of its axes, the arm's elbow is UP when it lies to the left of the way from the
shoulder to the target (above it, for a target straight ahead along x), DOWN when to the right.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from math import hypot
from typing import NamedTuple, Self

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import UnreachableError
from splinearm.joints import JointKind
from splinearm.units import DEG, MM

from . import space, turn
from .arm import Arm
from .ik import search

REACH_TOLERANCE = 1e-9
"""How far beyond its reach rounding may carry a target that is still met by a straight arm, m."""

_PARALLEL = 1e-9


class Elbow(Enum):
    """On which side of the way from shoulder to target the elbow lies."""

    UP = "up"
    """To the left, seen from the tip of the axes; the second joint bends clockwise."""

    DOWN = "down"
    """To the right; the second joint bends anticlockwise."""


class Elbows(NamedTuple):
    """Both answers of a planar 2R arm. At full stretch and full fold they are one pose."""

    up: FloatArray
    """Joint angles with the elbow up, shape (..., 2), rad."""
    down: FloatArray
    """Joint angles with the elbow down, shape (..., 2), rad."""


def solve_elbows(
    a1: float, a2: float, points: ArrayInput, *, reach_tolerance: float = REACH_TOLERANCE
) -> Elbows:
    """Give both pairs of joint angles that bring the tip of a 2R arm to points of its plane.

    The shoulder is the origin; q = 0 stretches the arm along x; the second angle is counted from
    the first link. The second angle is in -pi to 0 (up) or 0 to pi (down), the first in -2 pi to
    2 pi. With links of equal length every first angle reaches the shoulder itself: 0 is given.

    Args:
        a1: Length of the first link, m, above zero.
        a2: Length of the second link, m, above zero.
        points: Shape (..., 2), m.
        reach_tolerance: By how much a point may be out of reach and is still met, m.

    Raises:
        UnreachableError: If a point is out of reach; it says by how much and what is in reach.
        ValueError: If a length is not above zero or a point is not finite.
    """
    for name, length in (("a1", a1), ("a2", a2)):
        if not (np.isfinite(length) and length > 0.0):
            raise ValueError(f"{name}: want a finite length above zero, got {length}")
    points = np.asarray(points, dtype=np.float64)
    if points.ndim == 0 or points.shape[-1] != 2 or not np.isfinite(points).all():
        raise ValueError(f"points: want finite numbers of shape (..., 2), got {points.tolist()}")
    x, y = points[..., 0], points[..., 1]
    r = np.hypot(x, y)
    _check_reach(a1, a2, r, reach_tolerance)
    # tan(q2 / 2)^2 = (stretch^2 - r^2) / (r^2 - fold^2): the law of cosines by half angles, which
    # unlike the arc cosine is exact at full stretch and full fold. D. Marsh, Applied Geometry for
    # Computer Graphics and CAD, 2nd ed. 2005, section 1.8.2 gives the forward equations
    stretch, fold = a1 + a2, abs(a1 - a2)
    beyond = np.maximum(stretch - r, 0.0) * (stretch + r)
    within = np.maximum(r - fold, 0.0) * (r + fold)
    q2 = 2.0 * np.arctan2(np.sqrt(beyond), np.sqrt(within))
    lean = np.arctan2(a2 * np.sin(q2), a1 + a2 * np.cos(q2))
    lean = np.where(r == 0.0, 0.0, lean)
    ahead = np.arctan2(y, x)
    return Elbows(
        up=np.stack((ahead + lean, -q2), axis=-1), down=np.stack((ahead - lean, q2), axis=-1)
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Planar2R:
    """An arm of two parallel turning joints, however it stands and wherever its zeros are."""

    arm: Arm
    """The arm."""
    T_base_plane: FloatArray
    """Pose of the working plane in base, shape (4, 4): origin on the first axis, z along it, at
    the height of the tool point; x is where the first link points at q = 0."""
    a1: float
    """Distance between the axes, m."""
    a2: float
    """Distance of the tool point from the second axis, m."""
    sense: float
    """1 when the second axis points as the first does, -1 when against it."""
    bend: float
    """Angle from the first link to the second at q = 0, rad, anticlockwise about the first axis."""

    @classmethod
    def of(cls, arm: Arm) -> Self | None:
        """Give the planar 2R arm that ``arm`` is, or None when it is none."""
        if arm.n != 2 or any(link.kind is not JointKind.REVOLUTE for link in arm.links):
            return None
        base, elbow, tool = arm.packed.fixed
        sense = float(elbow[2, 2])
        a1, a2 = hypot(elbow[0, 3], elbow[1, 3]), hypot(tool[0, 3], tool[1, 3])
        if abs(abs(sense) - 1.0) > _PARALLEL or min(a1, a2) < REACH_TOLERANCE:
            return None
        sense = float(np.sign(sense))
        first = np.arctan2(elbow[1, 3], elbow[0, 3])
        turned = np.arctan2(elbow[1, 0], elbow[0, 0])
        second = turned + sense * np.arctan2(tool[1, 3], tool[0, 3])
        up = space.translation((0.0, 0.0, elbow[2, 3] + sense * tool[2, 3]))
        return cls(
            arm=arm,
            T_base_plane=frozen_array(base @ up @ space.rotation_z(first), (4, 4), "T_base_plane"),
            a1=a1,
            a2=a2,
            sense=sense,
            bend=float(second - first),
        )

    def solve(
        self,
        target: ArrayInput,
        q_seed: ArrayInput | None = None,
        *,
        elbow: Elbow | None = None,
        position_tolerance: float = 1e-6,
    ) -> FloatArray:
        """Give joint angles, shape (2,), rad, within the limits that bring the tool to a point.

        Args:
            target: Position in base, shape (3,), m.
            q_seed: The answer nearest to it is given, shape (2,), rad; None: the one nearest to
                the middle of the limits.
            elbow: Which elbow the answer shall have; None: either.
            position_tolerance: By how much the target may be out of the plane or reach, m.

        Raises:
            UnreachableError: If the target is off the plane, out of reach, or beyond a limit.
            ValueError: If an argument is not of its shape or not finite.
        """
        near = self._near(q_seed)
        candidates = self._candidates(target, near, position_tolerance)
        if elbow is not None:
            candidates = {elbow: candidates[elbow]}
        fitting = [q for q in candidates.values() if not self._excess(q).any()]
        if not fitting:
            raise self._beyond_limits(target, list(candidates.values()))
        return min(fitting, key=lambda q: float(np.linalg.norm(q - near)))

    def solutions(
        self,
        target: ArrayInput,
        q_seed: ArrayInput | None = None,
        *,
        position_tolerance: float = 1e-6,
    ) -> dict[Elbow, FloatArray]:
        """Give each elbow's joint angles, shape (2,), rad, as far as they are within the limits.

        Whole turns are chosen to be nearest to the seed. At full stretch and full fold the two
        elbows are one pose. Arguments and errors are those of ``solve``.
        """
        candidates = self._candidates(target, self._near(q_seed), position_tolerance)
        fitting = {elbow: q for elbow, q in candidates.items() if not self._excess(q).any()}
        if not fitting:
            raise self._beyond_limits(target, list(candidates.values()))
        return fitting

    def _near(self, q_seed: ArrayInput | None) -> FloatArray:
        if q_seed is None:
            return turn.middle(self.arm.limits.q_min, self.arm.limits.q_max)
        return frozen_array(q_seed, (2,), "q_seed")

    def _candidates(
        self, target: ArrayInput, near: FloatArray, tolerance: float
    ) -> dict[Elbow, FloatArray]:
        """Give each elbow's joint angles, nearest to the limits if not within them."""
        point = self._in_plane(frozen_array(target, (3,), "target"), tolerance)
        elbows = solve_elbows(self.a1, self.a2, point, reach_tolerance=tolerance)
        limits = self.arm.limits
        candidates = {}
        for elbow, angles in ((Elbow.UP, elbows.up), (Elbow.DOWN, elbows.down)):
            q = np.array((angles[0], self.sense * (angles[1] - self.bend)))
            candidates[elbow] = turn.nearest(q, near, limits.q_min, limits.q_max)
        return candidates

    def _excess(self, q: FloatArray) -> FloatArray:
        """Give by how much each joint is beyond its limits."""
        limits = self.arm.limits
        excess: FloatArray = np.maximum(np.maximum(limits.q_min - q, q - limits.q_max), 0.0)
        return excess

    def _in_plane(self, target: FloatArray, tolerance: float) -> FloatArray:
        """Give x and y of a target in the working plane after checking that it lies there."""
        x, y, height = space.apply(space.rigid_inverse(self.T_base_plane), target)
        if abs(height) > tolerance:
            miss = hypot(height, _gap(self.a1, self.a2, hypot(x, y)))
            side = "above" if height > 0.0 else "below"
            reason = f"the target is {abs(height) / MM:.4g} mm {side} the plane of the arm"
            raise UnreachableError(miss, 0.0, reason=reason, what="the position")
        return np.array((x, y))

    def _beyond_limits(
        self, target: ArrayInput, candidates: Sequence[FloatArray]
    ) -> UnreachableError:
        """Give the error for a target that is reached only by joints beyond their limits."""
        least = min(candidates, key=lambda q: float(self._excess(q).max()))
        excess = self._excess(least)
        joint = self.arm.joint_names[int(np.argmax(excess))]
        reason = f"{joint} is at its limit, {excess.max() / DEG:.3g} deg short"
        nearest = search(self.arm, target, least, restarts=0)
        miss = nearest.position_error
        if nearest.reached:
            # with the other elbow, which was not asked for: say what misses on the limit itself
            limits = self.arm.limits
            tip = self.arm.fk(np.clip(least, limits.q_min, limits.q_max))[:3, 3]
            miss = float(np.linalg.norm(tip - np.asarray(target, dtype=np.float64)))
        return UnreachableError(miss, 0.0, joint, reason, "the position")


def _gap(a1: float, a2: float, r: float) -> float:
    """Give by how much a point at distance r is out of reach, m."""
    return max(r - (a1 + a2), abs(a1 - a2) - r, 0.0)


def _check_reach(a1: float, a2: float, r: FloatArray, tolerance: float) -> None:
    miss = np.maximum(r - (a1 + a2), abs(a1 - a2) - r)
    if not (miss > tolerance).any():
        return
    at = np.unravel_index(int(np.argmax(miss)), miss.shape)
    raise UnreachableError(
        float(miss[at]),
        0.0,
        reason=(
            f"the arm reaches from {abs(a1 - a2) / MM:.4g} mm to {(a1 + a2) / MM:.4g} mm from its "
            f"shoulder; the target is at {float(r[at]) / MM:.4g} mm"
        ),
        what="the position",
    )
