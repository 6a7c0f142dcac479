"""What goes on inside a virtual servo: its registers' effects and its control loop, over time.

Source: ROBOTIS e-Manual, the pages of the registers. What they leave open is in ``choice``, what
can go wrong in ``fault``.
"""

from collections.abc import Iterable, Mapping

from splinearm.drivers.model import ServoModel
from splinearm.drivers.registers import Area

from .choice import Choices, TripStop
from .controls import Controls, controls_of
from .event import ASKED, EventKind, EventLog
from .firmware import newest_firmware, table_of
from .gear import Gear
from .heat import AMBIENT, Heat
from .horn import Horn, Potentiometer
from .law import POSITION_MODES, Mode, ServoLaw
from .memory import Change, TableMemory
from .motor import motor_of, nominal_voltage
from .rule import WATCHDOG_TRIPPED
from .scale import ServoScale
from .shaft import TIMESTEP, Shaft
from .supply import IDLE_CURRENT, Supply
from .trace import Trace

JUMP_ANGLE = 0.1
"""A goal so far from the trajectory, without a profile to go there, is a jump, rad."""

LOOK_TIME = 0.02
"""How often a servo looks at its supply, temperature and load, s."""

_WATCHDOG_UNIT = 0.02
_STARTUP_TORQUE_ON = 0x01
_LEAST_STRENGTH = 1e-3


class ServoCore:
    """A servo's inside. The plant moves ``shaft``; ``tick`` is called every millisecond."""

    _gear: Gear | None = None
    _overloaded_for = 0.0
    _strength = 1.0

    def __init__(
        self,
        model: ServoModel,
        *,
        settings: Mapping[str, int],
        zero_ticks: int | None,
        shaft: Shaft,
        choices: Choices,
    ) -> None:
        """Switch it on.

        Args:
            model: Its model.
            settings: Raw values of registers that differ from the factory's, by name. Its Drive
                Mode among them says how it is mounted: so that its position grows with the joint.
            zero_ticks: Its position at joint zero; None: mid travel.
            shaft: Its output shaft.
            choices: How it does what its manual leaves open.

        Raises:
            ValueError: If such a model cannot be simulated or a value does not fit.
        """
        self.model = model
        self.scale = ServoScale.of(model)
        self.shaft = shaft
        self.choices = choices
        """How it does what its manual leaves open."""
        self.temperature = AMBIENT
        """Temperature inside, degC."""
        self.heat = Heat()
        """How it gets warm."""
        self.current_offset = 0.0
        """What its current sensor says too much, A."""
        self.events = EventLog()
        """What happened to it."""
        self.trace: Trace | None = None
        """Where its shaft was, if someone wants it written down."""
        self.supply: Supply | None = None
        """What it is fed by, with others, if it hangs on a rig."""
        self.now = 0.0
        """The time that it knows, s."""
        self.law: ServoLaw
        """Its control loop."""
        self.torque_on = False
        """Whether its motor is driven."""
        self.shut_down = False
        """Whether a hardware error has cut the torque until a reboot."""
        self.alarms = 0
        """The hardware errors that stand, as its model's status says them."""
        self.duty = 0.0
        """What it gives its motor, -1..1 of its supply, in the direction of its position."""
        self.stirred = False
        """Whether something was done to it by hand, so that it may move."""
        self._watchdog = self._heard_at = self._on_since = 0.0
        self._looked_at = 0.0
        self._motor = motor_of(model)
        self._nominal = self._voltage = nominal_voltage(model)
        self._fill_table(settings.get("Firmware Version", newest_firmware(model)), settings)
        self._horn = self._mounted(model.centre if zero_ticks is None else zero_ticks)
        self._power_on(settings, "power on")

    @property
    def voltage(self) -> float:
        """Its supply, V: the motor has as much of its torque and speed as that allows."""
        return self._voltage

    @voltage.setter
    def voltage(self, value: float) -> None:
        self._voltage = value
        self._strength = self.law.strength = max(value / self._nominal, _LEAST_STRENGTH)

    @property
    def tripped(self) -> bool:
        """Whether its bus watchdog has tripped."""
        return self.memory.get("Bus Watchdog") == WATCHDOG_TRIPPED

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

    @property
    def load(self) -> float:
        """Current of its motor as a share of the stall current."""
        return abs(self.motor_current) / self.law.stall_current

    @property
    def supply_current(self) -> float:
        """What it takes from its supply, A: a chopped motor takes its current by the duty."""
        return IDLE_CURRENT + max(self.motor_current * self.duty, 0.0)

    def value(self, name: str) -> int:
        """Give what a register holds now."""
        measure = self.controls.measured.get(name)
        if measure is not None:
            self.memory.show(name, measure(self))
        return self.memory[name]

    def tick(self, now: float) -> None:
        """Let a millisecond go by: measure, and drive the motor."""
        self.watch(now)
        shaft = self.shaft
        if self.torque_on:
            horn = self._horn
            self.duty = duty = self.law.tick(horn.position(shaft.angle), horn.speed(shaft.speed))
            drive = horn.direction * self._strength * duty
            if self._gear is None:
                shaft.duty = drive
            else:
                shaft.duty = self._gear.pass_on(drive, shaft.speed, TIMESTEP)
        if self.trace is not None:
            self.trace.add(now, shaft.angle, shaft.speed, self.torque_on)

    def watch(self, now: float) -> None:
        """Let the time be ``now``: look after bus and supply without driving the motor."""
        self.now = now
        if self._watchdog and self.torque_on and now - self._heard_at > self._watchdog:
            self._trip()
        if now - self._looked_at >= LOOK_TIME:
            self.look(now - self._looked_at)
            self._looked_at = now

    def look(self, duration: float) -> None:
        """Look after what took effect in the time before: for those who build upon this class."""

    def heard(self) -> None:
        """Take note of an instruction packet on the bus, to whomever it went."""
        self._heard_at = self.now

    def forget_turns(self) -> None:
        """Let the position lie within one turn from here on."""
        self._horn.fold(self.shaft.angle)
        if self.torque_on:
            self.law.rest_at(self.position)

    def apply(self, changes: Iterable[Change]) -> None:
        """Write registers, without asking whether that is allowed, and let each have its effect."""
        memory, controls = self.memory, self.controls
        names = set()
        for register, value in changes:
            names.add(register.name)
            memory[register.name] = value
        if not controls.plain_goals.issuperset(names):
            self._take_settings(names)
        goal = controls.goal
        if goal in names and not self.shut_down:
            if not self.torque_on and self._switches_on(goal):
                self._switch(on=True, cause="a goal")
            elif self.torque_on:
                self._aim()
        if controls.wants_torque != self.torque_on:
            self._switch(on=controls.wants_torque, cause=ASKED)

    def release(self, cause: str) -> None:
        """Cut the motor off."""
        if self.torque_on:
            self.events.add(self.now, EventKind.TORQUE_OFF, cause)
        self.torque_on = False
        self.duty = 0.0
        self.shaft.duty = None
        self.law.release(self.position)

    def _fill_table(self, firmware: int, settings: Mapping[str, int]) -> None:
        """Begin with the registers of a firmware, as from the factory but for some."""
        self.memory = TableMemory(table_of(self.model, firmware))
        self.memory["Firmware Version"] = firmware
        for name, value in settings.items():
            self.memory[name] = value
        self.controls: Controls = controls_of(self.model, self.memory, self.scale)

    def _mounted(self, zero_ticks: int) -> Horn:
        """Give the horn on the shaft, with that position at joint zero."""
        kind = Horn if "Homing Offset" in self.memory else Potentiometer
        one_turn = self.memory.table["Goal Position"].signed and self.model.centre == 0
        return kind(
            self.scale.per_rad,
            self.model.pulses,
            reverse=self.controls.reversed,
            at_zero=zero_ticks - self.controls.homing(),
            lowest=-self.model.pulses // 2 if one_turn else 0,
        )

    def _power_on(self, kept: Mapping[str, int], cause: str) -> None:
        """Begin with RAM as after a loss of power, but for the registers that are kept."""
        memory, controls = self.memory, self.controls
        if self.torque_on:
            self.release(cause)
        memory.reset(memory.of(Area.RAM))
        controls.reset_gains()
        for name, value in kept.items():
            memory[name] = value
        self.shut_down = False
        self.alarms = 0
        self.duty = self._overloaded_for = 0.0
        self.shaft.duty = None
        self._on_since = self._heard_at = self.now
        self._mode = controls.mode
        self._turn_horn()
        self._horn.fold(self.shaft.angle)
        controls.reset_goals(self.position)
        for name in controls.goals & kept.keys():
            memory[name] = kept[name]
        self.law = ServoLaw(
            controls.law_settings(),
            no_load_speed=self._motor.no_load_speed * self.scale.per_rad,
            stall_current=self._motor.stall_current or 1.0,
        )
        self.law.strength = self._strength
        self._arm_watchdog()
        if controls.wants_torque or memory.get("Startup Configuration") & _STARTUP_TORQUE_ON:
            self._switch(on=True, cause="start-up")

    def _take_settings(self, names: set[str]) -> None:
        """Let what was written that is no goal have its effect."""
        controls = self.controls
        mode = controls.mode
        new_mode, self._mode = mode != self._mode, mode
        self._turn_horn()
        if new_mode or "Drive Mode" in names:
            self._horn.fold(self.shaft.angle)
        if new_mode:
            controls.change_mode()
            controls.reset_goals(self.position)
        if "Bus Watchdog" in names:
            self._arm_watchdog()
        self.law.settings = controls.law_settings()

    def _switches_on(self, goal: str) -> bool:
        """Tell whether a goal switches the torque on."""
        if self.controls.torque_by_goal:
            return True
        by_choice = self.choices.torque_on_by_goal and "Drive Mode" not in self.memory
        return by_choice and goal == "Goal Position"

    def _aim(self) -> None:
        """Let the control loop have the goal of the operating mode."""
        if self.law.settings.top_velocity == 0.0 and self._mode in POSITION_MODES:
            jump = self.memory["Goal Position"] - self.law.position
            if abs(jump) > JUMP_ANGLE * self.scale.per_rad:
                self.events.add(self.now, EventKind.GOAL_JUMP, f"{jump:.0f} ticks")
        self.law.go_on()
        self.controls.aim(self.law)

    def _switch(self, *, on: bool, cause: str) -> None:
        """Switch the torque on or off, if it is not so already."""
        if not on:
            self.release(cause)
        elif not self.torque_on:
            self.torque_on = True
            self.memory["Torque Enable"] = 1
            self.events.add(self.now, EventKind.TORQUE_ON, cause)
            if self._mode == Mode.POSITION:
                self._horn.fold(self.shaft.angle)
            self._heard_at = self.now
            self.law.rest_at(self.position)
            if not self.choices.goal_survives_torque_off and cause == ASKED:
                self.memory["Goal Position"] = self.position
            if not self.tripped:
                self._aim()

    def _turn_horn(self) -> None:
        """Let the horn know Drive Mode and Homing Offset."""
        self._horn.set_up(reverse=self.controls.reversed, homing=self.controls.homing())

    def _arm_watchdog(self) -> None:
        """Begin to watch the bus, or cease to."""
        value = self.memory.get("Bus Watchdog")
        self._watchdog = 0.0 if value == WATCHDOG_TRIPPED else value * _WATCHDOG_UNIT
        self._heard_at = self.now

    def _trip(self) -> None:
        """Close the goals until the watchdog is cleared, and stop."""
        self._watchdog = 0.0
        self.memory["Bus Watchdog"] = WATCHDOG_TRIPPED
        how = self.choices.on_trip
        self.events.add(self.now, EventKind.WATCHDOG_TRIP, how.value)
        law = self.law
        if how is TripStop.GO_ON:
            return
        if how is TripStop.BY_HOMING_OFFSET and self._mode in POSITION_MODES:
            law.rest_at(self.position - self.controls.homing())
        elif how is TripStop.HOLD:
            law.goal_velocity = law.goal_current = law.goal_duty = 0.0
            law.rest_at(self.position)
        else:
            law.brake(self.speed)
