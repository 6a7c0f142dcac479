"""Closed-form inverse kinematics: all branches of an arm whose structure allows it.

The class of the arm is found from its model (module structure). An arm of fewer than six joints
meets a pose only now and then, so the call says what of the target is free:

- ``"nothing"``: the whole pose shall be met.
- ``"yaw"``: a turn about the first joint's axis, the vertical of an arm that stands upright; the
  position, and pitch and roll of the tool, are met.
- ``"roll"``: a turn about the last joint's axis; the position and the direction of that axis, to
  which the tool points, are met.
- ``"yaw and roll"``: the position and the pitch of the tool's pointing axis are met; a roll joint
  keeps the seed's value.
- ``"orientation"``: the position alone is met.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Self, TypeAlias

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import KinematicsError
from splinearm.units import DEG

from . import branch_name, gauge, planar_chain, shortfall, structure, turn
from .answer import IKStatus
from .arm import Arm
from .branch import Branches as Branches
from .chain import Chain
from .pose import Pose
from .structure import ArmClass as ArmClass
from .structure import Structure

_Kernel: TypeAlias = Callable[..., tuple[FloatArray, FloatArray]]

TOLERANCE = 1e-7
"""How far forward kinematics may find a branch from its target, m and rad; most are at 1e-14."""

MET = {
    "nothing": "pose",
    "yaw": "position, pitch and roll",
    "roll": "position and pointing direction",
    "yaw and roll": "position and pitch",
    "orientation": "position",
}
"""What is met when that is free."""

_FEW = {"nothing": 0, "yaw": 1, "roll": 2, "yaw and roll": 3}
_ALLOWED = {
    ArmClass.PAN_AND_ROLL: ("nothing", "yaw", "roll", "yaw and roll"),
    ArmClass.PAN: ("nothing", "yaw", "yaw and roll"),
    ArmClass.PLANAR: ("nothing", "orientation"),
}
_SIX = (ArmClass.SPHERICAL_WRIST, ArmClass.SPHERICAL_SHOULDER, ArmClass.THREE_PARALLEL)
_SOLVED = (*_SIX, ArmClass.MEETING_WRIST)
_SAME = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class ClosedForm:
    """The closed form of one arm, found once."""

    arm: Arm
    """The arm."""
    structure: Structure
    """Its class; of the other six joints where one of seven is given."""
    given: int | None
    """The joint whose position each call gives, counted from 0; None: none."""
    still: FloatArray
    """Inverse of the constant transform beyond a given first or last joint, shape (4, 4)."""
    _six: _Kernel = field(init=False, repr=False)
    _given: _Kernel = field(init=False, repr=False)
    _at_end: bool = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if self.structure.kind not in _SOLVED:
            for name in ("_six", "_given"):
                object.__setattr__(self, name, _refuse)
            object.__setattr__(self, "_at_end", False)
            return
        # here numba is loaded
        from . import meeting_kernel, six_kernel

        searched = self.structure.kind is ArmClass.MEETING_WRIST
        object.__setattr__(self, "_six", meeting_kernel.solve if searched else six_kernel.solve)
        object.__setattr__(self, "_given", six_kernel.solve_given)
        at_end = self.given in (0, self.arm.n - 1) and not searched
        object.__setattr__(self, "_at_end", at_end)

    @classmethod
    def of(cls, arm: Arm, *, given: str | None = None) -> Self:
        """Find the closed form of an arm.

        Args:
            arm: The arm.
            given: For an arm of seven joints: the joint whose position will be given.

        Raises:
            KinematicsError: If the arm has no closed form; numeric search serves it.
            ValueError: If there is no joint of that name, or one is given of an arm that is not
                of seven joints.
        """
        if given is None:
            found = structure.find(arm.packed)
            if found.kind is ArmClass.NONE:
                raise KinematicsError(_no_form(arm))
            return cls(arm, found, None, np.eye(4))
        if given not in arm.joint_names:
            raise ValueError(f"given: want one of {list(arm.joint_names)}, got {given!r}")
        if arm.n != 7:
            raise ValueError(f"given: want an arm of seven joints, got one of {arm.n}")
        joint = arm.joint_names.index(given)
        found = structure.find(_without(arm.packed, joint, 0.5))
        if found.kind not in _SIX:
            raise KinematicsError(
                f"arm {arm.name!r} with {given!r} given has no closed form; give another joint or "
                "use search"
            )
        beyond = arm.packed.fixed[-1 if joint == arm.n - 1 else 0]
        return cls(arm, found, joint, np.linalg.inv(beyond))

    def solve(
        self, T: FloatArray, q_seed: FloatArray, q_given: float = 0.0
    ) -> tuple[FloatArray, FloatArray]:
        """Give all branches of a whole pose of six or seven joints; nothing is checked here.

        Args:
            T: The pose T_base_tool, shape (4, 4), float64.
            q_seed: What joints that are free in a singular pose keep, shape (n,), rad, float64.
            q_given: Position of the given joint, rad.

        Returns:
            Joint positions between -pi and pi, whatever the limits, shape (m, n), rad; and the
            number of each branch, shape (m,).

        Raises:
            KinematicsError: If the given joint stands where the other six have no closed form.
        """
        packed = self.structure.packed
        if self.given is None:
            return self._six(packed, T, q_seed)
        if self._at_end:
            return self._given(packed, T, q_seed, self.still, q_given, self.given > 0)
        found = _structure_at(self.arm, self.given, q_given)
        if found.kind not in _SIX:
            name = self.arm.joint_names[self.given]
            raise KinematicsError(
                f"arm {self.arm.name!r} has no closed form with {name!r} at {q_given / DEG:.4g} "
                "deg: give another position or joint, or use search"
            )
        six, codes = self._six(found.packed, T, np.delete(q_seed, self.given))
        return np.insert(six, self.given, q_given, axis=1), codes

    def solve_batch(self, T: FloatArray, q_seed: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give all branches of whole poses of six joints; nothing is checked here.

        Args:
            T: The poses T_base_tool, shape (m, 4, 4), float64.
            q_seed: What joints that are free in a singular pose keep, shape (6,), rad, float64.

        Returns:
            Joint positions between -pi and pi, whatever the limits, shape (m, 8, 6), rad, NaN
            behind the last branch; and the number of branches, shape (m,).

        Raises:
            ValueError: If the arm is not one of six joints.
        """
        from . import six_kernel

        if self.structure.kind not in _SIX or self.given is not None:
            raise ValueError(f"solve_batch: want an arm of six joints, got {self.structure.words}")
        q, count = np.empty((len(T), six_kernel.MOST, 6)), np.empty(len(T))
        six_kernel.solve_batch(self.structure.packed, T, q_seed, q, count)
        return q, count

    def branches(
        self,
        target: Pose | ArrayInput,
        q_seed: ArrayInput | None = None,
        *,
        free: str = "nothing",
        pointing: ArrayInput = (1.0, 0.0, 0.0),
        q_given: float | None = None,
    ) -> Branches:
        """Give all branches within the limits; see function ``branches``."""
        arm = self.arm
        limits = arm.limits
        allowed = _ALLOWED.get(self.structure.kind, ("nothing",))
        if free not in allowed:
            words = self.structure.words
            raise ValueError(f"free: want one of {list(allowed)} for {words}, got {free!r}")
        if (q_given is None) != (self.given is None) or not np.isfinite(q_given or 0.0):
            raise ValueError(f"q_given: want a number exactly if a joint is given, got {q_given}")
        T = _matrix(target, free)
        near = turn.middle(limits.q_min, limits.q_max)
        if q_seed is not None:
            near = frozen_array(q_seed, (arm.n,), "q_seed").copy()
        axis = np.array(frozen_array(pointing, (3,), "pointing"))
        length = np.linalg.norm(axis)
        if length == 0.0:
            raise ValueError(f"pointing: want a direction, got {axis.tolist()}")
        axis /= length
        q, codes = self._solve(T, near, free, axis, q_given)
        errors = shortfall.errors(arm, q, T, free, axis)
        good = (errors <= TOLERANCE).all(axis=0)
        q, codes, errors = q[good], codes[good], errors[:, good]
        q = np.where(arm.packed.turns, turn.nearest(q, near, limits.q_min, limits.q_max), q)
        excess = np.maximum(np.maximum(limits.q_min - q, q - limits.q_max), 0.0)
        keep = [i for i in _order(q, near) if not excess[i].any()]
        keep = _distinct(q, keep)
        status, joint, reason = IKStatus.REACHED, None, ""
        if not keep:
            status, joint, reason = self._why(T, q, excess, free, near, axis)
        return Branches(
            q=q[keep],
            names=tuple(branch_name.name(arm, self.structure, q[i], codes[i]) for i in keep),
            position_error=errors[0, keep],
            orientation_error=errors[1, keep],
            met=MET[free],
            beyond=int(excess.any(axis=1).sum()),
            status=status,
            joint=joint,
            reason=reason,
        )

    def _solve(
        self, T: FloatArray, near: FloatArray, free: str, axis: FloatArray, q_given: float | None
    ) -> tuple[FloatArray, FloatArray]:
        kind = self.structure.kind
        if kind in _SOLVED:
            return self.solve(T, near, q_given or 0.0)
        if kind is ArmClass.PLANAR:
            planar = planar_chain.find(self.arm.packed)
            return planar_chain.solve(planar, T, near, oriented=free == "nothing")
        from . import few_kernel

        packed = self.structure.packed
        return few_kernel.solve(packed, T, near, _FEW[free], axis, packed[-1, 3])

    def _why(
        self,
        T: FloatArray,
        q: FloatArray,
        excess: FloatArray,
        free: str,
        near: FloatArray,
        axis: FloatArray,
    ) -> tuple[IKStatus, str | None, str]:
        """Say why there is no branch."""
        if len(q):
            return shortfall.beyond_limits(self.arm, excess)
        far = shortfall.too_far(self.arm, T)
        if far:
            return IKStatus.OUT_OF_REACH, None, far
        for other in _ALLOWED.get(self.structure.kind, ())[1:]:
            if free != "nothing":
                break
            answer, _ = self._solve(T, near, other, axis, None)
            errors = shortfall.errors(self.arm, answer, T, other, axis)
            if (errors <= TOLERANCE).all(axis=0).any():
                reason = (
                    f"the {self.arm.n} joints of the arm cannot turn the tool that way there; "
                    f"they can with {other} free"
                )
                return IKStatus.ORIENTATION, None, reason
        reason = f"no joint positions reach the {MET[free]}, whatever the limits are"
        return IKStatus.OUT_OF_REACH, None, reason


def branches(
    arm: Arm,
    target: Pose | ArrayInput,
    q_seed: ArrayInput | None = None,
    *,
    free: str = "nothing",
    pointing: ArrayInput = (1.0, 0.0, 0.0),
    given: Mapping[str, float] | None = None,
) -> Branches:
    """Give all joint positions within the limits that bring the tool to a target.

    Every branch is confirmed by forward kinematics. In a singular pose a joint that is free keeps
    the seed's value.

    Args:
        arm: The arm.
        target: Where the tool shall be in base: a pose or its matrix, shape (4, 4); with
            ``free="orientation"`` also a position, shape (3,), m.
        q_seed: Whole turns are chosen nearest to it, and branches sorted by their distance from
            it, shape (n,), rad or m; None: the middle of the limits.
        free: What of the target need not be met; see the module's docstring.
        pointing: The tool's pointing axis in the tool frame, shape (3,), whose pitch counts when
            "yaw and roll" are free.
        given: Of an arm of seven joints: the name of one joint and its position, rad.

    Raises:
        KinematicsError: If the arm has no closed form; numeric search serves it.
        ValueError: If an argument is not of its shape, not finite, or not one of its words.
    """
    if given is None:
        return _form(arm, None).branches(target, q_seed, free=free, pointing=pointing)
    if len(given) != 1:
        raise ValueError(f"given: want one joint and its position, got {dict(given)}")
    joint, position = next(iter(given.items()))
    return _form(arm, joint).branches(
        target, q_seed, free=free, pointing=pointing, q_given=position
    )


def _refuse(*_: object) -> tuple[FloatArray, FloatArray]:
    raise ValueError("solve: want an arm of six joints, or of seven with one given; use branches")


@lru_cache(maxsize=64)
def _form(arm: Arm, given: str | None) -> ClosedForm:
    return ClosedForm.of(arm, given=given)


@lru_cache(maxsize=256)
def _structure_at(arm: Arm, joint: int, q: float) -> Structure:
    return structure.find(gauge.lock(arm.packed, joint, q))


def _without(chain: Chain, joint: int, q: float) -> Chain:
    """Give the chain without a joint: cut off at either end, else locked at q."""
    n = len(chain.turns)
    if 0 < joint < n - 1:
        return gauge.lock(chain, joint, q)
    kept = slice(1, None) if joint == 0 else slice(0, n - 1)
    fixed = chain.fixed[1:] if joint == 0 else chain.fixed[:-1]
    return Chain(
        fixed=fixed,
        joint_link=chain.joint_link[kept],
        turns=chain.turns[kept],
        slides=chain.slides[kept],
        any_slide=bool(chain.slides[kept].any()),
    )


def _matrix(target: Pose | ArrayInput, free: str) -> FloatArray:
    if isinstance(target, Pose):
        return target.matrix()
    if free == "orientation" and np.shape(target) == (3,):
        T = np.eye(4)
        T[:3, 3] = frozen_array(target, (3,), "target")
        return T
    return Pose.from_matrix(target).matrix()


def _order(q: FloatArray, near: FloatArray) -> list[int]:
    return [int(i) for i in np.argsort(np.linalg.norm(q - near, axis=1), kind="stable")]


def _distinct(q: FloatArray, rows: list[int]) -> list[int]:
    """Give the rows without those that say the same once more."""
    kept: list[int] = []
    for i in rows:
        if all(np.abs(np.sin(0.5 * (q[i] - q[j]))).max() > _SAME for j in kept):
            kept.append(i)
    return kept


def _no_form(arm: Arm) -> str:
    hint = "give the position of one joint, or use search" if arm.n == 7 else "use search"
    return f"arm {arm.name!r} has no closed form: {hint}"
