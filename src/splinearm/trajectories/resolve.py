"""From a way of the tool to a way of the joints that carries it there."""

from dataclasses import dataclass, replace

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.curves.basis import IndexArray
from splinearm.curves.bspline import BSpline
from splinearm.curves.hermite import Jet, quintic_pieces, quintic_spline
from splinearm.curves.sampler import Sampler
from splinearm.kinematics import forward
from splinearm.kinematics.arm import Arm

from . import task
from .joint_path import JointPath
from .path import TURN_ARM, CartesianPath, ToolState
from .reach import PathLabels, refuse_jump, refuse_limit, refuse_unreachable

_NODE_SHARE = 0.05
"""Share of the tolerance that the nodes themselves may be off."""

_BETWEEN_SHARE = 0.5
"""Share of the tolerance that the way between nodes may be off where it is looked at."""

_LOOKS = np.array([0.06, 0.18, 0.32, 0.5, 0.68, 0.82, 0.94])
"""Where between two nodes the tool is looked at."""

_CAREFUL = 1e-4
"""How far, in rad, a prediction along the path may be off before steps get shorter."""

_JUMP = 0.05
"""How far, in rad, a correction may carry a joint and still be on the same branch."""

_STRAY = 0.3
"""How far, in rad, joints may be from where they are nearly known to be."""

_SHORTEST = 1e-7
"""Shortest step along a path, as a share of its length."""

_FINE = 1001
"""How often a piece that may leave the joint limits is looked at."""

_MOST_NODES = 20_000

_MOST_EACH = 32
"""More nodes than that from one given node to the next are too many as well."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerance:
    """How far the tool may be off the wanted way."""

    position: float
    """Distance, m."""

    @property
    def orientation(self) -> float:
        """Angle, rad: what moves a point 0.1 m from the tool by the same distance."""
        return self.position / TURN_ARM


@dataclass(frozen=True, slots=True, eq=False)
class _Sampled:
    """A B-spline that is looked at often."""

    curve: BSpline
    sampler: Sampler

    @property
    def domain(self) -> tuple[float, float]:
        return self.curve.domain

    @property
    def breaks(self) -> FloatArray:
        return self.curve.breaks

    def at(self, u: ArrayInput, derivative: int = 0) -> FloatArray:
        return self.sampler.sample(u, derivative)[..., derivative, :]


@dataclass(frozen=True, slots=True, eq=False)
class Nodes:
    """Joint positions on a path."""

    s: FloatArray
    """Where, rising, shape (m,)."""
    q: FloatArray
    """Joint positions there, shape (m, n)."""


def resolve(
    arm: Arm, path: CartesianPath, q_start: FloatArray, tolerance: Tolerance, labels: PathLabels
) -> JointPath:
    """Give the way of the joints, C2 and quintic, that carries the tool along a path.

    It begins at ``q_start`` and stays on its branch: joints never jump. Where the arm has joints to
    spare, each moves as little as it can. Between its nodes the tool is looked at, and nodes are
    added until it is within half the tolerance everywhere there.

    Args:
        arm: The arm.
        path: Where the tool shall go.
        q_start: Joint positions that bring the tool to the path's start, shape (n,).
        tolerance: How far the tool may be off.
        labels: What messages call the places of the path.

    Raises:
        UnreachableError: If the arm cannot follow, or only beyond a joint limit, or only by
            jumping to another branch.
    """
    forward.load()
    path = _quick(path)
    nodes = _track(arm, path, q_start, tolerance, labels)
    s, jet = _refine(arm, path, nodes, tolerance, labels)
    joints = JointPath(quintic_spline(s, jet))
    _check_limits(arm, path, joints, labels)
    return joints


def resolve_near(
    arm: Arm, path: CartesianPath, near: Nodes, tolerance: Tolerance, labels: PathLabels
) -> JointPath:
    """Give the way of the joints as ``resolve`` does, where it is nearly known beforehand.

    Nothing is walked along: all places are corrected at once, which is quick on long paths.

    Args:
        arm: The arm.
        path: Where the tool shall go.
        near: About where the joints are on the path, from its start to its end, so densely that
            none is nearer to another branch.
        tolerance: How far the tool may be off.
        labels: What messages call the places of the path.

    Raises:
        UnreachableError: If the arm cannot follow near there.
    """
    forward.load()
    path = _quick(path)
    found = task.correct(arm, near.q, path.state(near.s))
    lost = (found.position_error > _NODE_SHARE * tolerance.position) | (
        found.orientation_error > _NODE_SHARE * tolerance.orientation
    )
    lost |= np.abs(found.q - near.q).max(axis=1) > _STRAY
    if lost.any():
        k = int(np.argmax(lost))
        raise refuse_unreachable(arm, path, float(near.s[k]), near.q[k], labels)
    s, jet = _refine(arm, path, Nodes(near.s, found.q), tolerance, labels)
    joints = JointPath(quintic_spline(s, jet))
    _check_limits(arm, path, joints, labels)
    return joints


def _quick(path: CartesianPath) -> CartesianPath:
    """Give the same path, quicker to look at."""
    curve = path.position
    if not isinstance(curve, BSpline):
        return path
    return replace(path, position=_Sampled(curve, curve.sampler()))


def _track(
    arm: Arm, path: CartesianPath, q_start: FloatArray, tolerance: Tolerance, labels: PathLabels
) -> Nodes:
    """Walk along the path in steps as long as predictions stay good."""
    breaks = path.breaks
    length = breaks[-1] - breaks[0]
    here = path.state(breaks[:1])
    first = task.correct(arm, q_start[None], here)
    s_nodes, q_nodes = [float(breaks[0])], [first.q[0]]
    if not _is_reached(first, tolerance) or np.abs(first.q[0] - q_start).max() > _JUMP:
        raise refuse_unreachable(arm, path, s_nodes[0], q_start, labels)
    for end in breaks[1:]:
        step = 0.25 * (end - s_nodes[-1])
        while s_nodes[-1] < end:
            s, q = s_nodes[-1], q_nodes[-1]
            left = end - s
            # the last step of a piece goes to its end, the one before leaves no crumb
            to = end if step >= 0.999 * left else s + min(step, 0.5 * left)
            states = path.state(np.array([s, 0.5 * (s + to), to]))
            predicted = _predict(arm, states, to - s, q)
            reached = task.correct(arm, predicted, _at(states, 2))
            off = float(np.abs(reached.q - predicted).max())
            if not np.isfinite(off) or off > _JUMP or not _is_reached(reached, tolerance):
                step = 0.3 * (to - s)
                if step < _SHORTEST * length:
                    _check_nodes(arm, path, np.array(s_nodes), np.array(q_nodes), labels)
                    raise refuse_unreachable(arm, path, to, q, labels)
                continue
            if off > _CAREFUL and (to - s) > 1e-3 * length:
                step = (to - s) * max(0.3, 0.8 * (_CAREFUL / off) ** 0.2)
                continue
            s_nodes.append(float(to))
            q_nodes.append(reached.q[0])
            step = (to - s) * min(2.0, 0.8 * (_CAREFUL / max(off, 1e-12)) ** 0.2)
    return Nodes(np.array(s_nodes), np.array(q_nodes))


def _predict(arm: Arm, states: ToolState, h: float, q: FloatArray) -> FloatArray:
    """Give where the joints are a step h on if they follow the tool's velocity, shape (1, n).

    The states are those at the beginning, the middle and the end of the step.
    """
    # Runge-Kutta of fourth order on q' = pinv(J(q)) v(s)
    start, middle, end = (_at(states, i) for i in range(3))
    k1 = task.slopes(arm, q[None], start)
    k2 = task.slopes(arm, q + 0.5 * h * k1, middle)
    k3 = task.slopes(arm, q + 0.5 * h * k2, middle)
    k4 = task.slopes(arm, q + h * k3, end)
    predicted: FloatArray = q + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return predicted


def _at(states: ToolState, i: int) -> ToolState:
    """Give one of some states."""
    one = slice(i, i + 1)
    quat = None if states.quat is None else states.quat[one]
    return ToolState(states.p[one], quat, states.slope[one], states.bend[one])


def _is_reached(found: task.Corrected, tolerance: Tolerance) -> bool:
    return bool(
        found.position_error.max() <= _NODE_SHARE * tolerance.position
        and found.orientation_error.max() <= _NODE_SHARE * tolerance.orientation
    )


def _refine(
    arm: Arm, path: CartesianPath, nodes: Nodes, tolerance: Tolerance, labels: PathLabels
) -> tuple[FloatArray, Jet]:
    """Add nodes until the tool is near enough to the path between them."""
    s, q = nodes.s, nodes.q
    most = max(_MOST_NODES, _MOST_EACH * len(s))
    slope, bend = task.slopes_and_bends(arm, q, path.state(s))
    open_pieces = np.ones(len(s) - 1, dtype=bool)
    while True:
        k = np.flatnonzero(open_pieces)
        off = _worst_between(arm, path, s, (q, slope, bend), k)
        bad = k[
            (off[0] > _BETWEEN_SHARE * tolerance.position)
            | (off[1] > _BETWEEN_SHARE * tolerance.orientation)
        ]
        if bad.size == 0:
            return s, (q, slope, bend)
        shortest = float((s[bad + 1] - s[bad]).min())
        if len(s) + bad.size > most or shortest < _SHORTEST * (s[-1] - s[0]):
            steepest = int(np.argmax(np.abs(slope).max(axis=1)))
            raise refuse_jump(arm, path, float(s[steepest]), q[steepest], labels)
        middle = 0.5 * (s[bad] + s[bad + 1])
        guess = _between(s, (q, slope, bend), bad, np.array([0.5]))[:, 0]
        wanted = path.state(middle)
        new_q = task.correct(arm, guess, wanted).q
        new_slope, new_bend = task.slopes_and_bends(arm, new_q, wanted)
        s, q = np.insert(s, bad + 1, middle), np.insert(q, bad + 1, new_q, axis=0)
        slope = np.insert(slope, bad + 1, new_slope, axis=0)
        bend = np.insert(bend, bad + 1, new_bend, axis=0)
        halves = np.zeros(len(s) - 1, dtype=bool)
        behind = bad + np.arange(bad.size)
        halves[behind] = halves[behind + 1] = True
        open_pieces = halves


def _between(s: FloatArray, jet: Jet, k: IndexArray, shares: FloatArray) -> FloatArray:
    """Give joint positions at shares of the pieces k, shape (len(k), len(shares), n)."""
    h = s[k + 1] - s[k]
    starts: Jet = (jet[0][k], jet[1][k], jet[2][k])
    ends: Jet = (jet[0][k + 1], jet[1][k + 1], jet[2][k + 1])
    pieces = quintic_pieces(h, starts, ends)
    powers = (h[:, None] * shares)[:, :, None] ** np.arange(6)
    between: FloatArray = np.einsum("ksj,kjn->ksn", powers, pieces)
    return between


def _worst_between(
    arm: Arm, path: CartesianPath, s: FloatArray, jet: Jet, k: IndexArray
) -> tuple[FloatArray, FloatArray]:
    """Give the largest misses of position and orientation on the pieces k, each (len(k),)."""
    q = _between(s, jet, k, _LOOKS)
    at = s[k, None] + (s[k + 1] - s[k])[:, None] * _LOOKS
    miss = task.misses(arm, q.reshape(-1, arm.n), path.state(at.ravel()))
    position, orientation = task.errors(miss)
    shape = (len(k), len(_LOOKS))
    return position.reshape(shape).max(axis=1), orientation.reshape(shape).max(axis=1)


def _check_limits(arm: Arm, path: CartesianPath, joints: JointPath, labels: PathLabels) -> None:
    """Refuse a way that leaves the limits anywhere."""
    ends, hulls = joints.curve.bezier()
    limits = arm.limits
    near = ((hulls < limits.q_min) | (hulls > limits.q_max)).any(axis=(1, 2))
    # a piece lies within the hull of its Bezier points: only where that leaves the limits
    starts, lengths = ends[:-1][near, None], np.diff(ends)[near, None]
    s = (starts + lengths * np.linspace(0.0, 1.0, _FINE)).ravel()
    if s.size:
        _check_nodes(arm, path, s, joints.sample(s)[0], labels)


def _check_nodes(
    arm: Arm, path: CartesianPath, s: FloatArray, q: FloatArray, labels: PathLabels
) -> None:
    """Refuse joint positions beyond the limits."""
    limits = arm.limits
    excess = np.maximum(limits.q_min - q, q - limits.q_max)
    if (excess > 1e-9).any():
        raise refuse_limit(arm, path, s, q, labels)
