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
- ``"orientation"``: the position alone is met; of what is left open a roll joint keeps the seed's
  value, and so does the pitch as far as the arm reaches with it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Self, TypeAlias

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.errors import KinematicsError
from splinearm.units import DEG

from . import branch_name, gauge, general_six, planar_chain, shortfall, structure, swivel, turn
from .answer import IKStatus
from .arm import Arm
from .branch import Branches as Branches
from .branch import nearest_first
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

_FEW = {"nothing": 0, "yaw": 1, "roll": 2, "yaw and roll": 3, "orientation": 4}
_ALLOWED = {
    ArmClass.PAN_AND_ROLL: ("nothing", "yaw", "roll", "yaw and roll", "orientation"),
    ArmClass.PAN: ("nothing", "yaw", "yaw and roll", "orientation"),
    ArmClass.PLANAR: ("nothing", "orientation"),
}
_SIX = (ArmClass.SPHERICAL_WRIST, ArmClass.SPHERICAL_SHOULDER, ArmClass.THREE_PARALLEL)
_WHOLE = (*_SIX, ArmClass.GENERAL, ArmClass.SEVEN)
_SWIVEL = "swivel"


@dataclass(frozen=True, slots=True, eq=False)
class ClosedForm:
    """The closed form of one arm, found once."""

    arm: Arm
    """The arm."""
    structure: Structure
    """Its class; of the other six joints where one of seven is given."""
    given: int | None
    """The joint whose position each call gives, counted from 0; None: none, or the swivel."""
    still: FloatArray
    """Inverse of the constant transform beyond a given first or last joint, shape (4, 4)."""
    _whole: _Kernel = field(init=False, repr=False)
    _given: _Kernel = field(init=False, repr=False)
    _at_end: bool = field(init=False, repr=False)

    def __post_init__(self) -> None:
        whole: _Kernel = _refuse
        given: _Kernel = _refuse
        if self.structure.kind in _WHOLE:
            # here numba is loaded
            from . import general_six_kernel, six_kernel, swivel_kernel

            kernels = {ArmClass.GENERAL: general_six_kernel, ArmClass.SEVEN: swivel_kernel}
            whole = kernels.get(self.structure.kind, six_kernel).solve
            given = six_kernel.solve_given
        object.__setattr__(self, "_whole", whole)
        object.__setattr__(self, "_given", given)
        at_end = self.given in (0, self.arm.n - 1) and self.structure.kind in _SIX
        object.__setattr__(self, "_at_end", at_end)

    @classmethod
    def of(cls, arm: Arm, *, given: str | None = None) -> Self:
        """Find the closed form of an arm.

        Args:
            arm: The arm.
            given: For an arm of seven joints: the joint whose position will be given, or "swivel".

        Raises:
            KinematicsError: If the arm has no closed form; numeric search serves it.
            ValueError: If there is no joint of that name, or one is given of an arm that is not
                of seven joints.
        """
        if given is None:
            found = _complete(structure.find(arm.packed))
            if found is None:
                raise KinematicsError(_no_form(arm))
            return cls(arm, found, None, np.eye(4))
        if given not in (*arm.joint_names, _SWIVEL):
            words = [*arm.joint_names, _SWIVEL]
            raise ValueError(f"given: want one of {words}, got {given!r}")
        if arm.n != 7:
            raise ValueError(f"given: want an arm of seven joints, got one of {arm.n}")
        if given not in arm.joint_names:
            return cls(arm, swivel.structure_of(arm), None, np.eye(4))
        joint = arm.joint_names.index(given)
        found = _complete(structure.find(gauge.without(arm.packed, joint, 0.5)))
        if found is None:
            raise KinematicsError(
                f"arm {arm.name!r} with {given!r} given has no closed form; give another joint or "
                "use search"
            )
        beyond = arm.packed.fixed[-1 if joint == arm.n - 1 else 0]
        return cls(arm, found, joint, np.linalg.inv(beyond))

    @property
    def takes(self) -> bool:
        """Whether each call gives a number: the position of a joint, or the swivel."""
        return self.given is not None or self.structure.kind is ArmClass.SEVEN

    def solve(
        self, T: FloatArray, q_seed: FloatArray, q_given: float = 0.0
    ) -> tuple[FloatArray, FloatArray]:
        """Give all branches of a whole pose of six or seven joints; nothing is checked here.

        Args:
            T: The pose T_base_tool, shape (4, 4), float64.
            q_seed: What joints that are free in a singular pose keep, shape (n,), rad, float64.
            q_given: Position of the given joint, or the swivel, rad.

        Returns:
            Joint positions between -pi and pi, whatever the limits, shape (m, n), rad; and the
            number of each branch, shape (m,).

        Raises:
            KinematicsError: If the given joint stands where the other six have no closed form, or
                the swivel has no meaning in that pose.
        """
        packed = self.structure.packed
        if self._at_end:
            return self._given(packed, T, q_seed, self.still, q_given, self.given != 0)
        if self.given is None:
            if self.structure.kind is ArmClass.SEVEN:
                swivel.check(self.arm, self.structure, T)
                return self._whole(packed, T, q_seed, q_given)
            return self._whole(packed, T, q_seed)
        six = self._six_at(q_given)
        q, codes = six.solve(T, np.delete(q_seed, self.given))
        return np.insert(q, self.given, q_given, axis=1), codes

    def solve_batch(
        self, T: FloatArray, q_seed: FloatArray, q_given: float = 0.0
    ) -> tuple[FloatArray, FloatArray]:
        """Give all branches of whole poses of six or seven joints; nothing is checked here.

        Args:
            T: The poses T_base_tool, shape (m, 4, 4), float64.
            q_seed: What joints that are free in a singular pose keep, shape (n,), rad, float64.
            q_given: Position of the given joint, or the swivel, in all of them, rad.

        Returns:
            Joint positions between -pi and pi, whatever the limits, shape (m, most, n), rad, NaN
            behind the last branch; and the number of branches, shape (m,). The most branches are
            8, 16 of joints of any kind, 32 with the swivel given.

        Raises:
            KinematicsError: As ``solve`` does.
            ValueError: If the arm has fewer than six joints.
        """
        from . import general_six_kernel, six_kernel, swivel_kernel

        kind = self.structure.kind
        if kind not in _WHOLE:
            words = self.structure.words
            raise ValueError(f"solve_batch: want an arm of six joints or more, got {words}")
        packed = self.structure.packed
        if self.given is not None:
            six, seed = self._six_at(q_given), np.delete(q_seed, self.given)
            q, count = six.solve_batch(T, seed)
            whole = np.insert(q, self.given, np.where(np.isnan(q[..., 0]), np.nan, q_given), axis=2)
            return whole, count
        count = np.empty(len(T))
        if kind is ArmClass.SEVEN:
            for pose in T:
                swivel.check(self.arm, self.structure, pose)
            wide = np.empty((len(T), swivel_kernel.MOST, 8))
            swivel_kernel.solve_batch(packed, T, q_seed, q_given, wide, count)
            q = wide[..., :7]
        elif kind is ArmClass.GENERAL:
            q = np.empty((len(T), general_six_kernel.MOST, 6))
            general_six_kernel.solve_batch(packed, T, q_seed, q, count)
        else:
            q = np.empty((len(T), six_kernel.MOST, 6))
            six_kernel.solve_batch(packed, T, q_seed, q, count)
        return q, count

    def _six_at(self, q_given: float) -> "ClosedForm":
        """Give the closed form of the other six joints with the given one in its place."""
        if self.given is None:
            raise ValueError("given: want a joint")
        return _locked(self.arm, self.given, q_given, self.structure)

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
        if (q_given is None) == self.takes or not np.isfinite(q_given or 0.0):
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
        keep = nearest_first(q, near, (excess == 0.0).all(axis=1))
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
        if kind in _WHOLE:
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
        given: Of an arm of seven joints: the name of one joint and its position, rad; or "swivel"
            and the swivel of the elbow, rad, as module swivel has it.

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
def _locked(arm: Arm, joint: int, q: float, like: Structure) -> ClosedForm:
    """Give the closed form of the other six joints of an arm whose joint stands at q."""
    found: Structure | None = structure.find(gauge.lock(arm.packed, joint, q))
    if found is not None and found.kind is ArmClass.GENERAL is like.kind:
        found = general_six.complete_like(found, like)
    elif found is not None:
        found = _complete(found)
    if found is None or found.kind not in _WHOLE:
        raise KinematicsError(
            f"arm {arm.name!r} has no closed form with {arm.joint_names[joint]!r} at "
            f"{q / DEG:.4g} deg: give another position or joint, or use search"
        )
    return ClosedForm(arm, found, None, np.eye(4))


def _complete(found: Structure) -> Structure | None:
    """Give a structure with all that its kernels need; None if there is no closed form."""
    if found.kind is ArmClass.GENERAL:
        return general_six.complete(found)
    return None if found.kind is ArmClass.NONE else found


def _matrix(target: Pose | ArrayInput, free: str) -> FloatArray:
    if isinstance(target, Pose):
        return target.matrix()
    if free == "orientation" and np.shape(target) == (3,):
        T = np.eye(4)
        T[:3, 3] = frozen_array(target, (3,), "target")
        return T
    return Pose.from_matrix(target).matrix()


def _no_form(arm: Arm) -> str:
    hint = "give the position of one joint, or the swivel" if arm.n == 7 else "use search"
    return f"arm {arm.name!r} has no closed form: {hint}"
