"""Where a hand paused: the times in which an arm stood, cut out of the time in which it moved."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline
from splinearm.errors import StillError
from splinearm.joints import JointKind
from splinearm.kinematics.arm import Arm
from splinearm.units import DEG

from .noise import Flags
from .recording import Ruler

_CALM = 0.06
"""Speeds are taken of positions averaged over so long (Gauss' sigma), s: a hand trembles."""

_REACH = 3.0
"""So many sigmas are averaged over."""

_FINEST = 0.1
"""Speeds are taken no closer than this share of the mean time between samples, however many of
them came at once."""

_OF_TOLERANCE = 0.9
"""So near to one place, as a share of the tolerance, a rest is ..."""

_AT_ITS_ENDS = 0.3
"""... and so near in its first and last moments, in which the average is already fast."""

_TWITCH = 0.15
"""Rests at one place with no more than that between them are one, s."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class RestRule:
    """When an arm counts as resting."""

    time: float = 0.3
    """For longer than so long, s."""
    tool_speed: float = 3e-3
    """The tool is slower than that, m/s ..."""
    joint_speed: float = 1.5 * DEG
    """... and each joint than that, rad/s (of those that slide, the tool's speed)."""

    def __post_init__(self) -> None:
        for name in ("time", "tool_speed", "joint_speed"):
            value = getattr(self, name)
            if not 0.0 < value < np.inf:
                raise ValueError(f"{name}: want a number above 0, got {value}")


class Moving(NamedTuple):
    """When an arm moved."""

    first: int
    """The sample with which it begins."""
    last: int
    """The sample with which it ends."""
    rests: tuple[tuple[int, int], ...]
    """First and last sample of each rest between, in order."""
    ends: tuple[int, int]
    """From where and up to where the arm rests at the first and at the last place."""

    def times(self, t: FloatArray) -> FloatArray:
        """Give the time in which the arm moved until each sample from ``ends`` to ``ends``, s.

        In a rest it stays as it is.
        """
        u: FloatArray = t[self.ends[0] : self.ends[1] + 1] - t[self.first]
        shift = self.ends[0]
        for begin, end in self.rests:
            length = t[end] - t[begin]
            u[begin - shift : end - shift + 1] = u[begin - shift]
            u[end - shift + 1 :] -= length
        u[: self.first - shift] = 0.0
        u[self.last - shift :] = u[self.last - shift]
        return u


def find_moving(
    t: FloatArray, q: FloatArray, curve: BSpline, ruler: Ruler, arm: Arm, rule: RestRule
) -> Moving:
    """Find when an arm moved and where it rested.

    Args:
        t: When samples were taken, shape (k,), s.
        q: The samples; of those that are wrong what the curve says, shape (k, n).
        curve: The samples without their noise.
        ruler: What is near.
        arm: The arm.
        rule: What a rest is.

    Raises:
        StillError: If it never moved.
    """
    calm = curve.at(t)
    slow = _slow(t, curve, arm, rule)
    if slow.all():
        raise StillError(float(t[-1] - t[0]))
    runs = _grown(t, calm, _runs(slow), ruler)
    first, last, ends = 0, len(t) - 1, [0, len(t) - 1]
    if runs and t[runs[0][0]] - t[0] < rule.time and _is_one_place(q[: runs[0][0] + 1], ruler):
        first = runs.pop(0)[1]
        ends[0] = first - _standing(calm[first::-1], ruler)
    if runs and t[-1] - t[runs[-1][1]] < rule.time and _is_one_place(q[runs[-1][1] :], ruler):
        last = runs.pop()[0]
        ends[1] = last + _standing(calm[last:], ruler)
    if first >= last:
        raise StillError(float(t[-1] - t[0]))
    rests = [
        (begin, end)
        for begin, end in runs
        if t[end] - t[begin] > rule.time and _is_one_place(q[begin : end + 1], ruler)
    ]
    return Moving(first, last, tuple(rests), (ends[0], ends[1]))


def _grown(
    t: FloatArray, calm: FloatArray, runs: list[tuple[int, int]], ruler: Ruler
) -> list[tuple[int, int]]:
    """Give slow stretches with their first and last moments; those that a twitch parts as one."""
    grown: list[tuple[int, int]] = []
    for begin, end in runs:
        middle = np.median(calm[begin : end + 1], axis=0)
        near = ruler.misses(calm, np.broadcast_to(middle, calm.shape)) <= _AT_ITS_ENDS
        low, high = begin, end
        while low > 0 and near[low - 1] and t[begin] - t[low - 1] <= 2.0 * _CALM:
            low -= 1
        while high + 1 < len(t) and near[high + 1] and t[high + 1] - t[end] <= 2.0 * _CALM:
            high += 1
        since, until = grown[-1] if grown else (0, -2)
        parted = t[low] - t[until] > _TWITCH or not _is_one_place(calm[since : high + 1], ruler)
        if low <= until + 1 or (until >= 0 and not parted):
            grown[-1] = (since, high)
        else:
            grown.append((low, high))
    return grown


def _slow(t: FloatArray, curve: BSpline, arm: Arm, rule: RestRule) -> Flags:
    """Tell at which samples the arm is slower than a rest allows."""
    mean = float(t[-1] - t[0]) / (len(t) - 1)
    step = max(float(np.median(np.diff(t))), _FINEST * mean)
    even = np.arange(t[0], t[-1] + step, step)
    q = curve.at(np.minimum(even, t[-1]))
    reach = max(int(_REACH * _CALM / step), 1)
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) * step / _CALM) ** 2)
    kernel /= kernel.sum()
    padded = np.pad(q, ((reach, reach), (0, 0)), mode="edge")
    calm = np.stack([np.convolve(joint, kernel, mode="valid") for joint in padded.T], axis=1)
    rate = np.gradient(calm, step, axis=0)
    tool = np.linalg.norm((arm.jacobian(calm)[:, :3] @ rate[..., None])[..., 0], axis=1)
    turns = [kind is JointKind.REVOLUTE for kind in arm.limits.kinds]
    most = np.where(turns, rule.joint_speed, rule.tool_speed)
    share = np.maximum(tool / rule.tool_speed, (np.abs(rate) / most).max(axis=1))
    slow: Flags = np.interp(t, even, share) < 1.0
    return slow


def _runs(slow: Flags) -> list[tuple[int, int]]:
    """Give first and last sample of each stretch that is slow."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], slow.astype(np.int8), [0]))))
    return [(int(begin), int(end) - 1) for begin, end in edges.reshape(-1, 2)]


def _is_one_place(q: FloatArray, ruler: Ruler) -> bool:
    """Tell whether samples are all near one place."""
    middle = np.broadcast_to(0.5 * (q.min(axis=0) + q.max(axis=0)), q.shape)
    return bool(ruler.misses(q, middle).max() <= _OF_TOLERANCE)


def _standing(q: FloatArray, ruler: Ruler) -> int:
    """Give how many samples after the first are near it, up to the first that is not."""
    far = ruler.misses(q, np.broadcast_to(q[0], q.shape)) > 0.5 * _OF_TOLERANCE
    return int(np.argmax(far)) - 1 if far.any() else len(q) - 1
