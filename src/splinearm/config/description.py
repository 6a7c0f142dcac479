"""Arms without servos from robot description files: URDF and MJCF."""

from pathlib import Path

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointLimits
from splinearm.kinematics import Arm
from splinearm.kinematics.mjcf import read_mjcf
from splinearm.kinematics.urdf import read_urdf

READERS = {".urdf": read_urdf, ".xml": read_mjcf, ".mjcf": read_mjcf}
"""How a file is read, by the end of its name."""


def read_arm(file: Path, tip: str | None) -> Arm:
    """Read the arm that ends in a tip, or in the only one there is.

    Raises:
        ConfigError: With file and element, if there is no such arm.
    """
    return READERS[file.suffix.lower()](file, tip).arm


def home_of(limits: JointLimits) -> FloatArray:
    """Give the pose that such a file does not: zero where a joint may be there, else its middle."""
    low = np.maximum(limits.q_min, -np.finfo(np.float64).max / 4.0)
    high = np.minimum(limits.q_max, np.finfo(np.float64).max / 4.0)
    zero_fits = (limits.q_min <= 0.0) & (limits.q_max >= 0.0)
    middle = np.where(np.isfinite(limits.q_min), low, high)
    both = np.isfinite(limits.q_min) & np.isfinite(limits.q_max)
    home = np.where(zero_fits, 0.0, np.where(both, 0.5 * (low + high), middle))
    home.flags.writeable = False
    return home
