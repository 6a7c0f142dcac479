"""Torques on a path, from the arm's dynamics.

At q(s) the torques are a(s) s'' + b(s) s'^2 + g(s) and friction: viscous in proportion to the
speed, Coulomb's against the motion. Where a motor drives, its torque falls with its speed::

    a u + b x + (viscous + full / no_load) |q'| sqrt(x) + coulomb + g <= full    (as q' points)
    -a u - b x - viscous |q'| sqrt(x) - coulomb - g <= full                      (against it)
"""

from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import HoldError
from splinearm.joints import JointKind
from splinearm.kinematics.dynamics import Drives, Dynamics

from .joint_path import JointPath
from .limit import MotionLimits
from .sampled_row import SHARES, Lines
from .scratch import scratch
from .timing_entry import torque_kernels

_LOOKS = np.array([0.1, 0.22, 0.78, 0.9])
"""Where in each cell torques are looked at: parabolas through ``SHARES`` miss most there."""

_LEAST_MARGIN = 1e-6
"""So much of the full torque must be left where the arm only holds itself."""

_NEAR = 0.05
"""A tangent this near to the law, as a share of its speed, stays where it is."""

_MOVES = 2
"""So often tangents are moved."""


@dataclass(frozen=True, slots=True, eq=False)
class Torque:
    """The torques along a path and their limits."""

    path: JointPath
    """The way of the joints."""
    limits: MotionLimits
    """What the joints may do; with dynamics."""
    dynamics: Dynamics
    """The arm."""
    full: FloatArray
    """Highest torques, shape (n,), N m or N."""

    @property
    def names(self) -> tuple[tuple[str, str], ...]:
        """Joint and quantity of each use."""
        return tuple((name, "torque") for name in self.limits.joints.names)

    def on(self, s: FloatArray) -> "TakenTorque":
        """Give the torques on the cells between nodes s.

        Raises:
            HoldError: If a joint could not even hold the arm somewhere, or creep there.
        """
        return TakenTorque(self, s)

    def drive(self, pace: float) -> FloatArray:
        """Give the numbers of the drives as `torque_kernel` takes them, shape (5, n)."""
        n = self.path.n
        numbers = (self.dynamics.drives or Drives()).numbers(n)
        no_load = self.limits.no_load_speed
        drive = np.empty((5, n))
        drive[:2], drive[2] = numbers[:, 1:].T, self.full
        drive[3] = np.inf if no_load is None else no_load
        drive[4] = pace
        return drive


class TakenTorque:
    """Torques on a grid."""

    squares: FloatArray | None = None

    def __init__(self, torque: Torque, s: FloatArray) -> None:
        self._torque, self._s, self._moves = torque, s, 0
        path, inverse = torque.path, torque.dynamics.inverse
        cells, n = len(s) - 1, path.n
        q, slope, bend = self._motion("torque_places", np.empty(0), SHARES)
        # at a pace at which joints move about 1 rad/s, whatever the parameter's unit
        largest = float(np.abs(slope).max())
        pace = 1.0 / max(largest, 1e-300)
        taken = scratch("torques", 4, cells, 3, n)
        still = np.zeros_like(q)
        np.multiply(slope, pace, out=taken[3])
        bend *= pace * pace
        inverse(q, still, still, out=taken[0])
        inverse(q, still, taken[3], out=taken[1])
        inverse(q, taken[3], bend, out=taken[2])
        self._taken, self._drive = taken, torque.drive(pace)
        self._reference = np.zeros((cells, 2, n))
        self._refuse_weak()

    def lines(self, ease: FloatArray, ceiling: FloatArray) -> Lines:
        """Give what torques allow, each tightened by ``ease``, shape (cells, n)."""
        cells, n = ease.shape
        lines, alone = scratch("torque_lines", 2, cells, 2, 6 * n), np.empty(cells)
        torque_kernels().lines(
            self._taken, self._drive, self._s, ease, ceiling, self._reference, lines, alone
        )
        return Lines(lines[0], lines[1], alone)

    def follow(self, x: FloatArray) -> bool:
        """Move tangents to the law as it is; tell whether one has moved."""
        drive = self._drive
        if self._moves == _MOVES or not (drive[0].any() or np.isfinite(drive[3]).any()):
            return False
        self._moves += 1
        middle = np.sqrt(0.5 * (x[:-1] + x[1:]))[:, None, None]
        # the tangent's error is of second order in how far it is moved
        far = np.abs(middle - self._reference) > _NEAR * self._reference
        self._reference = np.where(far, middle, self._reference)
        return bool(far.any())

    def use(self, x: FloatArray, shares: FloatArray = _LOOKS) -> FloatArray:
        """Give the largest share of each torque that is used in each cell, shape (cells, n)."""
        q, qd, qdd = self._motion("torque_looks", x, shares)
        torque = self._torque.dynamics.inverse(q, qd, qdd, out=scratch("torque_out", *q.shape))
        use = np.empty((len(x) - 1, q.shape[2]))
        torque_kernels().use(torque, qd, self._drive, use)
        return use

    def _motion(self, name: str, x: FloatArray, shares: FloatArray) -> FloatArray:
        path, s = self._torque.path, self._s
        out = scratch(name, 3, len(s) - 1, len(shares), path.n)
        torque_kernels().motion(path.breaks, path.coefficients, s, x, shares, out)
        return out

    def _refuse_weak(self) -> None:
        """Refuse a path on which a joint cannot hold the arm, or creep."""
        weight, rate, drive = self._taken[0], self._taken[3], self._drive
        need = weight + drive[1] * np.where(np.abs(rate) > 1e-12, np.sign(rate), 0.0)
        over = np.maximum(np.abs(need), np.abs(weight)) / drive[2]
        if over.max() < 1.0 - _LEAST_MARGIN:
            return
        cell, share, joint = np.unravel_index(int(np.argmax(over)), over.shape)
        place = self._s[cell] + SHARES[share] * (self._s[cell + 1] - self._s[cell])
        torques = need[cell, share, joint], weight[cell, share, joint]
        raise HoldError(
            self._torque.names[joint][0],
            float(max(torques, key=abs)),
            float(drive[2, joint]),
            f"s = {place:.6g}",
            linear=self._torque.dynamics.arm.links[joint].kind is JointKind.PRISMATIC,
        )
