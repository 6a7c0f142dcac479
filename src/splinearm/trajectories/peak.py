"""Where a motion comes nearest to the limits of the joints, and which limit binds when."""

from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointLimits

from .limit import MotionLimits
from .limit_share import Rates, joint_rates, tool_shares
from .trajectory import JointTrajectory

_LOOKS = np.linspace(1e-9, 1.0 - 1e-9, 9)
"""Where between two nodes a motion is looked at: just behind the first, just before the second, and
between. At a node itself rounding may take the path from one side and its law from the other."""

_MOMENT = 1e-9
"""Nodes that are nearer to each other are one, s: a node of the law where two parts of the path
meet."""

_BINDS = 0.95
"""From this share of its limit on a quantity is what holds the motion back between two nodes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitPeak:
    """The moment at which one quantity of one joint is nearest to its limit."""

    joint: str
    """Name of the joint."""
    quantity: str
    """"position", "velocity", "acceleration", "jerk" or "torque"."""
    value: float
    """What it is then, in SI, with its sign."""
    limit: float
    """The limit that it is nearest to, in SI; but for positions its magnitude."""
    t: float
    """When, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Binding:
    """A time during which one limit, or none, holds a motion back."""

    start: float
    """From when, s."""
    end: float
    """Until when, s."""
    joint: str | None
    """The joint that is at its limit; None: the tool, or nothing, is."""
    quantity: str | None
    """"velocity", "acceleration", "jerk" or "torque" of the joint, or "tool speed", "tool
    acceleration", "tool turn rate" or "tool turn acceleration"; None: nothing that is limited is at
    its limit, as in a rest."""
    share: float
    """Largest share of a limit that is used in this time."""


class _Looks(NamedTuple):
    nodes: FloatArray
    """Between which the motion is smooth, shape (k,), s."""
    t: FloatArray
    """When, shape (m,), s: behind and before each node, and between them."""
    joints: Rates
    tool: dict[str, FloatArray]
    """How much of each limit of the tool is used, shape (m,), by quantity."""


def peaks(trajectory: JointTrajectory, limits: MotionLimits | None = None) -> tuple[LimitPeak, ...]:
    """Give for each joint its peaks of position and of all its rates that are limited.

    Looked at are all nodes of the time law, from both sides, and seven moments between.

    Args:
        trajectory: The motion.
        limits: What limits it; None: the limits of its joints.
    """
    every = MotionLimits(joints=trajectory.limits) if limits is None else limits
    looks, joints = _look(trajectory, every), every.joints
    q, _, _ = trajectory.sample(looks.t)
    found = []
    for j, joint in enumerate(joints.names):
        i, bound = _nearest_bound(q[:, j], joints, j)
        rows = [("position", q, i, bound)]
        for quantity, (values, most) in looks.joints.items():
            i = int(np.argmax(np.abs(values[:, j]) / most[:, j]))
            rows.append((quantity, values, i, float(most[i, j])))
        found += [
            LimitPeak(
                joint=joint, quantity=quantity, value=float(v[k, j]), limit=m, t=float(looks.t[k])
            )
            for quantity, v, k, m in rows
        ]
    return tuple(found)


def bindings(
    trajectory: JointTrajectory, limits: MotionLimits | None = None
) -> tuple[Binding, ...]:
    """Give which limit holds the motion back when, from its start to its end.

    Args:
        trajectory: The motion.
        limits: What limits it; None: the limits of its joints, and the tool's speed where the
            motion knows of one.
    """
    if trajectory.duration <= 0.0:
        return ()
    every = MotionLimits(joints=trajectory.limits) if limits is None else limits
    looks, names = _look(trajectory, every), every.joints.names
    named: list[tuple[str | None, str | None]] = [
        (name, quantity) for quantity in looks.joints for name in names
    ]
    named += [*((None, quantity) for quantity in looks.tool), (None, None)]
    shares = [np.abs(v) / most for v, most in looks.joints.values()]
    used = np.column_stack((*shares, *looks.tool.values()))
    inside = used[:-1].reshape(-1, len(_LOOKS), used.shape[1])
    cells = inside.max(axis=1)
    # what is at its limit all the way, not what has just come to it
    hardest = inside.mean(axis=1).argmax(axis=1)
    binds = np.take_along_axis(cells, hardest[:, None], axis=1)[:, 0] >= _BINDS
    which = np.where(binds, hardest, -1)
    nodes = looks.nodes
    found = []
    for column, group in groupby(range(len(cells)), key=which.tolist().__getitem__):
        some = list(group)
        joint, quantity = named[column]
        found.append(
            Binding(
                start=float(nodes[some[0]]),
                end=float(nodes[some[-1] + 1]),
                joint=joint,
                quantity=quantity,
                share=float(cells[some].max()),
            )
        )
    return tuple(found)


def _look(trajectory: JointTrajectory, limits: MotionLimits) -> _Looks:
    """Give what joints and tool do at all nodes and between them."""
    nodes = _apart(trajectory.nodes())
    t = (nodes[:-1, None] + np.diff(nodes)[:, None] * _LOOKS).ravel()
    t = np.append(t, trajectory.duration)
    return _Looks(nodes, t, joint_rates(trajectory, limits, t), tool_shares(trajectory, limits, t))


def _apart(nodes: FloatArray) -> FloatArray:
    """Give nodes of which no two are one, with the first and the last."""
    kept = np.append(True, np.diff(nodes) > _MOMENT)
    kept[-1] = True
    apart: FloatArray = nodes[kept]
    return apart


def _nearest_bound(q: FloatArray, limits: JointLimits, j: int) -> tuple[int, float]:
    """Give when a joint is nearest to a limit of position, and that limit."""
    below, above = q - limits.q_min[j], limits.q_max[j] - q
    margin = np.minimum(below, above)
    i = int(np.argmin(margin)) if np.isfinite(margin).any() else int(np.argmax(np.abs(q)))
    return i, float(limits.q_min[j] if below[i] < above[i] else limits.q_max[j])
