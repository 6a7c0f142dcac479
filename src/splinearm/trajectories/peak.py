"""Where a motion comes nearest to the limits of the joints, and which limit binds when."""

from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointLimits

from .trajectory import JointTrajectory

_LOOKS = np.linspace(0.0, 1.0 - 1e-9, 9)
"""Where between two nodes a motion is looked at: at the first, and just before the second."""

_BINDS = 0.95
"""From this share of its limit on a quantity is what holds the motion back between two nodes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitPeak:
    """The moment at which one quantity of one joint is nearest to its limit."""

    joint: str
    """Name of the joint."""
    quantity: str
    """"position", "velocity", "acceleration" or "jerk"."""
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
    """"velocity", "acceleration" or "jerk" of the joint, or "tool speed"; None: nothing that is
    looked at is at its limit, as in a rest."""
    share: float
    """Largest share of a limit that is used in this time."""


class _Looks(NamedTuple):
    t: FloatArray
    q: FloatArray
    rates: dict[str, tuple[FloatArray, FloatArray]]
    """Values, shape (m, n), and limits, shape (n,), by quantity."""
    tool: FloatArray
    """How much of the tool's highest speed is used, shape (m,)."""


def peaks(trajectory: JointTrajectory) -> tuple[LimitPeak, ...]:
    """Give for each joint its peaks of position, velocity, acceleration and, if limited, jerk.

    Looked at are all nodes of the time law, from both sides, and seven moments between.
    """
    looks, limits = _look(trajectory), trajectory.limits
    found = []
    for j, joint in enumerate(limits.names):
        i, bound = _nearest_bound(looks.q[:, j], limits, j)
        rows = [("position", looks.q, i, bound)]
        for quantity, (values, most) in looks.rates.items():
            rows.append((quantity, values, int(np.argmax(np.abs(values[:, j]))), float(most[j])))
        found += [
            LimitPeak(
                joint=joint, quantity=quantity, value=float(v[k, j]), limit=m, t=float(looks.t[k])
            )
            for quantity, v, k, m in rows
        ]
    return tuple(found)


def bindings(trajectory: JointTrajectory) -> tuple[Binding, ...]:
    """Give which limit holds the motion back when, from its start to its end."""
    looks, names = _look(trajectory), trajectory.limits.names
    if trajectory.duration <= 0.0:
        return ()
    named: list[tuple[str | None, str | None]] = [
        (name, quantity) for quantity in looks.rates for name in names
    ]
    named += [(None, "tool speed"), (None, None)]
    shares = [np.abs(v) / most for v, most in looks.rates.values()]
    used = np.column_stack((*shares, looks.tool))
    inside = used[:-1].reshape(-1, len(_LOOKS), used.shape[1])
    cells = inside.max(axis=1)
    # what is at its limit all the way, not what has just come to it
    hardest = inside.mean(axis=1).argmax(axis=1)
    binds = np.take_along_axis(cells, hardest[:, None], axis=1)[:, 0] >= _BINDS
    which = np.where(binds, hardest, -1)
    nodes = np.append(looks.t[: -1 : len(_LOOKS)], trajectory.duration)
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


def _look(trajectory: JointTrajectory) -> _Looks:
    """Give what the joints do at all nodes and between them."""
    nodes, limits = trajectory.nodes(), trajectory.limits
    t = (nodes[:-1, None] + np.diff(nodes)[:, None] * _LOOKS).ravel()
    t = np.append(t, trajectory.duration)
    q, qd, qdd = trajectory.sample(t)
    rates = {"velocity": (qd, limits.qd_max), "acceleration": (qdd, limits.qdd_max)}
    if limits.qddd_max is not None:
        rates["jerk"] = (trajectory.jerk(t), limits.qddd_max)
    return _Looks(t, q, rates, trajectory.tool_share(t))


def _nearest_bound(q: FloatArray, limits: JointLimits, j: int) -> tuple[int, float]:
    """Give when a joint is nearest to a limit of position, and that limit."""
    below, above = q - limits.q_min[j], limits.q_max[j] - q
    margin = np.minimum(below, above)
    i = int(np.argmin(margin)) if np.isfinite(margin).any() else int(np.argmax(np.abs(q)))
    return i, float(limits.q_min[j] if below[i] < above[i] else limits.q_max[j])
