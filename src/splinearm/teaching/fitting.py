"""From a recording to a motion: the fewest control points within a tolerance of what was led."""

from dataclasses import dataclass, field, replace

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.config.taught import DECIMALS, LONGEST
from splinearm.config.unit import from_file_units, to_file_units
from splinearm.curves.bspline import BSpline
from splinearm.errors import CurveError, LimitError, StillError
from splinearm.joints import JointKind
from splinearm.kinematics.arm import Arm
from splinearm.trajectories.taught import TaughtMotion
from splinearm.units import DEG, MM

from .knot_choice import KnotChoice
from .noise import Clean, clean
from .recording import Nearness, Recording, Ruler
from .rest import Moving, RestRule, find_moving

_FEWEST = 12
"""Fewer samples than that are no recording."""

_LIMIT_NOISE = 0.3
"""So far beyond a limit, deg or mm, an encoder may say a joint is."""

_CLOSER = 0.97, 0.93, 0.87, 0.8
"""What share of the tolerance is aimed at; the next where the finished curve breaks it."""

_BETWEEN = 4
"""Into so many parts the time between samples is divided to look at the curve there."""

_SCATTERS = 0.8
"""A sample that is farther than that from the recording without noise, as a share of the
tolerance, says too little for the curve to be led by it."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FitRule:
    """How a recording becomes a motion."""

    nearness: Nearness = field(default_factory=Nearness)
    """How near it stays."""
    rest: RestRule = field(default_factory=RestRule)
    """What counts as a rest."""
    smooth: bool = False
    """Whether the motion is C3 (quintic), for limits of jerk; else C2 (cubic)."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Fitted:
    """A motion made from a recording, and what was found on the way."""

    motion: TaughtMotion
    """The motion."""
    start: float
    """When the motion begins, s since the recording began."""
    samples: int
    """How many samples the recording has between its still ends."""
    tool_miss: float
    """How far the tool is off where it is farthest, m."""
    joint_miss: float
    """The same of a joint, as a share of what it may be."""
    wrong: tuple[float, ...]
    """When samples were wrong and left out, s since the recording began."""
    scattered: int
    """How many samples scatter too far to lead the curve; it is near their smoothed neighbours."""
    words: tuple[str, ...]
    """What a person should know."""

    @property
    def points(self) -> int:
        """Number of control points."""
        return len(self.motion.points)


def fit_recording(recording: Recording, arm: Arm, rule: FitRule | None = None) -> Fitted:
    """Make a motion from a recording.

    Samples that are wrong, one or two in a row, are left out and told. Noise is smoothed away,
    still ends are cut, rests are kept with their length. The motion is then within the tolerance of
    every other sample and of the smoothed recording between them, in the fewest control points that
    are found, and within the limits of position.

    Args:
        recording: What was measured.
        arm: The arm that was led.
        rule: How near, and what rests; None: 1 mm of the tool, 0.5 deg of each joint.

    Raises:
        LimitError: If the arm was led beyond a limit of position.
        StillError: If nothing moves.
        CurveError: If the recording lasts longer than an hour, or cannot be followed within the
            tolerance.
        ValueError: If it is of other joints.
    """
    rule = FitRule() if rule is None else rule
    _require(recording, arm)
    ruler = Ruler(arm, rule.nearness)
    t = recording.t - recording.t[0]
    free = clean(t, recording.q, ruler.joint)
    q = recording.q.copy()
    q[free.wrong] = free.curve.at(t[free.wrong])
    q, moved = _within_limits(t, q, arm)
    moving = find_moving(t, q, free.curve, ruler, arm, rule.rest)
    target = _Target(t, q, free.curve, moving, ruler, arm)
    degree = 5 if rule.smooth else 3
    try:
        motion, misses = target.fitted(degree)
    except CurveError:
        if not moving.rests:
            raise
        # a hand that trembled too much to be at one place: then its pauses are slow motion
        target = _Target(t, q, free.curve, moving._replace(rests=()), ruler, arm)
        motion, misses = target.fitted(degree)
    tool, joint = misses
    words = (
        f"within {rule.nearness.tool / MM:g} mm and {rule.nearness.joint / DEG:g} deg of "
        f"{len(target.q)} samples"
    )
    scattered = int(target.scattered.sum())
    return Fitted(
        motion=replace(motion, words=words),
        start=float(t[moving.first]),
        samples=len(target.q),
        tool_miss=tool,
        joint_miss=joint,
        wrong=tuple(t[free.wrong].tolist()),
        scattered=scattered,
        words=(*_wrong_words(t, free), *_scatter_words(scattered), *moved),
    )


def _require(recording: Recording, arm: Arm) -> None:
    """Refuse a recording of which no motion of an arm can be made."""
    if recording.names != arm.joint_names:
        raise ValueError(f"recording: want joints {arm.joint_names}, got {recording.names}")
    if len(recording.t) < _FEWEST:
        raise StillError(recording.duration)
    if recording.duration > LONGEST:  # a clock that was set meanwhile, or two recordings as one
        what = f"lasts {recording.duration:.4g} s, a piece at most {LONGEST:g} s; take a part of it"
        raise CurveError(what, "recording")


class _Target:
    """What a curve is to be near to."""

    def __init__(
        self,
        t: FloatArray,
        q: FloatArray,
        curve: BSpline,
        moving: Moving,
        ruler: Ruler,
        arm: Arm,
    ) -> None:
        part = slice(moving.ends[0], moving.ends[1] + 1)
        self.t, self.q = t[part], q[part]
        self.arm, self.ruler, self._curve = arm, ruler, curve
        self._limits = arm.limits.q_min, arm.limits.q_max
        u = np.round(moving.times(t), DECIMALS)
        self.u = np.maximum.accumulate(u)
        self.calm = self._calm(self.t)
        self.rests = tuple(
            (float(self.u[begin - moving.ends[0]]), round(float(t[end] - t[begin]), DECIMALS))
            for begin, end in moving.rests
        )
        self.scattered = ruler.misses(self.calm, self.q) > _SCATTERS

    def fitted(self, degree: int) -> tuple[TaughtMotion, tuple[float, float]]:
        """Give the motion in the fewest control points, and how far tool and joints are off."""
        for closer in _CLOSER:
            motion = self._attempt(degree, closer)
            tool, joint, most = self._farthest(motion.curve)
            if most <= 1.0:
                return motion, (tool, joint)
        raise CurveError("cannot be followed that closely; allow more", "recording")

    def _attempt(self, degree: int, closer: float) -> TaughtMotion:
        to_samples = self.ruler.near(self.q)
        to_calm = self.ruler.near(self.calm)
        led = ~self.scattered

        def misses(q: FloatArray, part: slice) -> FloatArray:
            off = np.maximum(to_calm.misses(q, part), to_samples.misses(q, part) * led[part])
            return off / closer

        choice = KnotChoice(
            u=self.u,
            q=self.calm,
            misses=misses,
            degree=degree,
            low=self._limits[0],
            high=self._limits[1],
        )
        curve = choice.fewest().curve
        return TaughtMotion(
            names=self.arm.joint_names,
            degree=degree,
            knots=curve.knots,
            points=self._rounded(curve.points),
            rests=self.rests,
        )

    def _rounded(self, points: FloatArray) -> FloatArray:
        """Give control points as a file has them, none beyond a limit."""
        kinds, grain = self.arm.limits.kinds, 10.0**-DECIMALS
        low, high = (to_file_units(limit, kinds) / grain for limit in self._limits)
        steps = np.round(to_file_units(points, kinds) / grain)
        steps = np.clip(steps, np.ceil(low - 1e-6), np.floor(high + 1e-6))
        return from_file_units(np.round(steps * grain, DECIMALS), kinds)

    def _calm(self, t: FloatArray) -> FloatArray:
        return np.clip(self._curve.at(t), *self._limits)

    def _farthest(self, curve: BSpline) -> tuple[float, float, float]:
        """Give how far tool, joints and both as shares are off: at samples and between them."""
        at = curve.at(self.u)
        share = np.arange(_BETWEEN) / _BETWEEN
        u, t = (
            np.append((x[:-1, None] + np.diff(x)[:, None] * share).ravel(), x[-1])
            for x in (self.u, self.t)
        )
        led = ~self.scattered
        places = np.concatenate((at[led], curve.at(u)))
        wanted = np.concatenate((self.q[led], self._calm(t)))
        tool, joint = self.ruler.parts(places, wanted)
        most = self.ruler.misses(places, wanted)
        return float(tool.max()), float(joint.max()), float(most.max())


def _wrong_words(t: FloatArray, free: Clean) -> tuple[str, ...]:
    """Tell which samples were wrong."""
    if not free.wrong.size:
        return ()
    shown = ", ".join(f"{when:.2f}" for when in t[free.wrong][:5])
    more = ", ..." if free.wrong.size > 5 else ""
    count = free.wrong.size
    what = "1 sample is wrong and is" if count == 1 else f"{count} samples are wrong and are"
    return (f"{what} left out (at {shown}{more} s)",)


def _scatter_words(count: int) -> tuple[str, ...]:
    """Tell how many samples could not lead the curve."""
    if not count:
        return ()
    return (
        f"{count} samples scatter by more than the tolerance allows: there the motion is "
        "near their neighbours, smoothed",
    )


def _within_limits(t: FloatArray, q: FloatArray, arm: Arm) -> tuple[FloatArray, tuple[str, ...]]:
    """Give samples within the limits of position: moved there if no more than noise is beyond.

    Raises:
        LimitError: If more is.
    """
    limits, words = arm.limits, []
    inside = np.clip(q, limits.q_min, limits.q_max)
    beyond = np.abs(q - inside)
    for j, name in enumerate(limits.names):
        slides = limits.kinds[j] is JointKind.PRISMATIC
        unit, word = (MM, "mm") if slides else (DEG, "deg")
        k = int(np.argmax(beyond[:, j]))
        if beyond[k, j] > _LIMIT_NOISE * unit:
            above = q[k, j] > limits.q_max[j]
            limit = limits.q_max[j] if above else limits.q_min[j]
            raise LimitError(
                name, "position", float(q[k, j]), float(limit), float(t[k]), linear=slides
            )
        count = int((beyond[:, j] > 0.0).sum())
        if count:
            words.append(
                f"joint {name!r}: {count} samples were up to {beyond[k, j] / unit:.2f} {word} "
                "beyond its limit and are moved to it"
            )
    return inside, tuple(words)
