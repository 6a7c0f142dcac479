"""Torques as currents: what a joint's servos pull, and how hard an arm may push.

A servo's torque is its current times its maker's stall torque over stall current. In current-based
position mode (5) Goal Current is the most that the position controller may ask for: an arm whose
limit follows what its motion needs moves as before, but pushes no harder than a little more when
something is in its way.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointSetpoint

from .chain import ServoChain, ServoSpec
from .feedforward import ServoFeedforward
from .feedforward_drive import CURRENT_POSITION_MODE, torque_per_amp
from .scaling import operating_mode


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class JointCurrent:
    """How the servos at one joint turn current into torque; all of them get the same current."""

    torque_per_amp: float
    """Torque of the joint if each of its servos draws an ampere, N m/A."""
    most: float
    """Highest current that each of them allows, A."""
    limits: bool
    """Whether Goal Current limits a position controller (mode 5)."""

    @property
    def torque_max(self) -> float:
        """Torque at the highest current, N m."""
        return self.torque_per_amp * self.most


def joint_current(servos: Sequence[ServoSpec]) -> JointCurrent | None:
    """Give how the servos at one joint turn current into torque; None if one measures none."""
    models = [servo.servo_model for servo in servos]
    if not all(model.has_current and model.stall for model in models):
        return None
    return JointCurrent(
        torque_per_amp=sum(torque_per_amp(model) for model in models),
        most=min(_current_limit(servo) for servo in servos),
        limits=all(operating_mode(servo) == CURRENT_POSITION_MODE for servo in servos),
    )


def joint_currents(
    chain: ServoChain, joint_names: Sequence[str]
) -> tuple[JointCurrent | None, ...]:
    """Give the current of each joint; None where a servo measures none.

    Raises:
        ValueError: If no servo leads a joint.
    """
    chain.leaders_of(joint_names)
    return tuple(
        joint_current([servo for servo in chain.servos if servo.joint == name])
        for name in joint_names
    )


def _current_limit(servo: ServoSpec) -> float:
    """Give the Current Limit of a servo, A."""
    register = servo.servo_model.table["Current Limit"]
    initial = register.initial if isinstance(register.initial, int) else 0
    return servo.settings.get("Current Limit", initial) * (register.scale or 0.0) * 1e-3


class ForceLimited:
    """A feed-forward under which joints in mode 5 push little harder than their motion needs.

    Args:
        ahead: What leads the goals; it must know the arm's torques.
        currents: How each joint turns current into torque, from ``joint_currents``.
        spare: Torque of each joint beyond what its motion needs, shape (n,) or one for all, N m. It
            must cover what the dynamics do not know: friction, and what the arm carries unasked.

    Raises:
        ValueError: If no joint is in mode 5, the torques are not known, or a number does not fit.
    """

    def __init__(
        self,
        ahead: ServoFeedforward,
        currents: Sequence[JointCurrent | None],
        spare: float | FloatArray = 0.5,
    ) -> None:
        n = len(ahead.drives)
        limited = np.array([each is not None and each.limits for each in currents])
        if len(currents) != n or not limited.any():
            raise ValueError("currents: want one a joint, and one at least in mode 5")
        if not ahead.knows_weight:
            raise ValueError("ahead: want one that knows the arm's torques, got none")
        if not (np.broadcast_to(spare, (n,)) > 0.0).all():
            raise ValueError(f"spare: want torques above zero, got {spare}")
        self.ahead = ahead
        """What leads the goals."""
        self._spare = np.array(np.broadcast_to(spare, (n,)), dtype=np.float64)
        self._per_amp = np.array([each.torque_per_amp if each else 1.0 for each in currents])
        # where Goal Current limits nothing it stays at the highest
        self._highest = np.array([each.most if each else 0.0 for each in currents])
        self._lowest = np.where(limited, 0.0, self._highest)

    def lead(self, setpoint: JointSetpoint) -> FloatArray:
        """Give by how much each joint's goal shall be ahead of a setpoint, shape (n,), rad."""
        return self.ahead.lead(setpoint)

    def current(self, setpoint: JointSetpoint) -> FloatArray:
        """Give the most that each joint's servos may draw, shape (n,), A, within their limits."""
        wanted = (np.abs(self.ahead.needs(setpoint)) + self._spare) / self._per_amp
        most: FloatArray = np.clip(wanted, self._lowest, self._highest)
        return most
