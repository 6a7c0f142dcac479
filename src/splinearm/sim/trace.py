"""Where a shaft was over time, for tests that ask whether a limit was broken on the way."""

from array import array
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray

_FIELDS = 4


class Motion(NamedTuple):
    """The motion of one shaft, a row a millisecond; none is added while the rig stands still."""

    t: FloatArray
    """Time in the rig, shape (k,), s."""
    angle: FloatArray
    """The shaft's true angle in the joint's direction, shape (k,), rad."""
    speed: FloatArray
    """Its true speed, shape (k,), rad/s."""
    torque_on: FloatArray
    """1 where the motor was driven, 0 where not, shape (k,)."""

    @property
    def acceleration(self) -> FloatArray:
        """Acceleration by differences of the speed, shape (k,), rad/s2; 0 for fewer than two."""
        if len(self.t) < 2:
            return np.zeros(len(self.t))
        return np.asarray(np.gradient(self.speed, self.t))

    def after(self, t: float) -> "Motion":
        """Give the part from a time on, s."""
        late = self.t >= t
        return Motion(*(values[late] for values in self))


class Trace:
    """Writes the motion of a shaft down; hang it on a servo: ``servo.trace = Trace()``."""

    def __init__(self) -> None:
        self._rows = array("d")

    def __len__(self) -> int:
        return len(self._rows) // _FIELDS

    def add(self, t: float, angle: float, speed: float, torque_on: bool) -> None:  # noqa: FBT001
        """Add a row."""
        self._rows.extend((t, angle, speed, torque_on))

    def motion(self) -> Motion:
        """Give what was written down so far."""
        rows = np.array(self._rows).reshape(-1, _FIELDS)
        return Motion(*(np.ascontiguousarray(column) for column in rows.T))
