"""The swivel of the elbow: what says of seven joints the one thing that a pose leaves open.

See module swivel_kernel for what it is measured from. It has no meaning where the way from shoulder
to wrist lies along the first axis, nor where the elbow lies on that way (the arm is straight).
"""

from functools import lru_cache

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.errors import KinematicsError

from . import gauge as gauges
from .arm import Arm
from .gauge import Gauge
from .structure import ArmClass, Structure, pack

_FLAT = 1e-9


@lru_cache(maxsize=64)
def structure_of(arm: Arm) -> Structure:
    """Give what an arm of seven joints is, so far as its elbow has a swivel.

    Raises:
        KinematicsError: If the first three axes, or the fifth and sixth, do not meet.
    """
    try:
        gauge = None if arm.n != 7 or arm.packed.any_slide else gauges.find(arm.packed)
    except ValueError:
        gauge = None
    if gauge is None or not (gauge.spherical(0) and gauge.meeting(4)) or _never_bends(gauge):
        raise KinematicsError(
            f"arm {arm.name!r} has no swivel: want seven turning joints, the first three axes "
            "meeting in a shoulder, the fifth and sixth in a wrist"
        )
    kind = ArmClass.SEVEN
    if gauge.spherical(4):
        return Structure(kind, f"{kind.value}, spherical wrist", pack(gauge, 0), gauge)
    words = f"{kind.value}, search along the last joint"
    return Structure(kind, words, pack(gauge, 1), gauge)


def swivel_of(arm: Arm, q: ArrayInput) -> float:
    """Give the swivel of the elbow, rad, in -pi to pi, of an arm of seven joints.

    Args:
        arm: The arm; its first three axes meet, and its fifth and sixth do.
        q: Joint positions, shape (7,), rad.

    Raises:
        KinematicsError: If the arm has no swivel, or none there.
        ValueError: If q is not of its shape or not finite.
    """
    gauge = structure_of(arm).gauge
    values = arm.joint_array(q)
    if values.shape != (7,) or gauge is None:
        raise ValueError(f"q: want shape (7,), got {values.shape}")
    frame = gauge.first
    points = []
    for k in range(5):
        frame = frame @ gauges.step(gauge, k, float(values[k]))
        points.append(frame[:3, 3])
    shoulder, elbow, wrist = points[0], points[2], points[4]
    way, up = wrist - shoulder, gauge.first[:3, 2]
    return _angle(arm, way, up, elbow - shoulder)


def check(arm: Arm, structure: Structure, T: FloatArray) -> None:
    """Refuse a pose of a spherical wrist in which the swivel has no meaning."""
    gauge = structure.gauge
    if gauge is None or not gauge.spherical(4):
        return
    B = np.linalg.solve(gauge.first, T) @ np.linalg.inv(gauge.last)
    way = B[:3, 3] - (0.0, 0.0, gauge.rows[0, 1])
    if np.hypot(way[0], way[1]) <= _FLAT * np.linalg.norm(way):
        raise KinematicsError(f"arm {arm.name!r}: {_ON_AXIS}")


_ON_AXIS = "the swivel has no meaning where the wrist lies on the first axis; give a joint instead"
_IS_STRAIGHT = "the swivel has no meaning where the arm is straight; give a joint instead"


def _angle(arm: Arm, way: FloatArray, up: FloatArray, to_elbow: FloatArray) -> float:
    """Give the angle about ``way`` from ``up`` to the elbow."""
    n = way / max(float(np.linalg.norm(way)), 1e-300)
    across_up, across = up - n * (n @ up), to_elbow - n * (n @ to_elbow)
    if np.linalg.norm(across_up) <= _FLAT:
        raise KinematicsError(f"arm {arm.name!r}: {_ON_AXIS}")
    if np.linalg.norm(across) <= _FLAT * np.linalg.norm(to_elbow):
        raise KinematicsError(f"arm {arm.name!r}: {_IS_STRAIGHT}")
    return float(np.arctan2(n @ np.cross(across_up, across), across_up @ across))


def _never_bends(gauge: Gauge) -> bool:
    """Say whether the fourth joint leaves the wrist's distance as it is."""
    rows = gauge.rows
    upper = np.hypot(rows[2, 0], rows[2, 1] * rows[2, 3])
    fore = np.hypot(rows[3, 0], rows[3, 3] * rows[4, 1])
    return bool(min(upper, fore) <= gauges.ZERO)
