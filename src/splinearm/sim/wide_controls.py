"""The registers of servos with operating modes: X, MX with the 2.0 firmware, and P."""

from collections.abc import Callable, Mapping
from math import inf

from splinearm.drivers.model import ServoModel

from .law import POSITION_MODES, LawSettings, Mode, ServoLaw
from .memory import TableMemory
from .motor import motor_of, nominal_voltage
from .scale import MILLI, REVERSE, TIME_BASED, TORQUE_ON_BY_GOAL, ServoScale
from .sensor import MEASURED, Sensed

GAINS = (
    "Velocity I Gain",
    "Velocity P Gain",
    "Position D Gain",
    "Position I Gain",
    "Position P Gain",
    "Feedforward 2nd Gain",
    "Feedforward 1st Gain",
)
"""Registers that a change of the operating mode gives back their initial values."""

_GOALS = frozenset(("Goal PWM", "Goal Current", "Goal Velocity", "Goal Position"))


class WideControls:
    """See ``Controls``."""

    goals = _GOALS
    plain_goals = frozenset(("Goal Velocity", "Goal Position"))
    keeps_shut = True
    eeprom_locked = False

    def __init__(self, model: ServoModel, memory: TableMemory, scale: ServoScale) -> None:
        self._memory = memory
        self._scale = scale
        self._quarter = model.pulses // 4
        self._slew = _slew(model, memory)
        self._braking = _braking(model, scale)
        self.measured: Mapping[str, Callable[[Sensed], float]] = {
            name: MEASURED[name] for name in MEASURED if name in memory
        }

    @property
    def mode(self) -> int:
        """The operating mode."""
        return self._memory["Operating Mode"]

    @property
    def goal(self) -> str:
        """Name of the register that the mode follows."""
        mode = self.mode
        if mode in POSITION_MODES:
            return "Goal Position"
        if mode == Mode.CURRENT:
            return "Goal Current"
        return "Goal Velocity" if mode == Mode.VELOCITY else "Goal PWM"

    @property
    def reversed(self) -> bool:
        """Whether the direction is turned round."""
        return bool(self._memory["Drive Mode"] & REVERSE)

    @property
    def torque_by_goal(self) -> bool:
        """Whether a goal switches the torque on."""
        return bool(self._memory["Drive Mode"] & TORQUE_ON_BY_GOAL)

    @property
    def wants_torque(self) -> bool:
        """Whether the motor shall be driven."""
        return bool(self._memory["Torque Enable"])

    def homing(self) -> int:
        """Give the homing offset that counts: in mode 3 one of over a quarter turn does not."""
        homing = self._memory["Homing Offset"]
        return 0 if self.mode == Mode.POSITION and abs(homing) > self._quarter else homing

    def law_settings(self) -> LawSettings:
        """Give what the registers say about the control loop."""
        memory, scale, mode = self._memory, self._scale, self.mode
        time_based = bool(memory["Drive Mode"] & TIME_BASED)
        pwm = memory["PWM Limit"]
        if mode != Mode.PWM:
            pwm = min(pwm, abs(memory["Goal PWM"]))
        top_velocity, acceleration = self._profile(time_based=time_based)
        return LawSettings(
            mode=mode,
            p=memory["Position P Gain"] / 128.0,
            i=memory["Position I Gain"] / 65536.0,
            d=memory["Position D Gain"] / 16.0,
            ff1=memory["Feedforward 1st Gain"] / 4.0,
            ff2=memory["Feedforward 2nd Gain"] / 4.0,
            vp=memory["Velocity P Gain"] / 128.0,
            vi=memory["Velocity I Gain"] / 65536.0,
            velocity_unit=scale.velocity,
            full_pwm=float(scale.full_pwm),
            duty_limit=pwm / scale.full_pwm,
            current_limit=self._current_limit() if mode == Mode.CURRENT_POSITION else inf,
            current_unit=scale.current or 1.0,
            top_velocity=top_velocity,
            acceleration=acceleration,
            time_based=time_based,
            slew=memory["PWM Slope"] * self._slew if self._slew else inf,
        )

    def aim(self, law: ServoLaw) -> None:
        """Let the control loop have the goal of the mode."""
        name, scale = self.goal, self._scale
        value = self._memory[name]
        match name:
            case "Goal Position":
                law.aim_at(value)
            case "Goal Velocity":
                law.goal_velocity = value * scale.velocity
            case "Goal Current":
                law.goal_current = value * scale.current
            case _:
                law.goal_duty = value / scale.full_pwm

    def reset_goals(self, position: int) -> None:
        """Set the goals so that nothing moves, and those that limit this mode to their limits.

        The manual has Goal PWM and Goal Current go to their limits in every mode; in the modes that
        follow them that would be full speed ahead, so there they are 0.
        """
        memory, mode = self._memory, self.mode
        memory["Goal PWM"] = 0 if mode == Mode.PWM else memory["PWM Limit"]
        if "Goal Current" in memory:
            memory["Goal Current"] = 0 if mode == Mode.CURRENT else memory["Current Limit"]
        memory["Goal Velocity"] = 0
        memory["Goal Position"] = position

    def reset_gains(self) -> None:
        """Give the gains the values of the mode; the manual says "properly", and no numbers.

        In mode 5 the motor's own voltage does not brake: there D is assumed to do what that does in
        the other modes, else nothing would end a swing.
        """
        memory = self._memory
        memory.reset(memory.table[name] for name in GAINS)
        if self.mode == Mode.CURRENT_POSITION:
            memory["Position D Gain"] = self._braking

    def change_mode(self) -> None:
        """Let a new mode have its effect on other registers."""
        memory = self._memory
        self.reset_gains()
        memory["Profile Velocity"] = memory["Profile Acceleration"] = 0

    def cut(self) -> None:
        """Say in the registers that a hardware error has cut the torque."""
        self._memory["Torque Enable"] = 0

    def _current_limit(self) -> float:
        memory = self._memory
        return self._scale.current * min(memory["Current Limit"], abs(memory["Goal Current"]))

    def _profile(self, *, time_based: bool) -> tuple[float, float]:
        """Give top velocity and acceleration, or total time and time of a ramp."""
        memory, scale = self._memory, self._scale
        velocity, acceleration = memory["Profile Velocity"], memory["Profile Acceleration"]
        if time_based:
            return velocity * MILLI, acceleration * MILLI
        velocity = min(velocity, memory["Velocity Limit"])
        return velocity * scale.velocity, acceleration * scale.acceleration


def _braking(model: ServoModel, scale: ServoScale) -> int:
    """Give the D gain whose current is that which the motor's own voltage takes away; 0: none."""
    motor = motor_of(model)
    if not scale.current or not motor.stall_current:
        return 0
    amps = motor.stall_current / (motor.no_load_speed * scale.per_rad * MILLI)
    return round(16.0 * amps / scale.current)


def _slew(model: ServoModel, memory: TableMemory) -> float:
    """Give by how much a step of PWM Slope lets the duty change in a millisecond; 0: no such limit.

    Its unit is mV/ms; of which supply the manual does not say, so of the nominal one.
    """
    if "PWM Slope" not in memory:
        return 0.0
    return (memory.table["PWM Slope"].scale or 0.0) * MILLI / nominal_voltage(model)
