"""Squad: the simple smooth curve through orientations, of slerps between slerps."""

from dataclasses import dataclass, field

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.kinematics import quaternion

from .rotation_bspline import shorter
from .rotation_jacobian import body_rates, inverse_jacobian
from .turning import Turning, checked_quats, equal_signs, inside


@dataclass(frozen=True, slots=True, eq=False)
class Squad:
    """A curve through orientations that is made piece by piece from neighbours, without solving.

    It is C1: its angular acceleration jumps at every inner orientation. A piece depends on four
    orientations only. Where acceleration must not jump, or the curve is sampled much, use
    ``interpolate_orientations``.
    """

    u: FloatArray
    """Parameters of the orientations, rising, shape (m,), at least 2; they need not be even."""
    quats: FloatArray
    """The orientations, unit quaternions w x y z of either sign, shape (m, 4)."""
    _leads: FloatArray = field(init=False, repr=False)
    """From each orientation to its control orientation, rotation vectors, shape (m, 3)."""

    def __post_init__(self) -> None:
        quats = equal_signs(checked_quats(self.quats))
        u = frozen_array(self.u, (len(quats),), "u")
        if len(u) < 2 or (np.diff(u) <= 0.0).any():
            raise ValueError(f"u: want at least 2 rising parameters, got {u.tolist()}")
        quats.flags.writeable = False
        object.__setattr__(self, "u", u)
        object.__setattr__(self, "quats", quats)
        object.__setattr__(self, "_leads", _leads(u, quats))

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return float(self.u[0]), float(self.u[-1])

    @property
    def breaks(self) -> FloatArray:
        """The parameters of the orientations: there the curve is C1 only."""
        return self.u

    def at(self, u: ArrayInput) -> Turning:
        """Give orientations, angular velocities and accelerations; at breaks those from behind.

        Args:
            u: Parameters in the domain, shape (m,).

        Raises:
            CurveError: If one lies outside.
        """
        # Shoemake, Quaternion calculus and fast animation, SIGGRAPH course notes 10, 1987:
        # slerp(outer, inner, 2 x (1 - x)) of two slerps, here with its derivatives
        u = inside(u, self.domain)
        piece = np.clip(np.searchsorted(self.u, u, side="right") - 1, 0, len(self.u) - 2)
        h = np.diff(self.u)[piece, None]
        x = (u - self.u[piece])[:, None] / h
        outer_turn = shorter(self.quats)[piece]
        controls = quaternion.multiply(self.quats, quaternion.exp(self._leads))
        inner_start = controls[piece]
        inner_turn = _log(
            quaternion.multiply(quaternion.conjugate(inner_start), controls[piece + 1])
        )
        outer = quaternion.multiply(self.quats[piece], quaternion.exp(x * outer_turn))
        inner = quaternion.multiply(inner_start, quaternion.exp(x * inner_turn))
        between = _Between.of(outer, inner, outer_turn, inner_turn)
        # the share and its derivatives by x
        share, slope, bend = 2.0 * x * (1.0 - x), 2.0 - 4.0 * x, -4.0
        f = share * between.turn
        fd = slope * between.turn + share * between.slope
        fdd = bend * between.turn + 2.0 * slope * between.slope + share * between.bend
        own, own_alpha = body_rates(f, fd, fdd)
        step = quaternion.exp(f)
        carried = quaternion.rotate(quaternion.conjugate(step), outer_turn)
        quat = quaternion.normalize(quaternion.multiply(outer, step))
        omega = (carried + own) / h
        alpha = (own_alpha + np.cross(carried, own)) / h**2
        return Turning(quat, quaternion.rotate(quat, omega), quaternion.rotate(quat, alpha))


@dataclass(frozen=True, slots=True, eq=False)
class _Between:
    """The turn from one even turn to another, a rotation vector, with its derivatives."""

    turn: FloatArray
    slope: FloatArray
    bend: FloatArray

    @staticmethod
    def of(a: FloatArray, b: FloatArray, a_omega: FloatArray, b_omega: FloatArray) -> "_Between":
        """Take orientations and the constant angular velocities, in the body, of both."""
        apart = quaternion.multiply(quaternion.conjugate(a), b)
        turn = _log(apart)
        dragged = quaternion.rotate(quaternion.conjugate(apart), a_omega)
        omega = b_omega - dragged
        inverse = inverse_jacobian(turn)
        slope = np.einsum("mij,mj->mi", inverse, omega)
        # alpha = J f'' + J' f': what J' f' is tells the acceleration of f'' = 0
        alpha = np.cross(b_omega, dragged)
        bent = body_rates(turn, slope, np.zeros_like(slope))[1]
        return _Between(turn, slope, np.einsum("mij,mj->mi", inverse, alpha - bent))


def _log(quat: FloatArray) -> FloatArray:
    """Give the rotation vector, up to a whole turn long, that does not jump at a half turn.

    Signs of quaternions count here: along a piece they do not flip.
    """
    length = np.linalg.norm(quat[:, 1:], axis=1, keepdims=True)
    none = length <= 0.0
    angle = 2.0 * np.arctan2(length, quat[:, :1])
    vector: FloatArray = np.where(none, 2.0, angle / np.where(none, 1.0, length)) * quat[:, 1:]
    return vector


def _leads(u: FloatArray, quats: FloatArray) -> FloatArray:
    """Give control orientations with which pieces join at one angular velocity."""
    # where h is the length of a piece and d its turn, a piece starts with (d + 2 lead) / h and
    # ends with (d - 2 lead) / h; for even parameters these are Shoemake's
    rates = shorter(quats) / np.diff(u)[:, None]
    inverse = 1.0 / np.diff(u)[:, None]
    leads = np.zeros((len(u), 3))
    leads[1:-1] = (rates[:-1] - rates[1:]) / (2.0 * (inverse[:-1] + inverse[1:]))
    return leads
