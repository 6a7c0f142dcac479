"""The way of the tool that a plan wants, whatever the joints make of it."""

from dataclasses import dataclass, field

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.curves.nearest import Chords, SpaceCurve, chords_of, distance_to_curves
from splinearm.kinematics.arm import Arm

from .joint_path import JointPath
from .trajectory import JointTrajectory


@dataclass(frozen=True, slots=True, eq=False)
class CarriedPath:
    """The way of a tool that the joints carry along their own way."""

    arm: Arm
    """The arm."""
    joints: JointPath
    """The way of its joints."""

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return self.joints.domain

    @property
    def breaks(self) -> FloatArray:
        """Ends of the smooth pieces."""
        return self.joints.breaks

    def places(self, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give positions of the tool and their derivatives by s, each of shape (m, 3)."""
        q, slope, _ = self.joints.sample(s)
        J = self.arm.jacobian(q)[:, :3]
        return self.arm.fk(q)[:, :3, 3], np.einsum("mij,mj->mi", J, slope)


@dataclass(frozen=True, slots=True, eq=False)
class ToolPath:
    """The wanted way of the tool: curves one after the other."""

    curves: tuple[SpaceCurve, ...]
    """The curves; none for a motion that stays where it is."""
    p_start: FloatArray
    """Where the tool starts, shape (3,), m in base."""
    _chords: list[Chords] = field(init=False, repr=False, default_factory=list)

    def __post_init__(self) -> None:
        object.__setattr__(self, "p_start", frozen_array(self.p_start, (3,), "p_start"))

    @property
    def length(self) -> float:
        """Length of the way, m, to a tenth of a micrometre a chord."""
        return float(sum(_lengths(chords)[-1] for chords in self._known_chords()))

    def distance(self, points: ArrayInput) -> FloatArray:
        """Give the distance of points to the nearest place of the way, shape (m,), m.

        Args:
            points: Points in base, shape (m, 3), m.

        Raises:
            ValueError: If they are not of that shape or not finite.
        """
        array = frozen_array(points, (None, 3), "points")
        if not self.curves:
            gap: FloatArray = np.linalg.norm(array - self.p_start, axis=1)
            return gap
        return distance_to_curves(self.curves, array, self._known_chords())

    def sample(self, m: int) -> FloatArray:
        """Give m places of the way, evenly spread over its length, shape (m, 3), m.

        Raises:
            ValueError: If m is less than 2.
        """
        if m < 2:
            raise ValueError(f"m: want at least 2, got {m}")
        lengths = [_lengths(chords) for chords in self._known_chords()]
        ends = np.cumsum([length[-1] for length in lengths])
        if not self.curves or ends[-1] <= 0.0:
            return np.tile(self.p_start, (m, 1))
        wanted = np.linspace(0.0, ends[-1], m)
        which = np.minimum(np.searchsorted(ends, wanted), len(ends) - 1)
        places = np.empty((m, 3))
        for i, curve in enumerate(self.curves):
            here = which == i
            along = wanted[here] - (ends[i] - lengths[i][-1])
            s = np.interp(along, lengths[i], self._known_chords()[i].s)
            places[here] = curve.places(s)[0]
        return places

    def _known_chords(self) -> list[Chords]:
        if not self._chords:
            self._chords[:] = [chords_of(curve) for curve in self.curves]
        return self._chords


def carried_tool_path(arm: Arm, trajectory: JointTrajectory) -> ToolPath:
    """Give the way of the tool that a motion of the joints carries, as the wanted one."""
    curves = []
    for section in trajectory.sections:
        first, last = float(section.law.s[0]), float(section.law.s[-1])
        if last > first:
            curves.append(CarriedPath(arm, JointPath(section.path.curve.part(first, last))))
    return ToolPath(tuple(curves), arm.fk(trajectory.q_start)[:3, 3])


def _lengths(chords: Chords) -> FloatArray:
    """Give the way along chords up to each of their ends, m."""
    steps = np.linalg.norm(np.diff(chords.p, axis=0), axis=1)
    return np.concatenate(([0.0], np.cumsum(steps)))
