"""The words in which rooms speak of joints: setpoints, states and limits, in SI."""

from dataclasses import dataclass, replace
from enum import Enum
from math import isfinite

import numpy as np

from .arrays import FloatArray, frozen_array
from .errors import LimitError


class JointKind(Enum):
    """How a joint moves."""

    REVOLUTE = "revolute"
    """It turns; its position is in rad."""

    PRISMATIC = "prismatic"
    """It slides; its position is in m."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class JointSetpoint:
    """Where the joints shall be at one moment. Prismatic joints: m instead of rad."""

    t: float
    """Time since the start of the motion, s."""
    q: FloatArray
    """Position, shape (n,), rad."""
    qd: FloatArray
    """Velocity, shape (n,), rad/s."""
    qdd: FloatArray
    """Acceleration, shape (n,), rad/s2."""

    def __post_init__(self) -> None:
        if not isfinite(self.t):
            raise ValueError(f"t: want a finite time, got {self.t}")
        q = frozen_array(self.q, (None,), "q")
        object.__setattr__(self, "q", q)
        object.__setattr__(self, "qd", frozen_array(self.qd, q.shape, "qd"))
        object.__setattr__(self, "qdd", frozen_array(self.qdd, q.shape, "qdd"))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class JointState:
    """What an arm measured. Prismatic joints: m instead of rad."""

    t: float
    """When, on the driver's clock, s."""
    q: FloatArray
    """Position, shape (n,), rad."""
    qd: FloatArray
    """Velocity, shape (n,), rad/s."""
    current: FloatArray
    """Motor current, shape (n,), A; NaN where the motor does not measure it."""

    def __post_init__(self) -> None:
        n = np.size(self.q)
        for name in ("q", "qd"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), (n,), name))
        current = np.array(self.current, dtype=np.float64)
        if current.shape != (n,):
            raise ValueError(f"current: want shape ({n},), got {current.shape}")
        current.flags.writeable = False
        object.__setattr__(self, "current", current)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class JointLimits:
    """What the joints may do. A joint without a position limit has -inf and inf there."""

    names: tuple[str, ...]
    """Names of the n joints, base to tool."""
    kinds: tuple[JointKind, ...]
    """How each joint moves."""
    q_min: FloatArray
    """Lowest position, shape (n,), rad or m."""
    q_max: FloatArray
    """Highest position, shape (n,), rad or m."""
    qd_max: FloatArray
    """Highest speed, shape (n,), rad/s or m/s, above zero."""
    qdd_max: FloatArray
    """Highest acceleration, shape (n,), rad/s2 or m/s2, above zero."""
    qddd_max: FloatArray | None = None
    """Highest jerk, shape (n,), rad/s3 or m/s3, above zero; None: not limited."""
    torque_max: FloatArray | None = None
    """Highest torque, shape (n,), N m or N, above zero; None: not known."""

    def __post_init__(self) -> None:
        n = len(self.names)
        if len(self.kinds) != n:
            raise ValueError(f"kinds: want {n} of them, one a joint, got {len(self.kinds)}")
        for name in ("q_min", "q_max"):
            value = frozen_array(getattr(self, name), (n,), name, finite=False)
            object.__setattr__(self, name, value)
        for name in ("qd_max", "qdd_max", "qddd_max", "torque_max"):
            if getattr(self, name) is None:
                continue
            value = frozen_array(getattr(self, name), (n,), name)
            if (value <= 0.0).any():
                raise ValueError(f"{name}: want numbers above zero, got {value.tolist()}")
            object.__setattr__(self, name, value)
        if (self.q_min >= self.q_max).any():
            joint = self.names[int(np.argmax(self.q_min >= self.q_max))]
            raise ValueError(f"joint {joint!r}: its lowest position is not below its highest")

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.names)

    def scaled(self, share: float) -> "JointLimits":
        """Give the same limits with velocity, acceleration and jerk times shares of themselves.

        Velocity is multiplied by ``share``, acceleration by its square and jerk by its cube, so
        that a motion planned within them takes exactly 1/share times as long.
        """
        if not 0.0 < share <= 1.0:
            raise ValueError(f"share: want above 0 and at most 1, got {share}")
        return JointLimits(
            names=self.names,
            kinds=self.kinds,
            q_min=self.q_min,
            q_max=self.q_max,
            qd_max=self.qd_max * share,
            qdd_max=self.qdd_max * share**2,
            qddd_max=None if self.qddd_max is None else self.qddd_max * share**3,
            torque_max=self.torque_max,
        )

    def with_jerk_time(self, time: float) -> "JointLimits":
        """Give the same limits with a jerk that takes each joint to full acceleration in a time.

        Args:
            time: That time, s.

        Raises:
            ValueError: If it is not above 0.
        """
        if not 0.0 < time < np.inf:
            raise ValueError(f"time: want a number above 0 s, got {time}")
        return replace(self, qddd_max=self.qdd_max / time)

    def check(
        self,
        q: FloatArray,
        qd: FloatArray | None = None,
        qdd: FloatArray | None = None,
        *,
        t: float | None = None,
        tolerance: float = 1e-9,
    ) -> None:
        """Pass joint values that are within the limits; refuse the first that is not.

        Args:
            q: Position, shape (n,), rad or m.
            qd: Velocity, shape (n,), or None.
            qdd: Acceleration, shape (n,), or None.
            t: The time to name in the error, s.
            tolerance: How far beyond a limit rounding may carry a value, in its SI unit.

        Raises:
            LimitError: With the joint, the quantity, the value and the limit.
        """
        self._refuse("position", q, q < self.q_min - tolerance, self.q_min, t)
        self._refuse("position", q, q > self.q_max + tolerance, self.q_max, t)
        if qd is not None:
            self._refuse("velocity", qd, np.abs(qd) > self.qd_max + tolerance, self.qd_max, t)
        if qdd is not None:
            over = np.abs(qdd) > self.qdd_max + tolerance
            self._refuse("acceleration", qdd, over, self.qdd_max, t)

    def _refuse(
        self,
        quantity: str,
        value: FloatArray,
        outside: "np.ndarray[tuple[int, ...], np.dtype[np.bool_]]",
        limit: FloatArray,
        t: float | None,
    ) -> None:
        if not outside.any():
            return
        i = int(np.argmax(outside))
        raise LimitError(
            self.names[i],
            quantity,
            float(value[i]),
            float(limit[i]),
            t,
            linear=self.kinds[i] is JointKind.PRISMATIC,
        )
