"""Where a motion comes nearest to the limits of the joints."""

from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray

from .time_law import TimeLaw
from .trajectory import JointTrajectory, Section

_LOOKS = np.linspace(0.0, 1.0, 9)


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitPeak:
    """The moment at which one quantity of one joint is nearest to its limit."""

    joint: str
    """Name of the joint."""
    quantity: str
    """"position", "velocity" or "acceleration"."""
    value: float
    """What it is then, in SI, with its sign."""
    limit: float
    """The limit that it is nearest to, in SI; of velocity and acceleration its magnitude."""
    t: float
    """When, s."""


def peaks(trajectory: JointTrajectory) -> tuple[LimitPeak, ...]:
    """Give for each joint its peaks of position, velocity and acceleration.

    Looked at are all nodes of the time law, from both sides, and seven moments between.
    """
    parts = [
        _look(section, start)
        for start, section in zip(trajectory.starts, trajectory.sections, strict=True)
    ]
    rest = np.zeros((1, trajectory.n))
    parts.append((np.array([trajectory.duration]), trajectory.q_goal[None], rest, rest))
    t, q, qd, qdd = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    limits = trajectory.limits
    found = []
    for j, joint in enumerate(limits.names):
        below, above = q[:, j] - limits.q_min[j], limits.q_max[j] - q[:, j]
        margin = np.minimum(below, above)
        i = int(np.argmin(margin)) if np.isfinite(margin).any() else int(np.argmax(np.abs(q[:, j])))
        bound = limits.q_min[j] if below[i] < above[i] else limits.q_max[j]
        rows = [("position", q, i, bound)]
        for quantity, values, most in (
            ("velocity", qd, limits.qd_max[j]),
            ("acceleration", qdd, limits.qdd_max[j]),
        ):
            rows.append((quantity, values, int(np.argmax(np.abs(values[:, j]))), most))
        found += [
            LimitPeak(
                joint=joint,
                quantity=quantity,
                value=float(v[k, j]),
                limit=float(most),
                t=float(t[k]),
            )
            for quantity, v, k, most in rows
        ]
    return tuple(found)


def _look(section: Section, start: float) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Give times, positions, velocities and accelerations in all cells of a section."""
    law: TimeLaw = section.law
    cells = np.repeat(np.arange(len(law.s) - 1), len(_LOOKS))
    dt = (np.diff(law.t)[:, None] * _LOOKS).ravel()
    push = law.acceleration[cells]
    speed = np.maximum(law.speed[cells] + push * dt, 0.0)
    s = law.s[cells] + dt * (law.speed[cells] + 0.5 * push * dt)
    pieces = section.path.pieces_of(0.5 * (law.s[cells] + law.s[cells + 1]))
    q, slope, bend = section.path.sample(s, pieces)
    qdd = slope * push[:, None] + bend * (speed * speed)[:, None]
    return start + law.t[cells] + dt, q, slope * speed[:, None], qdd
