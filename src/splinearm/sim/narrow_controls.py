"""The registers of servos with a small table: AX-12A and XL-320.

They have a joint mode and a wheel mode, Moving Speed for both, and Torque Limit, which limits the
PWM and goes to 0 when a hardware error cuts the torque.
Source: ROBOTIS e-Manual, AX-12A and XL-320, the pages of the registers.

Left open there and assumed here: how P, I and D of an XL-320 act on the output. Its manual gives
"P Gain / 8" without a unit, and a table by which P of 32 does what a slope of 32 ticks did; the
latter is taken, the others in the manual's proportion to it. Punch of an XL-320 does nothing.
"""

from collections.abc import Callable, Mapping

from splinearm.drivers.model import ServoModel

from .compliance import Compliance, representative_slope
from .law import LawSettings, Mode, ServoLaw
from .memory import TableMemory
from .mode import mode_of
from .scale import ServoScale
from .sensor import Sensed

_CLOCKWISE = 0x400
_MOST = 0x3FF
_MOVING = 5


def signed_of(value: int) -> int:
    """Give the number that ten bits and a direction bit say."""
    return -(value & _MOST) if value & _CLOCKWISE else value & _MOST


def bits_of(value: float) -> int:
    """Give ten bits and a direction bit for a number, at the end stop if it does not fit."""
    size = min(round(abs(value)), _MOST)
    return size | _CLOCKWISE if value < 0.0 and size else size


def _speed(servo: Sensed) -> float:
    return bits_of(servo.speed / servo.scale.velocity)


def _load(servo: Sensed) -> float:
    """Give the load: the manual says that it is inferred from the output."""
    return bits_of(1000.0 * servo.duty)


def _moving(servo: Sensed) -> float:
    return servo.law.profile_ongoing or abs(servo.speed) > _MOVING * servo.scale.velocity


_MEASURED: Mapping[str, Callable[[Sensed], float]] = {
    "Present Position": lambda servo: servo.position,
    "Present Speed": _speed,
    "Present Load": _load,
    "Present Voltage": lambda servo: 10.0 * servo.voltage,
    "Present Temperature": lambda servo: servo.temperature,
    "Moving": _moving,
}


class NarrowControls:
    """See ``Controls``."""

    goals = frozenset(("Goal Position", "Moving Speed"))
    plain_goals = frozenset(("Goal Position",))
    keeps_shut = False
    reversed = False
    torque_by_goal = False

    def __init__(self, model: ServoModel, memory: TableMemory, scale: ServoScale) -> None:
        self._model = model
        self._memory = memory
        self._scale = scale
        self.measured = _MEASURED

    @property
    def mode(self) -> int:
        """The operating mode."""
        return mode_of(self._memory)

    @property
    def goal(self) -> str:
        """Name of the register that the mode follows."""
        return "Goal Position" if self.mode == Mode.POSITION else "Moving Speed"

    @property
    def wants_torque(self) -> bool:
        """Whether the motor shall be driven."""
        return bool(self._memory["Torque Enable"]) and self._memory["Torque Limit"] > 0

    @property
    def eeprom_locked(self) -> bool:
        """Whether EEPROM is locked whatever the torque."""
        return bool(self._memory.get("Lock"))

    def homing(self) -> int:
        """Give the offset of the position that counts."""
        return 0

    def law_settings(self) -> LawSettings:
        """Give what the registers say about the control loop."""
        memory, scale = self._memory, self._scale
        p, i, d = self._gains()
        return LawSettings(
            mode=self.mode,
            p=p,
            i=i,
            d=d,
            ff1=0.0,
            ff2=0.0,
            vp=0.0,
            vi=0.0,
            velocity_unit=scale.velocity,
            full_pwm=float(scale.full_pwm),
            duty_limit=min(memory["Torque Limit"], memory["Max Torque"]) / scale.full_pwm,
            current_limit=float("inf"),
            top_velocity=(memory["Moving Speed"] & _MOST) * scale.velocity,
            acceleration=0.0,
            time_based=False,
            compliance=self._compliance(),
        )

    def aim(self, law: ServoLaw) -> None:
        """Let the control loop have the goal of the mode."""
        if self.mode == Mode.POSITION:
            law.aim_at(self._memory["Goal Position"])
        else:
            law.goal_duty = signed_of(self._memory["Moving Speed"]) / self._scale.full_pwm

    def reset_goals(self, position: int) -> None:
        """Set the goals so that nothing moves, and Torque Limit to its initial value."""
        memory = self._memory
        memory["Goal Position"] = position
        memory["Moving Speed"] = 0
        memory["Torque Limit"] = memory["Max Torque"]

    def reset_gains(self) -> None:
        """Gains are the same in both modes."""

    def change_mode(self) -> None:
        """Nothing else changes."""

    def cut(self) -> None:
        """Say in the registers that a hardware error has cut the torque."""
        self._memory["Torque Limit"] = 0

    def _gains(self) -> tuple[float, float, float]:
        """Give P, I and D of an XL-320; see the top of this file."""
        memory = self._memory
        if "P Gain" not in memory:
            return 0.0, 0.0, 0.0
        p = float(memory["P Gain"])
        # manual: Kp = P / 8, Ki = I * 1000 / 2048 a second, Kd = D * 4 / 1000 s; here 8 times that
        return p, memory["I Gain"] * 8.0 / 2048.0, memory["D Gain"] * 32.0

    def _compliance(self) -> Compliance | None:
        memory = self._memory
        if "CW Compliance Slope" not in memory:
            return None
        return Compliance(
            margin_below=memory["CW Compliance Margin"],
            margin_above=memory["CCW Compliance Margin"],
            slope_below=representative_slope(memory["CW Compliance Slope"]),
            slope_above=representative_slope(memory["CCW Compliance Slope"]),
            punch=memory["Punch"],
            full=float(self._scale.full_pwm),
        )
