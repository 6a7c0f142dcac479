"""Goals ahead of their setpoints, by as much as the servos hang behind their goals.

A position servo without an I gain follows late and hangs below its goal under a load: by how much
follows from its gains and its motor (see ``feedforward_drive``). A goal that is ahead by that
angle brings the joint to its setpoint. No register is changed and nothing is written that was not
written before, so it does with every model, in every mode that follows Goal Position.

The servos' own ways were tried beside it on virtual servos (``benchmarks/drivers_feedforward.py``):
a profile of one cycle, by time or by Profile Velocity beside each goal, with the Feedforward 1st
Gain that makes up for the motor's speed. Where the servos are stiff they follow as well; where they
are soft half as well, and the duty changes up to eight times as much from cycle to cycle, since
each profile ends before the next goal or is cut by it. A time-based profile needs an EEPROM bit.

The lead depends on the setpoint alone: it is as continuous as the setpoint's acceleration, and at
rest it is what the weight asks for.
"""

import logging
from collections.abc import Callable, Sequence
from typing import Self, TypeAlias

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray
from splinearm.joints import JointSetpoint
from splinearm.units import DEG

from .bus import ServoBus
from .chain import ServoChain
from .feedforward_drive import JointDrive, column, joint_drives, read_tuning

_log = logging.getLogger(__name__)

Torque: TypeAlias = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
"""What an arm needs to move so: ``torque(q, qd, qdd)``, each of shape (n,), N m. Without friction
and rotors: those are the servos'."""

KINDS = ("off", "velocity", "full")
"""What an arm's file or a job may ask for: nothing, what the speed needs, or all there is."""

MOST = 30.0 * DEG
"""No goal is further ahead than this, rad, besides what the time on the way makes."""

_BITS_PER_BYTE = 10

_SLOW = 0.5 * DEG
"""Speed at which half of the dry friction is made up for, rad/s; at rest none is, so that a joint
that turns back does not jump."""


def cycle_latency(period: float, joints: int, baud: int) -> float:
    """Give how long after its setpoint's time a goal counts on average, s.

    A goal holds for a cycle, so on average half of it goes by; and before it is there, an answer of
    14 bytes a joint (8 more for all) and a write of 5 (14 more) have been on the wire. An adapter's
    own delay comes on top.

    Args:
        period: Time between setpoints, s.
        joints: Number of joints.
        baud: Bits a second on the wire.
    """
    return 0.5 * period + (22 + 19 * joints) * _BITS_PER_BYTE / baud


class ServoFeedforward:
    """The lead of every joint of an arm of servos.

    Args:
        drives: What moves each joint.
        joint_names: The joints, base to tool, for messages.
        torque: What the arm needs to move, from its dynamics; None: only the servos' own lag,
            friction and rotors are made up for.
        latency: How long after its setpoint's time a goal counts on average, s: half a cycle, and
            what reading and writing take before it.

    Raises:
        ValueError: If there is not one drive a joint, or ``latency`` is no time.
    """

    def __init__(
        self,
        drives: Sequence[JointDrive],
        joint_names: Sequence[str],
        torque: Torque | None = None,
        *,
        latency: float = 0.0075,
    ) -> None:
        if len(drives) != len(joint_names):
            raise ValueError(f"drives: want one for each of {len(joint_names)}, got {len(drives)}")
        if not 0.0 <= latency <= 0.1:
            raise ValueError(f"latency: want a time of 0 to 0.1 s, got {latency}")
        self.drives = tuple(drives)
        """What moves each joint."""
        self.latency = latency
        """How long after its setpoint's time a goal counts, s."""
        self._names = tuple(joint_names)
        self._torque = torque
        self._told: set[str] = set()
        known = np.array([not drive.why_not for drive in drives])
        for name, drive in zip(joint_names, drives, strict=True):
            if drive.why_not:
                _log.warning("joint %r is not led: %s", name, drive.why_not)
        stiffness = np.where(known, column(drives, "stiffness"), np.inf)
        weight = known & ~column(drives, "integrates").astype(bool)
        self._late = np.where(known, latency, 0.0)
        self._lag = column(drives, "damping") / stiffness
        self._rotor = column(drives, "inertia") / stiffness
        self._friction = column(drives, "friction") / stiffness
        self._own = column(drives, "inertia"), column(drives, "friction")
        self._give = np.where(weight, 1.0 / stiffness, 0.0)
        self._most = np.where(known, np.minimum(column(drives, "reach") * 2.0, MOST), 0.0)

    @classmethod
    def of(
        cls,
        chain: ServoChain,
        joint_names: Sequence[str],
        torque: Torque | None = None,
        *,
        bus: ServoBus | None = None,
        latency: float = 0.0075,
    ) -> Self:
        """Give the feed-forward of a chain of servos.

        Args:
            chain: The servos and their settings.
            joint_names: The joints, base to tool.
            torque: What the arm needs to move; None: not known.
            bus: Where gains and supply are read that the chain does not say; None: they are taken
                to be the factory's, which in mode 5 the gains are not.
            latency: How long after its setpoint's time a goal counts on average, s.

        Raises:
            BusError: If a servo does not answer.
        """
        held = None if bus is None else read_tuning(bus, chain)
        drives = joint_drives(chain, joint_names, held)
        return cls(drives, joint_names, torque, latency=latency)

    @property
    def most(self) -> FloatArray:
        """How far ahead a goal may be, besides the way of ``latency``, shape (n,), rad.

        Twice the angle at which the servos of a resting joint give all they can, at most ``MOST``.
        """
        return self._most.copy()

    @property
    def knows_weight(self) -> bool:
        """Whether it knows what the arm needs to move, and to rest."""
        return self._torque is not None

    def lead(self, setpoint: JointSetpoint) -> FloatArray:
        """Give by how much each joint's goal shall be ahead of a setpoint, shape (n,), rad.

        A lead above ``most`` is cut there and told once a joint: there the servos cannot keep up.
        """
        late, qdd = self._late, setpoint.qdd
        qd = setpoint.qd + late * qdd
        way = late * (setpoint.qd + qd) * 0.5
        ahead = self._lag * qd + self._rotor * qdd + self._friction * (qd / (np.abs(qd) + _SLOW))
        if self._torque is not None:
            ahead += self._give * self._torque(setpoint.q + way, qd, qdd)
        far = np.abs(ahead) > self._most
        if far.any():
            self._tell(far, ahead)
            ahead = np.clip(ahead, -self._most, self._most)
        return ahead + way

    def needs(self, setpoint: JointSetpoint) -> FloatArray:
        """Give the torque of the servos at each joint that moves as a setpoint says, N m.

        Shape (n,): the arm's and their own rotors' and dry friction's, not what their speed costs.
        """
        inertia, friction = self._own
        qd, qdd = setpoint.qd, setpoint.qdd
        own = inertia * qdd + friction * (qd / (np.abs(qd) + _SLOW))
        return own if self._torque is None else own + self._torque(setpoint.q, qd, qdd)

    def current(self, setpoint: JointSetpoint) -> FloatArray | None:
        """Give no Goal Current: what limits a servo in current-based position mode stays."""
        return None

    def _tell(self, far: npt.NDArray[np.bool_], ahead: FloatArray) -> None:
        """Say once a joint that its lead is cut."""
        for i in np.flatnonzero(far):
            name = self._names[i]
            if name not in self._told:
                self._told.add(name)
                _log.warning(
                    "joint %r: its servos would need a goal %.1f deg ahead, %.1f deg are the most: "
                    "it hangs behind; move slower or carry less",
                    name,
                    abs(ahead[i]) / DEG,
                    self._most[i] / DEG,
                )
