"""The quickest x(s) under what limits allow between neighbours.

x is the square of ds/dt at nodes. Standing still is always allowed and the allowed pairs of a cell
are convex, so every profile may be slowed down: from below any allowed one there is a way on.
"""

from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import TrajectoryError
from splinearm.joints import JointLimits

from .joint_path import JointPath
from .sampled_row import Lines
from .scratch import scratch
from .timing_entry import kernels

_SLACK = 1e-11
"""By what share rounding may carry an acceleration over its limit."""


class Frame(NamedTuple):
    """What joint velocities and accelerations allow on a grid."""

    both: FloatArray
    """Lines of each cell, shape (cells, 2, k); the next frame of this thread overwrites it."""
    cap: FloatArray
    """Largest x of each node, shape (cells + 1,)."""


def frame(path: JointPath, limits: JointLimits, s: FloatArray) -> Frame:
    """Give what joints allow on the cells between nodes s; no cell reaches over a piece's end."""
    m = len(s)
    cap = np.full(m, np.inf)
    both = scratch("lines", m - 1, 2, path.n * path.curve.degree)
    most = np.stack((limits.qd_max, limits.qdd_max))
    kernels().joint_rows(path.breaks, path.coefficients, s, most, cap, both)
    return Frame(both, cap)


def fastest(
    known: Frame, s: FloatArray, ends: tuple[float, float], more: Lines | None = None
) -> FloatArray:
    """Give the largest x at nodes s, shape (m,).

    Args:
        known: What the joints may do.
        s: Nodes, rising.
        ends: ds/dt at the first and the last node.
        more: What else is to be kept.

    Raises:
        TrajectoryError: If no profile begins and ends at such speeds.
    """
    compiled = kernels()
    both, cap = known
    above = below = np.empty((len(s) - 1, 2, 0))
    if more is not None:
        above, below, alone = more
        np.minimum(cap[:-1], alone, out=cap[:-1])
    x, squares = np.empty(len(s)), np.square(ends)
    answer = compiled.fastest(both, above, below, cap, squares, x)
    if answer:
        _refuse(answer, ends, x)
    over = compiled.most_used(both, above, below, x)
    if over > 1.0 + _SLACK:
        # rounding, where lines are steep because joints hardly move
        inner = x / over
        x[1:-1] = inner[1:-1]
    return x


def lowest_behind(a: FloatArray, b: FloatArray, x: float) -> float:
    """Give the least x[i + 1], 0 or more, that the rows of one cell allow behind x[i] = x.

    It is told by the rows that ask for more; that others allow it is for the caller to know.
    """
    down = b < 0.0
    return max(0.0, float(((1.0 - a[down] * x) / b[down]).max(initial=0.0)))


def _refuse(answer: int, ends: tuple[float, float], x: FloatArray) -> None:
    """Say why there is no profile; see `reachability_kernel`."""
    facts = {
        1: f"the path cannot begin at {ends[0]:.6g} /s: within its limits it can begin at up to "
        f"{np.sqrt(x[0]):.6g} /s",
        2: f"the path cannot end at {ends[1]:.6g} /s: within its limits it reaches "
        f"{np.sqrt(x[-1]):.6g} /s",
    }
    raise TrajectoryError(facts.get(answer, "no speed is possible along the path"))
