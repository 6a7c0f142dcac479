"""What goes on inside a virtual servo: its registers' effects, its control loop, its faults.

Where the manual is silent, this servo does the less convenient of what servos are known to do:
Goal Position survives torque off, so that a client which switches the torque on without writing the
present position first sees the arm jump.
Source: ROBOTIS e-Manual, X series, the pages of the registers.
"""

from collections.abc import Mapping, Sequence

from splinearm.drivers.model import ServoModel
from splinearm.drivers.registers import Area

from .horn import Horn
from .law import POSITION_MODES, Mode, ServoLaw
from .memory import Change, TableMemory
from .motor import motor_of, nominal_voltage
from .rule import GOALS, WATCHDOG_TRIPPED
from .scale import REVERSE, TORQUE_ON_BY_GOAL, ServoScale, law_settings
from .sensor import MEASURED
from .shaft import Shaft

CENTRE_TICKS = 2048
"""Position at joint zero of a servo whose arm file leaves it to calibration."""

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

_WATCHDOG_UNIT = 0.02
_SUPPLY_CHECK = 0.1
_HOMING_IN_MODE_3 = 1024
_INPUT_VOLTAGE, _OVERHEATING = 0x01, 0x04
_STARTUP_TORQUE_ON = 0x01


class ServoCore:
    """A servo's inside. The plant moves ``shaft``; ``tick`` is called every millisecond."""

    def __init__(
        self,
        model: ServoModel,
        *,
        settings: Mapping[str, int],
        zero_ticks: int,
        shaft: Shaft,
    ) -> None:
        """Switch it on.

        Args:
            model: Its model.
            settings: Raw values of registers that differ from the factory's, by name. Its Drive
                Mode among them says how it is mounted: so that its position grows with the joint.
            zero_ticks: Its position at joint zero.
            shaft: Its output shaft.

        Raises:
            ValueError: If such a model cannot be simulated or a value does not fit.
        """
        self.model = model
        self.scale = ServoScale.of(model)
        self.shaft = shaft
        self.memory = TableMemory(model.table)
        self.voltage = nominal_voltage(model)
        """Supply, V; outside its limits the servo reports an error."""
        self.temperature = 30.0
        """Temperature inside, degC; above its limit the servo reports an error."""
        self.now = 0.0
        """The time that it knows, s."""
        self.law: ServoLaw
        """Its control loop."""
        self.torque_on: bool
        """Whether its motor is driven."""
        self.shut_down: bool
        """Whether a hardware error has cut the torque until a reboot."""
        self.duty: float
        """What it gives its motor, -1..1, in the direction of its position."""
        self._watchdog: float
        self._on_since: float
        self._heard_at: float
        self._next_supply_check: float
        self._motor = motor_of(model)
        for name, value in settings.items():
            self.memory[name] = value
        self._horn = Horn(
            self.scale.per_rad,
            model.pulses,
            reverse=bool(self.memory["Drive Mode"] & REVERSE),
            at_zero=zero_ticks - self._homing(),
        )
        self.measured = [(model.table[n], MEASURED[n]) for n in MEASURED if n in model.table]
        """The registers it measures by itself, and how."""
        self._power_on(settings)

    @property
    def tripped(self) -> bool:
        """Whether its bus watchdog has tripped."""
        return self.memory["Bus Watchdog"] == WATCHDOG_TRIPPED

    @property
    def uptime(self) -> float:
        """Time since it was switched on or rebooted, s."""
        return self.now - self._on_since

    @property
    def position(self) -> int:
        """Where it is, ticks."""
        return self._horn.position(self.shaft.angle)

    @property
    def speed(self) -> float:
        """How fast it turns, ticks/s."""
        return self._horn.speed(self.shaft.speed)

    @property
    def motor_current(self) -> float:
        """Current of its motor, A."""
        return self.law.current(self.duty, self.speed) if self.torque_on else 0.0

    def value(self, name: str) -> int:
        """Give what a register holds now."""
        if name in MEASURED:
            self.memory.show(name, MEASURED[name](self))
        return self.memory[name]

    def tick(self, now: float) -> None:
        """Let a millisecond go by: measure, and drive the motor."""
        self.watch(now)
        if self.torque_on:
            self.duty = self.law.tick(self.position, self.speed)
            self.shaft.duty = self._horn.direction * self.duty

    def watch(self, now: float) -> None:
        """Let the time be ``now``: look after watchdog and supply without driving the motor."""
        self.now = now
        if self._watchdog and self.torque_on and now - self._heard_at > self._watchdog:
            self._trip()
        if now >= self._next_supply_check:
            self._next_supply_check = now + _SUPPLY_CHECK
            self._check_supply()

    def heard(self) -> None:
        """Take note of an instruction packet on the bus, to whomever it went."""
        self._heard_at = self.now

    def hardware_error(self, bits: int) -> None:
        """Let a hardware error happen; those that Shutdown names cut the torque until a reboot."""
        self.memory["Hardware Error Status"] |= bits
        if bits & self.memory["Shutdown"]:
            self.shut_down = True
            self._release()

    def forget_turns(self) -> None:
        """Let the position lie within one turn from here on."""
        self._horn.fold(self.shaft.angle)
        if self.torque_on:
            self.law.rest_at(self.position)

    def apply(self, changes: Sequence[Change]) -> None:
        """Write registers, without asking whether that is allowed, and let each have its effect."""
        before = {register.name: self.memory[register.name] for register, _ in changes}
        for register, value in changes:
            self.memory[register.name] = value
        if not GOALS.issuperset(before):
            self._take_settings(before)
        for name in before:
            if name in GOALS:
                self._take_goal(name)
        if "Torque Enable" in before:
            self._switch(on=bool(self.memory["Torque Enable"]))

    def _power_on(self, kept: Mapping[str, int]) -> None:
        """Begin with RAM as after a loss of power, but for the registers that are kept."""
        memory = self.memory
        memory.reset(memory.of(Area.RAM))
        for name, value in kept.items():
            memory[name] = value
        self.torque_on = self.shut_down = False
        self.duty = 0.0
        self.shaft.duty = None
        self._on_since = self._heard_at = self._next_supply_check = self.now
        self._turn_horn()
        self._horn.fold(self.shaft.angle)
        self._reset_goals()
        for name in GOALS & kept.keys():
            memory[name] = kept[name]
        self.law = ServoLaw(
            law_settings(memory, self.scale),
            no_load_speed=self._motor.no_load_speed * self.scale.per_rad,
            stall_current=self._motor.stall_current or 1.0,
        )
        self._arm_watchdog()
        self._switch(
            on=bool(memory["Torque Enable"])
            or bool(memory.get("Startup Configuration") & _STARTUP_TORQUE_ON)
        )

    def _take_settings(self, before: Mapping[str, int]) -> None:
        """Let what was written that is no goal have its effect; ``before`` holds what was there."""
        memory = self.memory
        mode = memory["Operating Mode"]
        new_mode = before.get("Operating Mode", mode) != mode
        self._turn_horn()
        if new_mode or "Drive Mode" in before:
            self._horn.fold(self.shaft.angle)
        if new_mode:
            memory.reset(memory.table[name] for name in GAINS)
            memory["Profile Velocity"] = memory["Profile Acceleration"] = 0
            self._reset_goals()
        if "Bus Watchdog" in before:
            self._arm_watchdog()
        self.law.settings = law_settings(memory, self.scale)

    def _take_goal(self, name: str) -> None:
        """Let a new goal have its effect."""
        if name in ("Goal PWM", "Goal Current"):
            self.law.settings = law_settings(self.memory, self.scale)
        if name != self._goal or self.shut_down:
            return
        if not self.torque_on and self.memory["Drive Mode"] & TORQUE_ON_BY_GOAL:
            self._switch(on=True)
        if self.torque_on:
            self._aim()

    @property
    def _goal(self) -> str:
        """Name of the register that the operating mode follows."""
        mode = self.memory["Operating Mode"]
        if mode in POSITION_MODES:
            return "Goal Position"
        if mode == Mode.CURRENT:
            return "Goal Current"
        return "Goal Velocity" if mode == Mode.VELOCITY else "Goal PWM"

    def _aim(self) -> None:
        """Let the control loop have the goal of the operating mode."""
        law, value = self.law, self.memory[self._goal]
        match self._goal:
            case "Goal Position":
                law.aim_at(value)
            case "Goal Velocity":
                law.goal_velocity = value * self.scale.velocity
            case "Goal Current":
                law.goal_current = value * self.scale.current
            case _:
                law.goal_duty = value / self.scale.full_pwm

    def _switch(self, *, on: bool) -> None:
        """Switch the torque on or off, if it is not so already."""
        if not on:
            self._release()
        elif not self.torque_on:
            self.torque_on = True
            self.memory["Torque Enable"] = 1
            if self.memory["Operating Mode"] == Mode.POSITION:
                self._horn.fold(self.shaft.angle)
            self._heard_at = self.now
            self.law.rest_at(self.position)
            if not self.tripped:
                self._aim()

    def _release(self) -> None:
        """Cut the motor off."""
        self.torque_on = False
        self.memory["Torque Enable"] = 0
        self.duty = 0.0
        self.shaft.duty = None
        self.law.rest_at(self.position)

    def _reset_goals(self) -> None:
        """Set the goals so that nothing moves, and those that limit this mode to their limits.

        The manual has Goal PWM and Goal Current go to their limits in every mode; in the modes that
        follow them that would be full speed ahead, so there they are 0.
        """
        memory = self.memory
        mode = memory["Operating Mode"]
        memory["Goal PWM"] = 0 if mode == Mode.PWM else memory["PWM Limit"]
        if "Goal Current" in memory:
            memory["Goal Current"] = 0 if mode == Mode.CURRENT else memory["Current Limit"]
        memory["Goal Velocity"] = 0
        memory["Goal Position"] = self.position

    def _homing(self) -> int:
        """Give the homing offset that counts: in mode 3 one of over a quarter turn does not."""
        homing = self.memory["Homing Offset"]
        one_turn = self.memory["Operating Mode"] == Mode.POSITION
        return 0 if one_turn and abs(homing) > _HOMING_IN_MODE_3 else homing

    def _turn_horn(self) -> None:
        """Let the horn know Drive Mode and Homing Offset."""
        reverse = bool(self.memory["Drive Mode"] & REVERSE)
        self._horn.set_up(reverse=reverse, homing=self._homing())

    def _arm_watchdog(self) -> None:
        """Begin to watch the bus, or cease to."""
        self._watchdog = self.memory["Bus Watchdog"] * _WATCHDOG_UNIT
        self._heard_at = self.now

    def _trip(self) -> None:
        """Stop, and close the goals until the watchdog is cleared."""
        self._watchdog = 0.0
        self.memory["Bus Watchdog"] = WATCHDOG_TRIPPED
        self.law.goal_velocity = self.law.goal_current = self.law.goal_duty = 0.0
        self.law.rest_at(self.position)

    def _check_supply(self) -> None:
        """Report a supply or a temperature outside its limits."""
        memory, decivolt = self.memory, 10.0 * self.voltage
        if not memory["Min Voltage Limit"] <= decivolt <= memory["Max Voltage Limit"]:
            self.hardware_error(_INPUT_VOLTAGE)
        if self.temperature > memory["Temperature Limit"]:
            self.hardware_error(_OVERHEATING)
