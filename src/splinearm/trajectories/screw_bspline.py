"""Cumulative B-splines of poses: curves of rigid motions that control poses pull at."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.curves import basis
from splinearm.curves.bspline import BSpline
from splinearm.kinematics import quaternion, se3
from splinearm.kinematics.pose import Pose
from splinearm.kinematics.space import rigid_inverse

from .pose_curve import PoseMotion
from .rotation_bspline import cumulative_values
from .turning import equal_signs, inside


@dataclass(frozen=True, slots=True, eq=False)
class ScrewBSpline:
    """A curve of poses by control poses and knots, like a ``BSpline`` of points.

    From one control pose to the next it goes by a screw motion, so that turn and way belong
    together: seen from the body, it does not matter in which frame or where the poses are written.
    Of degree p it has p - 1 continuous derivatives, fewer by one for each time a knot is repeated.
    Where the origin is to keep to a curve of its own, take a ``PoseCurve``.
    """

    knots: FloatArray
    """Knots, shape (m + degree + 1,), never falling."""
    poses: Sequence[Pose]
    """Control poses, m of them; neighbours less than half a turn apart."""
    degree: int
    """Degree, at least 1."""

    def __post_init__(self) -> None:
        if self.degree < 1:
            raise ValueError(f"degree: want at least 1, got {self.degree!r}")
        # the same knots carry a curve of numbers, which checks them
        knots = frozen_array(self.knots, (None,), "knots")
        frame = BSpline(knots, np.zeros((len(self.poses), 1)), self.degree)
        object.__setattr__(self, "knots", frame.knots)
        object.__setattr__(self, "poses", tuple(self.poses))

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return float(self.knots[self.degree]), float(self.knots[-self.degree - 1])

    @property
    def breaks(self) -> FloatArray:
        """The different knots of the domain: the ends of the pieces."""
        return np.unique(self.knots[self.degree : self.knots.size - self.degree])

    def at(self, u: ArrayInput) -> PoseMotion:
        """Give poses, twists and their derivatives.

        Args:
            u: Parameters in the domain, shape (m,).

        Raises:
            CurveError: If one lies outside.
        """
        # Sommer et al., Efficient derivative computation for cumulative B-splines on Lie groups,
        # CVPR 2020, eq. 7 to 9, on SE(3); rates are in the body
        u = inside(u, self.domain)
        spans = basis.find_spans(self.knots, self.degree, u)
        shares, slopes, bends = (
            cumulative_values(self.knots, self.degree, spans, u, order) for order in range(3)
        )
        controls = np.array([pose.matrix() for pose in self.poses])
        screws = se3.log(rigid_inverse(controls[:-1]) @ controls[1:])
        T = controls[spans - self.degree]
        # carried along, so that its sign does not flip
        quat = equal_signs(np.array([pose.quat for pose in self.poses]))[spans - self.degree]
        rate, change = np.zeros((2, u.size, 6))
        for j in range(self.degree):
            screw = screws[spans - self.degree + j]
            step = se3.exp(shares[:, j, None] * screw)
            back = se3.adjoint(rigid_inverse(step))
            own = slopes[:, j, None] * screw
            rate = np.einsum("mij,mj->mi", back, rate)
            change = np.einsum("mij,mj->mi", back, change) + _bracket(rate, own)
            change += bends[:, j, None] * screw
            rate = rate + own
            T = T @ step
            quat = quaternion.multiply(quat, quaternion.exp(shares[:, j, None] * screw[:, 3:]))
        return _in_base(T, quaternion.normalize(quat), rate, change)


def _bracket(a: FloatArray, b: FloatArray) -> FloatArray:
    """Give the Lie bracket of twists, shape (m, 6)."""
    # Lynch and Park, Modern Robotics, 2017, def. 8.5, with the linear part first
    linear = np.cross(a[:, 3:], b[:, :3]) + np.cross(a[:, :3], b[:, 3:])
    return np.hstack((linear, np.cross(a[:, 3:], b[:, 3:])))


def _in_base(T: FloatArray, quat: FloatArray, rate: FloatArray, change: FloatArray) -> PoseMotion:
    """Give rates of the body as velocity and acceleration of its origin, and of its turn."""
    # the origin's velocity is R v, so that its acceleration is R (v' + omega x v)
    R = T[:, :3, :3]
    along = change[:, :3] + np.cross(rate[:, 3:], rate[:, :3])
    parts = rate[:, :3], rate[:, 3:], along, change[:, 3:]
    velocity, omega, acceleration, alpha = (np.einsum("mij,mj->mi", R, part) for part in parts)
    return PoseMotion(
        T[:, :3, 3], quat, np.hstack((velocity, omega)), np.hstack((acceleration, alpha))
    )
