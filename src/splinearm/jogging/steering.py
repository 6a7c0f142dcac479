"""Setpoints to come moved so that the tool goes another way, on the branch on which they are."""

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.kinematics.arm import Arm, Frame
from splinearm.kinematics.singularity import reach as reach_of

from .hindrance import Broken

_DAMPING = 1e-10
"""Added to the squares of singular values: far below any that a motion can use."""
_SECOND_DAMPING = 1e-6
"""Of what comes second: far above what the first leaves of joints that are not free."""
_PLENTY = 6
"""So many joints keep the tool to its way in all directions."""
_ROUNDS = 12
"""So often a step is corrected at most."""
_NEAR = 1e-10
"""A pose is met within this, reaches and rad."""
_MET = 1e-8
"""A pose that is missed by more cannot be met."""
_SAMPLES, _NEVER = 8, 1e-6
"""At so many places is looked which ways of the tool there are; what is less than that share of
the largest singular value is none."""
_ABLE = 0.02
"""Of a turn that is wished an arm of few joints may miss this share."""


class Steering:
    """Moves setpoints so that the tool goes a way.

    An arm of six joints or more keeps to it in all directions. One of fewer keeps the tool's
    position first, and of its orientation as much as it can.

    Args:
        arm: The arm.
    """

    def __init__(self, arm: Arm) -> None:
        self._arm = arm
        size = reach_of(arm) or 1.0
        self._rows = np.array([1.0 / size] * 3 + [1.0] * 3)
        self._never = _directions_never(arm)

    def steer(
        self, q: FloatArray, way: FloatArray, shares: FloatArray, frame: Frame
    ) -> FloatArray | Broken:
        """Give setpoints whose tool has gone shares of a way more, or why there are none.

        Args:
            q: The setpoints, shape (m, n), rad or m.
            way: Translation, m, and turn about the tool's point, rad, along the axes of ``frame``,
                shape (6,); short, as in one cycle.
            shares: How much of it each of them has gone, shape (m,).
            frame: Whose axes: "base" or "tool", as it is at each setpoint.
        """
        T = self._arm.fk(q)
        wanted = shares[:, None] * way
        if frame == "tool":
            R = T[:, :3, :3]
            linear, turn = ((R @ part[:, :, None])[:, :, 0] for part in _halves(wanted))
        else:
            linear, turn = _halves(wanted)
        p = T[:, :3, 3] + linear
        R = _turned(turn) @ T[:, :3, :3]
        few = self._arm.n < _PLENTY
        new = q
        error = np.concatenate((linear, turn), axis=1)
        for _ in range(_ROUNDS):
            J = self._rows[:, None] * self._arm.jacobian(new)
            scaled = (self._rows * error)[:, :, None]
            step = (_by_rank(J, scaled) if few else _solve(J, scaled))[:, :, 0]
            new = new + step
            T = self._arm.fk(new)
            error = np.concatenate((p - T[:, :3, 3], _turn(R, T[:, :3, :3])), axis=1)
            if np.abs(step).max() < _NEAR:
                break
        return self._judged(new, turn[-1], self._rows * error)

    def _judged(self, q: FloatArray, axis: FloatArray, error: FloatArray) -> FloatArray | Broken:
        """Pass setpoints whose tool is where it shall be."""
        missed = np.abs(error).max(axis=0)
        if self._arm.n >= _PLENTY:
            return q if missed.max() < _MET else Broken.REACH
        if missed[:3].max() >= _MET:
            never = np.abs(self._never @ error[-1, :3]).max(initial=0.0) >= _MET
            return Broken.ABILITY if never else Broken.REACH
        # that it turns a little when it is moved is as it must be; a turn that is wished is not
        turn = float(np.linalg.norm(axis))
        missing = abs(float(error[-1, 3:] @ axis)) / max(turn, _MET)
        return Broken.ABILITY if missing > _ABLE * turn + _MET else q


def _directions_never(arm: Arm) -> FloatArray:
    """Give the directions in base in which an arm can never move its tool, shape (k, 3)."""
    limits = arm.limits
    low, high = np.maximum(limits.q_min, -np.pi), np.minimum(limits.q_max, np.pi)
    q = low + np.random.default_rng(0).random((_SAMPLES, arm.n)) * (high - low)
    columns = np.concatenate(list(arm.jacobian(q)[:, :3]), axis=1)
    U, sigma, _ = np.linalg.svd(columns, full_matrices=True)
    lost: FloatArray = U[:, sigma < _NEVER * max(sigma[0], _NEVER)].T
    return lost


def _solve(J: FloatArray, error: FloatArray, damping: float = _DAMPING) -> FloatArray:
    """Give the shortest step that does away with an error, shape (m, n, 1)."""
    square = J @ J.mT
    square += damping * np.eye(square.shape[-1])
    answer: FloatArray = J.mT @ np.linalg.solve(square, error)
    return answer


def _by_rank(J: FloatArray, error: FloatArray) -> FloatArray:
    """Give the step that does away with the error of the position, then of the orientation.

    Siciliano and Slotine, A general framework for managing multiple tasks in highly redundant
    robotic systems, ICAR 1991, eq. 7, for two tasks.
    """
    linear, turn = J[:, :3], J[:, 3:]
    first = _solve(linear, error[:, :3])
    square = linear @ linear.mT
    square += _DAMPING * np.eye(3)
    free = np.eye(J.shape[-1]) - linear.mT @ np.linalg.solve(square, linear)
    rest = _solve(turn @ free, error[:, 3:] - turn @ first, _SECOND_DAMPING)
    answer: FloatArray = first + free @ rest
    return answer


def _halves(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    return values[:, :3], values[:, 3:]


def _turned(vectors: FloatArray) -> FloatArray:
    """Give the rotations about vectors by their lengths, shape (m, 3, 3)."""
    angle = np.linalg.norm(vectors, axis=1)[:, None, None]
    K = np.zeros((len(vectors), 3, 3))
    x, y, z = vectors.T
    K[:, 0, 1], K[:, 0, 2], K[:, 1, 2] = -z, y, -x
    K -= K.mT
    # Rodrigues' formula
    half = np.sinc(0.5 * angle / np.pi)
    R: FloatArray = np.eye(3) + np.sinc(angle / np.pi) * K + 0.5 * half**2 * K @ K
    return R


def _turn(R_to: FloatArray, R_from: FloatArray) -> FloatArray:
    """Give the vectors about which small turns lead from one orientation to another, (m, 3)."""
    D = R_to @ R_from.mT
    return 0.5 * np.stack(
        (D[:, 2, 1] - D[:, 1, 2], D[:, 0, 2] - D[:, 2, 0], D[:, 1, 0] - D[:, 0, 1]), axis=1
    )
