"""How well a motion was carried out, in the numbers a person asks for."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.kinematics import quaternion
from splinearm.kinematics.arm import Arm
from splinearm.trajectories.plan import Plan

from .cycle import Cycle
from .record import Recorder
from .servo_count import ServoCount


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Root mean square and largest of a series of errors, in SI."""

    rms: float
    """Root of the mean square."""
    worst: float
    """Largest magnitude."""
    p99: float = float("nan")
    """Magnitude that one in a hundred exceeds."""

    @classmethod
    def of(cls, errors: FloatArray) -> "Spread":
        """Give the spread of errors of any shape; NaN of none."""
        if errors.size == 0:
            return cls(rms=float("nan"), worst=float("nan"))
        size = np.abs(errors)
        return cls(
            rms=float(np.sqrt(np.mean(errors**2))),
            worst=float(size.max()),
            p99=float(np.percentile(size, 99)),
        )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class TrackingReport:
    """Errors of a motion that was carried out."""

    joints: tuple[tuple[str, Spread], ...]
    """For each joint, measured less wanted at the same time, rad or m."""
    tool_lag: Spread
    """Distance of the tool from where it was wanted at the same time, m."""
    tool_turn: Spread
    """Angle of the tool from how it was wanted at the same time, rad."""
    path_commanded: Spread
    """Distance of the commanded tool from the wanted curve, m."""
    path_measured: Spread
    """Distance of the measured tool from the wanted curve, m."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopReport:
    """How well the loop kept its time."""

    rate: float
    """Cycles per second that were asked for, Hz."""
    cycles: int
    """Cycles that were carried out."""
    missed: int
    """Cycles that were skipped because their time had passed."""
    unanswered: int
    """Cycles in which not every joint answered."""
    lateness: Spread
    """By how much cycles began late, s."""
    busy: Spread
    """How long a cycle's work took, s."""
    servos: tuple[ServoCount, ...] = ()
    """How each servo answered; none for an arm without servos."""


def report_tracking(arm: Arm, plan: Plan, recorder: Recorder) -> TrackingReport:
    """Give the errors of the cycles that measured.

    Args:
        arm: The arm that moved.
        plan: The motion it was to make.
        recorder: What it did; only cycles of that motion.
    """
    _, wanted, measured, _ = recorder.measured()
    T_wanted, T_measured = arm.fk(wanted), arm.fk(measured)
    p_wanted, p_measured = T_wanted[:, :3, 3], T_measured[:, :3, 3]
    turn = quaternion.angle_between(
        quaternion.from_matrix(T_wanted[:, :3, :3]), quaternion.from_matrix(T_measured[:, :3, :3])
    )
    return TrackingReport(
        joints=tuple(
            (name, Spread.of(measured[:, i] - wanted[:, i]))
            for i, name in enumerate(arm.joint_names)
        ),
        tool_lag=Spread.of(np.linalg.norm(p_measured - p_wanted, axis=-1)),
        tool_turn=Spread.of(turn),
        path_commanded=Spread.of(plan.tool_path.distance(p_wanted)),
        path_measured=Spread.of(plan.tool_path.distance(p_measured)),
    )


def report_loop(
    cycles: Sequence[Cycle], period: float, servos: tuple[ServoCount, ...] = ()
) -> LoopReport:
    """Give how well the loop kept its time.

    Args:
        cycles: The cycles of one motion.
        period: Time between cycles that was asked for, s.
        servos: How each servo answered in it.
    """
    missed = cycles[0].index if cycles else 0
    missed += sum((b.index - a.index) // b.stride - 1 for a, b in pairwise(cycles))
    return LoopReport(
        rate=1.0 / period,
        cycles=len(cycles),
        missed=missed,
        unanswered=sum(cycle.state is None for cycle in cycles),
        lateness=Spread.of(np.array([cycle.lateness for cycle in cycles])),
        busy=Spread.of(np.array([cycle.busy for cycle in cycles])),
        servos=servos,
    )
