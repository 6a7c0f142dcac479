"""What can go wrong inside a servo, each to be set while it runs.

Hold the bus' ``lock`` while setting any of these from another thread than the bus' own.
"""

from splinearm.drivers.registers import Area

from .alarm import ALARMS, INPUT_VOLTAGE, OVERHEATING, OVERLOAD, alarm_bit
from .core import ServoCore
from .event import EventKind
from .firmware import table_of
from .gear import Gear


class FaultyServo(ServoCore):
    """A servo that gets hot, is overloaded, loses its power, sticks and slips."""

    _deaf_until = 0.0
    _encoder_dead = False

    def look(self, duration: float) -> None:
        """Look at temperature, load and supply."""
        load = self.load
        self.temperature = self.heat.after(self.temperature, load, duration)
        overloaded = load >= self.choices.overload_share
        self._overloaded_for = self._overloaded_for + duration if overloaded else 0.0
        standing = self._standing()
        gone = self.alarms & self._passing() & ~standing
        if gone and not self.shut_down:
            self._show_alarms(self.alarms & ~gone)
        # a servo that keeps nothing shut is cut off anew as long as the error stands
        fresh = standing & ~self.alarms
        if fresh or (standing & self.memory["Shutdown"] and self.torque_on):
            self.hardware_error(standing)

    def hardware_error(self, bits: int) -> None:
        """Let hardware errors happen; those that Shutdown names cut the torque.

        X servos then need a reboot; AX-12A and XL-320 have their Torque Limit at 0 until it is
        written again.
        """
        names = ", ".join(self.model.hardware_errors(bits))
        if bits & ~self.alarms:
            self.events.add(self.now, EventKind.HARDWARE_ERROR, names)
        self._show_alarms(self.alarms | bits)
        if bits & self.memory["Shutdown"]:
            self.shut_down = self.controls.keeps_shut
            self.controls.cut()
            self.release(names)

    def fail(self, *names: str) -> None:
        """Let hardware errors happen by their names, as in ``alarm.ALARMS``.

        Raises:
            ValueError: If there is no such error, or this model does not have it.
        """
        bits = 0
        for name in names:
            bit = alarm_bit(self.model, name) if name in ALARMS else 0
            if not bit:
                known = ", ".join(error for error in ALARMS if alarm_bit(self.model, error))
                raise ValueError(f"{self.model.name}: want one of {known}, got {name!r}")
            bits |= bit
        self.hardware_error(bits)

    @property
    def stuck(self) -> bool:
        """Whether something holds its shaft fast."""
        return self.shaft.stuck

    @stuck.setter
    def stuck(self, value: bool) -> None:
        self.shaft.stuck = value
        self._mechanical("stuck" if value else "free again")

    @property
    def backlash(self) -> float:
        """Play of its gear, rad."""
        return 0.0 if self._gear is None else self._gear.play

    @backlash.setter
    def backlash(self, play: float) -> None:
        self._gear = Gear(play, self._motor.no_load_speed) if play > 0.0 else None
        self._mechanical(f"backlash {play:.4g} rad")

    @property
    def encoder_dead(self) -> bool:
        """Whether its encoder goes on seeing the angle at which it died, and no speed."""
        return self._encoder_dead

    @encoder_dead.setter
    def encoder_dead(self, value: bool) -> None:
        self._encoder_dead = value
        self._horn.freeze(self.shaft.angle if value else None)
        self._mechanical("dead encoder" if value else "encoder again")

    def slip(self, angle: float) -> None:
        """Let its horn slip: it reads as if the joint were ``angle`` (rad) further than it is."""
        self._horn.slip(angle)
        self._mechanical(f"slip {angle:.4g} rad")

    def power_cycle(self, off_for: float = 0.0) -> None:
        """Lose the power and have it again after a time, s: RAM, turns and torque are gone."""
        self.begin_anew({}, "loss of power", off_for)

    def reflash(self, firmware: int) -> None:
        """Give it another firmware; EEPROM stays, and it starts anew.

        An XL330 has other indirect addresses before firmware 53.
        """
        old = self.memory
        table = table_of(self.model, firmware)
        kept = {r.name: old[r.name] for r in old.of(Area.EEPROM) if r.name in table}
        self._fill_table(firmware, {**kept, "Firmware Version": firmware})
        self.begin_anew({}, "new firmware")

    def swap(self, slipped: float = 0.0) -> None:
        """Put a new servo of that model in its place: factory settings, id and baud rate included.

        Args:
            slipped: By how much its horn sits otherwise on the joint, rad.
        """
        firmware = self.memory["Firmware Version"]
        self._fill_table(firmware, {})
        self._horn.slip(slipped)
        self.begin_anew({}, "another servo")

    def begin_anew(self, kept: dict[str, int], cause: str, off_for: float = 0.0) -> None:
        """Start as after a loss of power, with some registers kept; it is deaf for a while."""
        self.events.add(self.now, EventKind.REBOOT, cause)
        self._power_on({name: kept[name] for name in kept if name in self.memory}, cause)
        self._deaf_until = self.now + off_for + self.choices.boot_time
        self.stirred = True

    def _show_alarms(self, bits: int) -> None:
        """Let these be the hardware errors that stand."""
        self.alarms = bits
        if "Hardware Error Status" in self.memory:
            self.memory["Hardware Error Status"] = bits

    def _standing(self) -> int:
        """Give the hardware errors for which there is a reason now."""
        memory, model, bits = self.memory, self.model, 0
        if not memory["Min Voltage Limit"] <= 10.0 * self.voltage <= memory["Max Voltage Limit"]:
            bits |= alarm_bit(model, INPUT_VOLTAGE)
        if self.temperature > memory["Temperature Limit"]:
            bits |= alarm_bit(model, OVERHEATING)
        if self._overloaded_for >= self.choices.overload_time:
            bits |= alarm_bit(model, OVERLOAD)
        return bits

    def _passing(self) -> int:
        """Give the hardware errors that go when their reason goes.

        Of an overload that is so once the torque is on again.
        """
        model = self.model
        if self.controls.keeps_shut:
            return 0 if self.choices.voltage_error_stays else alarm_bit(model, INPUT_VOLTAGE)
        bits = alarm_bit(model, INPUT_VOLTAGE) | alarm_bit(model, OVERHEATING)
        return bits | alarm_bit(model, OVERLOAD) if self.torque_on else bits

    def _mechanical(self, what: str) -> None:
        self.events.add(self.now, EventKind.MECHANICAL, what)
        self.stirred = True
