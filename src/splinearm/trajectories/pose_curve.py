"""Curves of poses: position and orientation by one parameter, each a curve of its own."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.curves.bspline import BSpline
from splinearm.curves.interpolation import EndDerivatives, Ends, interpolate
from splinearm.kinematics import quaternion
from splinearm.kinematics.pose import Pose

from .orientation import interpolate_orientations
from .turning import OrientationCurve


class PoseMotion(NamedTuple):
    """Poses and how they change with the parameter; rates in the fixed frame, linear first."""

    p: FloatArray
    """Positions, shape (m, 3), m."""
    quat: FloatArray
    """Orientations, unit quaternions w x y z, shape (m, 4)."""
    twist: FloatArray
    """Velocity of the origin, m, and angular velocity, rad, per unit of the parameter, (m, 6)."""
    twist_rate: FloatArray
    """Their derivatives: acceleration of the origin and angular acceleration, shape (m, 6)."""

    def matrices(self) -> FloatArray:
        """Give the poses as transforms, shape (m, 4, 4)."""
        T = np.zeros((len(self.p), 4, 4))
        T[:, :3, :3] = quaternion.to_matrix(self.quat)
        T[:, :3, 3] = self.p
        T[:, 3, 3] = 1.0
        return T


@dataclass(frozen=True, slots=True, eq=False)
class PoseCurve:
    """A curve of poses whose origin runs on one curve while the frame turns by another.

    The origin's way does not depend on how the frame turns (``ScrewBSpline`` couples both). What a
    plan follows is a ``CartesianPath``, whose orientation may be free.
    """

    position: BSpline
    """Where the origin is, in space, m."""
    orientation: OrientationCurve
    """How the frame stands, on the same domain."""

    def __post_init__(self) -> None:
        if self.position.dim != 3:
            raise ValueError(f"position: want a curve in space, got {self.position.dim} numbers")
        if self.position.domain != self.orientation.domain:
            raise ValueError(
                f"orientation: want the domain of the position, {self.position.domain}, "
                f"got {self.orientation.domain}"
            )

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return self.position.domain

    @property
    def breaks(self) -> FloatArray:
        """Where the curve is less smooth than inside its pieces, and its ends."""
        return np.union1d(self.position.breaks, self.orientation.breaks)

    def at(self, u: ArrayInput) -> PoseMotion:
        """Give poses, twists and their derivatives.

        Args:
            u: Parameters in the domain, shape (m,).

        Raises:
            CurveError: If one lies outside.
        """
        u = np.asarray(u, dtype=np.float64)
        turning = self.orientation.at(u)
        p, velocity, acceleration = (self.position.at(u, order) for order in range(3))
        return PoseMotion(
            p,
            turning.quat,
            np.hstack((velocity, turning.omega)),
            np.hstack((acceleration, turning.alpha)),
        )


def interpolate_poses(
    u: ArrayInput,
    poses: Sequence[Pose],
    *,
    closed: bool = False,
    degree: int = 3,
    twist_start: ArrayInput | None = None,
    twist_end: ArrayInput | None = None,
) -> PoseCurve:
    """Give the smooth curve through poses at their parameters, of degree 3 C2, of degree 5 C4.

    Args:
        u: Parameters, rising, shape (m,), of a closed curve (m + 1,).
        poses: The poses, at least 2.
        closed: Whether the curve returns to the first pose as smoothly as it passes it.
        degree: 3 or 5.
        twist_start: Velocity of the origin and angular velocity at the start of an open curve, in
            the fixed frame, per unit of the parameter, shape (6,); None: it begins without
            acceleration.
        twist_end: The same at its end; give both or none.

    Raises:
        CurveError: If no such curve was found.
        ValueError: If numbers, order or lengths do not fit.
    """
    if len(poses) < 2:
        raise ValueError(f"poses: want at least 2, got {len(poses)}")
    if (twist_start is None) != (twist_end is None):
        raise ValueError("twist_start, twist_end: want both or none")
    ends: Ends | EndDerivatives = "closed" if closed else "natural"
    omegas: tuple[FloatArray | None, FloatArray | None] = None, None
    if twist_start is not None and twist_end is not None:
        first = frozen_array(twist_start, (6,), "twist_start")
        last = frozen_array(twist_end, (6,), "twist_end")
        if closed:
            raise ValueError("twist_start, twist_end: a closed curve has no ends")
        ends = EndDerivatives(first[None, :3], last[None, :3])
        omegas = first[3:], last[3:]
    orientation = interpolate_orientations(
        u,
        np.array([pose.quat for pose in poses]),
        closed=closed,
        degree=degree,
        omega_start=omegas[0],
        omega_end=omegas[1],
    )
    points = np.array([pose.p for pose in poses])
    position = interpolate(points, degree=degree, parameters=np.asarray(u, float), ends=ends)
    return PoseCurve(position, orientation)
