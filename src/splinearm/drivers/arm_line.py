"""What an arm of servos sends and hears in every cycle, and how its registers are read."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray

from .arm_option import known_angles
from .asking import read_all
from .bus import PingReply, ServoBus
from .crew import Crew
from .exchange import Exchange
from .health import HealthWatch, health_limits
from .lead import GoalLead
from .scaling import JointScale
from .stance import Stance


@dataclass(slots=True, eq=False, kw_only=True)
class ArmLine:
    """What moves an arm that was entered."""

    exchange: Exchange
    """What is sent and read in every cycle."""
    health: HealthWatch
    """How the servos fare."""
    joint_index: list[int]
    """For each servo that is sent goals the number of its joint."""
    goal: FloatArray
    """The last setpoint, shape (n,), rad."""

    @classmethod
    def connect(
        cls,
        bus: ServoBus,
        crew: Crew,
        roll: Mapping[int, PingReply],
        scale: JointScale,
        lead: GoalLead,
    ) -> Self:
        """Prepare what is sent and read; best with the torque still off.

        Raises:
            BusError: If a servo does not answer.
        """
        goal = np.full(len(crew.leaders), np.nan)
        at_zero = lead.resting(np.zeros(len(crew.leaders)))
        drives_current = lead.current(at_zero) is not None
        current = "Goal Current" if drives_current else None
        exchange = Exchange(bus, crew, roll, scale, current=current)
        exchange.lay_out()
        limits = health_limits(bus, crew.everyone)
        return cls(
            exchange=exchange,
            health=HealthWatch(bus, crew.everyone, len(crew.leaders), limits),
            joint_index=crew.joint_index,
            goal=goal,
        )

    @property
    def scale(self) -> JointScale:
        """How the registers of the targets are read."""
        return self.exchange.scale


def scale_of(crew: Crew, stance: Stance) -> JointScale:
    """Give how the registers of the targets are read where they stand."""
    servos = [
        replace(servo, zero_ticks=int(zero))
        for servo, zero in zip(crew.targets, stance.zero_ticks, strict=True)
    ]
    return replace(JointScale.of(servos), ticks_min=stance.ticks_min, ticks_max=stance.ticks_max)


def whereabouts(
    bus: ServoBus,
    crew: Crew,
    scale: JointScale,
    near: ArrayInput | None,
    counting: Collection[int],
) -> FloatArray:
    """Give where the joints are, as far as it is known, shape (n,), rad; else NaN.

    Args:
        bus: The bus.
        crew: The servos.
        scale: How the registers of the targets were read so far.
        near: What the caller knows.
        counting: Ids of servos that have not lost their turns.
    """
    n = len(crew.leaders)
    places = read_all(bus, crew.leaders, "Present Position")
    q = scale.first(n).to_q([places[servo.servo_id] for servo in crew.leaders])
    counts = np.array([servo.servo_id in counting for servo in crew.leaders])
    return np.where(counts, q, known_angles(near, n))
