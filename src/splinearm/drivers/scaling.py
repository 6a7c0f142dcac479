"""Radians to ticks and back: the only file where a joint's angle meets a servo's register.

``ticks = zero_ticks + q * pulses_per_rad``. A servo's direction after its Drive Mode is the joint's
positive direction, so there is no sign here: the arm's file sets Drive Mode to make it so.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self, TypeAlias

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray, frozen_array
from splinearm.errors import LimitError
from splinearm.units import RPM

from .chain import ServoSpec
from .model import ServoModel

IntArray: TypeAlias = npt.NDArray[np.int64]
"""An array of int64: ticks and other raw values."""

ONE_TURN_MODE = 3
"""Operating mode "position": one turn, within Min and Max Position Limit."""
MULTI_TURN_MODES = (4, 5)
"""Operating modes "extended position" and "current-based position": 256 turns either way."""
_TURNS = 256
_OLD_LIMITS = ("CW Angle Limit", "CCW Angle Limit")
_OLD_JOINT_MODE = 2


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class JointScale:
    """How the registers of n servos say the positions, speeds and currents of n joints."""

    names: tuple[str, ...]
    """Names of the joints, for errors."""
    zero_ticks: FloatArray
    """Position register at joint zero, shape (n,), ticks."""
    pulses_per_rad: FloatArray
    """Ticks to a radian, shape (n,), above zero."""
    velocity_unit: FloatArray
    """What one step of Present Velocity is worth, shape (n,), rad/s."""
    current_unit: FloatArray
    """What one step of Present Current is worth, shape (n,), A; NaN: the servo measures none."""
    ticks_min: FloatArray
    """Lowest Goal Position that the servo takes, shape (n,), ticks."""
    ticks_max: FloatArray
    """Highest Goal Position that the servo takes, shape (n,), ticks."""

    def __post_init__(self) -> None:
        n = len(self.names)
        for name in ("zero_ticks", "pulses_per_rad", "velocity_unit", "ticks_min", "ticks_max"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), (n,), name))
        current = np.array(self.current_unit, dtype=np.float64)
        if current.shape != (n,):
            raise ValueError(f"current_unit: want shape ({n},), got {current.shape}")
        current.flags.writeable = False
        object.__setattr__(self, "current_unit", current)
        if (self.pulses_per_rad <= 0.0).any():
            raise ValueError(f"pulses_per_rad: want above zero, got {self.pulses_per_rad}")
        if (self.ticks_min >= self.ticks_max).any():
            raise ValueError("ticks_min: want each below its ticks_max")

    @classmethod
    def of(cls, servos: Sequence[ServoSpec]) -> Self:
        """Give the scale of the joints that these servos move, one servo a joint.

        The range of ticks is that of the servo's Operating Mode; in mode 3 that of its Min and Max
        Position Limit, from its settings or the factory.

        Raises:
            ValueError: If a servo is not calibrated, or has no position, velocity and mode.
        """
        for servo in servos:
            if servo.zero_ticks is None:
                raise ValueError(f"servo {servo.name!r}: zero_ticks is None: calibrate it first")
        ranges = [position_range(servo) for servo in servos]
        models = [servo.servo_model for servo in servos]
        return cls(
            names=tuple(servo.joint or servo.name for servo in servos),
            zero_ticks=np.array([servo.zero_ticks for servo in servos], dtype=np.float64),
            pulses_per_rad=np.array([model.pulses_per_rad for model in models]),
            velocity_unit=np.array([_velocity_unit(model) * RPM for model in models]),
            current_unit=np.array([_current_unit(model) for model in models]),
            ticks_min=np.array([low for low, _ in ranges], dtype=np.float64),
            ticks_max=np.array([high for _, high in ranges], dtype=np.float64),
        )

    def first(self, n: int) -> Self:
        """Give the scale of the first n servos."""
        arrays = ("zero_ticks", "pulses_per_rad", "velocity_unit", "current_unit")
        cut = {name: getattr(self, name)[:n] for name in (*arrays, "ticks_min", "ticks_max")}
        return replace(self, names=self.names[:n], **cut)

    def to_ticks(self, q: FloatArray) -> IntArray:
        """Give the ticks nearest to joint positions, of those that the servo has.

        Half a turn either way is one tick more than a servo of one turn can count: there, and only
        by that one tick, the nearest is the last.

        Args:
            q: Position, shape (..., n), rad.

        Returns:
            Ticks, shape (..., n).

        Raises:
            LimitError: If a servo would not take them, with the joint; t is unknown.
        """
        ticks = np.rint(self.zero_ticks + np.asarray(q) * self.pulses_per_rad)
        outside = (ticks < self.ticks_min - 1.0) | (ticks > self.ticks_max + 1.0)
        if outside.any():
            self._refuse(np.broadcast_to(q, ticks.shape), ticks, outside)
        return np.clip(ticks, self.ticks_min, self.ticks_max).astype(np.int64)

    def to_nearest_ticks(self, q: FloatArray) -> IntArray:
        """Give the ticks nearest to joint positions that the servos take.

        Only for holding an arm where it already is; ``to_ticks`` refuses where this gives way.
        """
        ticks = np.rint(self.zero_ticks + np.asarray(q) * self.pulses_per_rad)
        return np.clip(ticks, self.ticks_min, self.ticks_max).astype(np.int64)

    def to_q(self, ticks: npt.ArrayLike) -> FloatArray:
        """Give joint positions.

        Args:
            ticks: Position register, shape (..., n).

        Returns:
            Position, shape (..., n), rad.
        """
        q: FloatArray = (np.asarray(ticks) - self.zero_ticks) / self.pulses_per_rad
        return q

    def to_qd(self, raw: npt.ArrayLike) -> FloatArray:
        """Give joint speeds of Present Velocity, shape (..., n), rad/s."""
        qd: FloatArray = np.asarray(raw) * self.velocity_unit
        return qd

    def to_current(self, raw: npt.ArrayLike) -> FloatArray:
        """Give currents of Present Current, shape (..., n), A; NaN where there is none."""
        current: FloatArray = np.asarray(raw) * self.current_unit
        return current

    def from_qd(self, qd: FloatArray) -> IntArray:
        """Give the register of a velocity, shape (..., n), of velocities in rad/s.

        Raises:
            ValueError: If one is not finite.
        """
        return _whole(np.asarray(qd) / self.velocity_unit, "velocity")

    def from_current(self, current: FloatArray) -> IntArray:
        """Give the register of a current, shape (..., n), of currents in A; 0 where there is none.

        Args:
            current: Current, shape (..., n), A; where a servo has none it is ignored.

        Raises:
            ValueError: If one is not finite.
        """
        raw = np.asarray(current) / self.current_unit
        return _whole(np.where(np.isnan(self.current_unit), 0.0, raw), "current")

    def _refuse(self, q: FloatArray, ticks: FloatArray, outside: npt.NDArray[np.bool_]) -> None:
        """Raise for the first joint that is outside."""
        where = tuple(int(k) for k in np.argwhere(outside)[0])
        i = where[-1]
        limit = self.ticks_max[i] if ticks[where] > self.ticks_max[i] else self.ticks_min[i]
        raise LimitError(
            self.names[i],
            "position",
            float(q[where]),
            float((limit - self.zero_ticks[i]) / self.pulses_per_rad[i]),
        )


def _whole(raw: FloatArray, name: str) -> IntArray:
    """Give the nearest whole numbers."""
    if not np.isfinite(raw).all():
        raise ValueError(f"{name}: want finite numbers, got {raw.tolist()} steps")
    return np.rint(raw).astype(np.int64)


def position_range(servo: ServoSpec) -> tuple[int, int]:
    """Give the lowest and highest Goal Position that a servo takes with its settings.

    Raises:
        ValueError: If it cannot be used as a joint: no such mode, or no such registers.
    """
    model = servo.servo_model
    mode = operating_mode(servo)
    if mode in MULTI_TURN_MODES:
        return -_TURNS * model.pulses + 1, _TURNS * model.pulses - 1
    names = ("Min Position Limit", "Max Position Limit")
    if names[0] not in model.table:
        names = _OLD_LIMITS
    limits = [servo.settings.get(name, model.table[name].initial) for name in names]
    return int(limits[0] or 0), int(limits[1] or 0)


def operating_mode(servo: ServoSpec) -> int:
    """Give the Operating Mode in which a servo shall work: its setting, or 3.

    Old models have no such register; within angle limits they are in what others call mode 3.

    Raises:
        ValueError: If it is no position mode, or the model does not have it.
    """
    model = servo.servo_model
    if "Operating Mode" not in model.table and _OLD_LIMITS[0] in model.table:
        return _mode_within_limits(servo)
    mode = servo.settings.get("Operating Mode", ONE_TURN_MODE)
    usable = [known for known in (ONE_TURN_MODE, *MULTI_TURN_MODES) if known in model.modes]
    if mode not in usable or "Operating Mode" not in model.table:
        raise ValueError(
            f"servo {servo.name!r}: want a position mode of {model.name} "
            f"({', '.join(map(str, usable)) or 'it has none'}), got {mode}"
        )
    return mode


def _mode_within_limits(servo: ServoSpec) -> int:
    """Give mode 3 for an old model that has angle limits; without them it turns for ever."""
    settings, table = servo.settings, servo.servo_model.table
    wheel = all(settings.get(name, table[name].initial) == 0 for name in _OLD_LIMITS)
    if wheel or settings.get("Control Mode", _OLD_JOINT_MODE) != _OLD_JOINT_MODE:
        raise ValueError(f"servo {servo.name!r}: want joint mode, got wheel mode")
    return ONE_TURN_MODE


def _velocity_unit(model: ServoModel) -> float:
    """Give what one step of the velocity register is worth, rev/min."""
    new = "Present Velocity" in model.table
    return _unit(model, "Present Velocity" if new else "Present Speed")


def _unit(model: ServoModel, register: str) -> float:
    """Give what one step of a register is worth."""
    scale = model.table[register].scale
    if scale is None:
        raise ValueError(f"{model.name}: the unit of {register} is not known")
    return scale


def _current_unit(model: ServoModel) -> float:
    """Give what one step of Present Current is worth, A."""
    return _unit(model, "Present Current") * 1e-3 if model.has_current else float("nan")
