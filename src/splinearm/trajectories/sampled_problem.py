"""The quickest x(s) where limits beside those of the joints are taken at places."""

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import TrajectoryError
from splinearm.joints import JointLimits

from . import sampled_row
from .joint_path import JointPath
from .reachability import Frame, fastest, frame
from .sampled_row import Lines, SampledLimit

_SLACK = 1e-9
"""By what share a limit may be broken where it is looked at."""

_ALMOST = 1e-6
"""The same for a law that must begin or end moving, and so cannot be slowed down as a whole."""

_ROUNDS = 10

_SURE = 1.2
"""A limit is tightened by so much more than it was broken."""

_BISECTIONS = 50


class SampledProblem:
    """A path with its limits on a grid."""

    def __init__(
        self, path: JointPath, joints: JointLimits, limits: list[SampledLimit], s: FloatArray
    ) -> None:
        self._s, self._known = s, frame(path, joints, s)
        self._taken = [limit.on(s) for limit in limits]
        self._ease = [np.ones((len(s) - 1, len(limit.names))) for limit in limits]

    def roughly(self, ends: tuple[float, float]) -> FloatArray:
        """Give nearly the largest x at the nodes; limits may be broken a little between them."""
        return self._fastest(ends)

    def solve(self, ends: tuple[float, float], near: FloatArray) -> FloatArray:
        """Give the largest x at the nodes for which all limits are kept where it is looked at.

        Args:
            ends: ds/dt at the first and the last node.
            near: About what x will be.

        Raises:
            TrajectoryError: If no profile begins and ends at such speeds, or none was found.
        """
        for taken in self._taken:
            taken.follow(near)
        x = self._fastest(ends)
        for _ in range(_ROUNDS):
            moved = sum(taken.follow(x) for taken in self._taken)
            if not self._tighten(x) and not moved:
                return x
            x = self._fastest(ends)
        if ends == (0.0, 0.0):
            return self._slowed(x)
        if self._is_within(x, _ALMOST):
            return x
        raise TrajectoryError(
            f"no law was found that begins at {ends[0]:.6g} /s, ends at {ends[1]:.6g} /s and keeps "
            "the limits of torques and the tool everywhere; begin or end slower, or take more cells"
        )

    def _fastest(self, ends: tuple[float, float]) -> FloatArray:
        """Give the largest x with the limits as they are tightened now."""
        known = Frame(self._known.both, self._known.cap.copy())
        return fastest(known, self._s, ends, self._lines(known))

    def _lines(self, known: Frame) -> Lines:
        """Give what all limits say of neighbours, and lower the caps of nodes."""
        for taken, ease in zip(self._taken, self._ease, strict=True):
            if taken.squares is not None:
                sampled_row.lower_caps(taken.squares * ease[:, None] ** 2, known.cap)
        ceiling = np.maximum(known.cap[:-1], known.cap[1:])
        found = [
            lines
            for taken, ease in zip(self._taken, self._ease, strict=True)
            if (lines := taken.lines(ease, ceiling)) is not None
        ]
        if len(found) == 1:
            return found[0]
        nothing = np.empty((len(ceiling), 2, 0))
        return Lines(
            np.concatenate([nothing, *(lines.above for lines in found)], axis=2),
            np.concatenate([nothing, *(lines.below for lines in found)], axis=2),
            np.min([ceiling, *(lines.alone for lines in found)], axis=0),
        )

    def _tighten(self, x: FloatArray) -> bool:
        """Tighten limits in the cells where they are broken; tell whether one was."""
        broken = False
        for i, taken in enumerate(self._taken):
            over = np.maximum(taken.use(x) - 1.0, 0.0)
            if over.max() > _SLACK:
                broken = True
                self._ease[i] *= 1.0 + _SURE * over
        return broken

    def _slowed(self, x: FloatArray) -> FloatArray:
        """Give x times the largest share at which no limit is broken."""
        low, high = 0.0, 1.0
        if self._is_within(x):
            return x
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._is_within(middle * x) else (low, middle)
        return low * x

    def _is_within(self, x: FloatArray, slack: float = _SLACK) -> bool:
        return all(taken.use(x).max() <= 1.0 + slack for taken in self._taken)
