"""One servo that exists only here, as the bus knows it: ids, rules, instructions; no port.

While shut down by a hardware error it refuses Torque Enable with an access error: the manual says
only that nothing but a reboot lets it be 1 again.
Source: ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0".
"""

from collections.abc import Mapping
from enum import IntEnum

from splinearm.drivers.chain import ServoSpec
from splinearm.drivers.model import ServoModel
from splinearm.drivers.registers import Area

from .alarm import ALERT, error_byte_v1
from .choice import BOOT_TIME as BOOT_TIME
from .choice import DEFAULT_CHOICES, Choices
from .fault import FaultyServo
from .firmware import FIRMWARE as FIRMWARE
from .firmware import knows_clear, newest_firmware
from .memory import AddressError, Change, LengthError
from .rule import Refusal, refusal
from .shaft import Shaft
from .wide_controls import GAINS

_CLEAR_TURNS = b"\x01\x44\x58\x4c\x22"
_BACKUP, _RESTORE = b"\x01CTRL", b"\x02CTRL"
_RAM_RESTORE = 0x02
_NO_ID = 255


class FactoryReset(IntEnum):
    """What a factory reset spares."""

    EXCEPT_ID = 0x01
    EXCEPT_ID_AND_BAUD = 0x02
    ALL = 0xFF


_SPARED = {
    FactoryReset.EXCEPT_ID: ("ID",),
    FactoryReset.EXCEPT_ID_AND_BAUD: ("ID", "Baud Rate"),
    FactoryReset.ALL: (),
}


class VirtualServo(FaultyServo):
    """One servo on a bus. Methods that answer an instruction give its error number."""

    def __init__(
        self,
        model: ServoModel,
        *,
        settings: Mapping[str, int] | None = None,
        zero_ticks: int | None = None,
        shaft: Shaft | None = None,
        firmware: int | None = None,
        choices: Choices = DEFAULT_CHOICES,
    ) -> None:
        """Switch a servo on.

        Args:
            model: Its model.
            settings: Raw values of registers that differ from the factory's; see ``ServoCore``.
            zero_ticks: Its position at joint zero; None: mid travel.
            shaft: Its output shaft; None: one of its own.
            firmware: Its firmware version; None: one that has all that is known of the model.
            choices: How it does what its manual leaves open.

        Raises:
            ValueError: If such a model cannot be simulated or a value does not fit.
        """
        version = newest_firmware(model) if firmware is None else firmware
        super().__init__(
            model,
            settings={"Firmware Version": version, **(settings or {})},
            zero_ticks=zero_ticks,
            shaft=Shaft() if shaft is None else shaft,
            choices=choices,
        )
        self.unplugged = False
        """Whether its data cable is out: it neither hears nor answers."""
        self.mute = False
        """Whether its answers are lost: it hears and obeys."""
        self.corrupt_replies = 0
        """How many of its next answers are damaged on their way."""
        self._registered: tuple[int, bytes, bool] | None = None
        self._backup: dict[str, int] = {}
        self._beyond_angle = False

    @classmethod
    def of(cls, spec: ServoSpec, baud: int, shaft: Shaft) -> "VirtualServo":
        """Give the servo of an arm file, set up as the file says.

        Raises:
            ValueError: If such a model cannot be simulated, or has not that baud rate.
        """
        model = spec.servo_model
        settings = {"ID": spec.servo_id, "Baud Rate": model.baud_code(baud), **spec.settings}
        return cls(model, settings=settings, zero_ticks=spec.zero_ticks, shaft=shaft)

    @property
    def servo_id(self) -> int:
        """Its id."""
        return self.memory["ID"]

    @property
    def secondary_id(self) -> int:
        """The id whose instructions it follows in silence; above 252: none."""
        return self.memory.get("Secondary(Shadow) ID", _NO_ID)

    @property
    def baud(self) -> int:
        """Its baud rate."""
        code = self.memory["Baud Rate"]
        known = self.model.baud_codes.get(code)
        # an AX-12A takes any code; its manual names the rates of some and this rule
        return round(2_000_000 / (code + 1)) if known is None else known

    @property
    def protocol(self) -> int:
        """The protocol that it speaks: 1 or 2."""
        return self.memory.get("Protocol Type", self.model.protocols[0])

    @property
    def firmware(self) -> int:
        """Its firmware version."""
        return self.memory["Firmware Version"]

    @property
    def has_fast_read(self) -> bool:
        """Whether it knows fast sync and fast bulk reads."""
        return self.model.has_fast_read(self.firmware)

    def listens(self, baud: int) -> bool:
        """Tell whether it understands what comes at a baud rate."""
        return not self.unplugged and baud == self.baud and self.now >= self._deaf_until

    def error_byte(self, number: int) -> int:
        """Give the error byte of a status packet of Protocol 2.0: a number, and the alert."""
        return number | (ALERT if self.alarms else 0)

    def error_byte_v1(self, number: int) -> int:
        """Give the error byte of a status packet of Protocol 1.0: faults, and why it refused."""
        if number == Refusal.DATA_LIMIT and not self._beyond_angle:
            number = Refusal.DATA_RANGE
        return error_byte_v1(self.model, self.alarms, number)

    def ping(self) -> bytes:
        """Give what it answers to a ping: model number and firmware."""
        return self.memory["Model Number"].to_bytes(2, "little") + bytes((self.firmware,))

    def read(self, address: int, length: int) -> tuple[int, bytes]:
        """Give an error number and the bytes at an address."""
        memory, measured = self.memory, self.controls.measured
        try:
            for name in memory.names_in(address, length):
                measure = measured.get(name)
                if measure is not None:
                    memory.show(name, measure(self))
            return Refusal.NONE, memory.read(address, length)
        except AddressError:
            return Refusal.ACCESS, b""

    def write(self, address: int, data: bytes, *, shadowing: bool = False) -> int:
        """Write bytes, all or none.

        Args:
            address: Where.
            data: What.
            shadowing: Whether the packet was for its secondary id: then EEPROM is closed.
        """
        number, changes = self._admit(address, data, shadowing=shadowing)
        if number == Refusal.NONE:
            self.apply(changes)
        return number

    def reg_write(self, address: int, data: bytes, *, shadowing: bool = False) -> int:
        """Keep a write for the next action."""
        number, _ = self._admit(address, data, shadowing=shadowing)
        if number == Refusal.NONE:
            self._registered = (address, data, shadowing)
            self._show_registered()
        return number

    def action(self) -> int:
        """Do what was kept."""
        if self._registered is None:
            return Refusal.INSTRUCTION
        address, data, shadowing = self._registered
        self._registered = None
        self._show_registered()
        return self.write(address, data, shadowing=shadowing)

    def reboot(self) -> int:
        """Begin anew, as after a loss of power; servos of Protocol 1.0 alone do not know that."""
        if 2 not in self.model.protocols:
            return Refusal.INSTRUCTION
        self.begin_anew(self._restored(), "reboot")
        return Refusal.NONE

    def factory_reset(self, option: int, *, broadcast: bool = False) -> int:
        """Forget settings and reboot. Sent to all servos, it never resets their ids."""
        if option not in set(FactoryReset):
            return Refusal.DATA_RANGE
        if option == FactoryReset.ALL and broadcast:
            return Refusal.RESULT_FAIL
        spared = (*_SPARED[FactoryReset(option)], "Firmware Version")
        kept = {name: self.memory[name] for name in spared}
        self.memory.reset(self.memory.of(Area.EEPROM))
        for name, value in kept.items():
            self.memory[name] = value
        self.begin_anew(self._restored(), "factory reset")
        return Refusal.NONE

    def power_cycle(self, off_for: float = 0.0) -> None:
        """Lose the power and have it again after a time, s; what a backup restores comes back."""
        self.begin_anew(self._restored(), "loss of power", off_for)

    def begin_anew(self, kept: dict[str, int], cause: str, off_for: float = 0.0) -> None:
        """Start as after a loss of power, with some registers kept; it is deaf for a while."""
        self._registered = None
        super().begin_anew(kept, cause, off_for)
        if "Backup Ready" in self.memory:
            self.memory["Backup Ready"] = int(bool(self._backup))

    def swap(self, slipped: float = 0.0) -> None:
        """Put a new servo of that model in its place; see ``FaultyServo``."""
        self._backup = {}
        super().swap(slipped)

    def clear(self, params: bytes) -> int:
        """Forget whole turns, if it stands still."""
        if not knows_clear(self.model, self.firmware):
            return Refusal.INSTRUCTION
        if params != _CLEAR_TURNS:
            return Refusal.DATA_RANGE
        if self.value("Moving"):
            return Refusal.RESULT_FAIL
        self.forget_turns()
        return Refusal.NONE

    def backup(self, params: bytes) -> int:
        """Keep the settings, or restore them and reboot, if the torque is off."""
        if not self.has_fast_read:  # both came with the same firmware
            return Refusal.INSTRUCTION
        if params not in (_BACKUP, _RESTORE):
            return Refusal.DATA_RANGE
        if self.torque_on or (params == _RESTORE and not self._backup):
            return Refusal.RESULT_FAIL
        if params == _BACKUP:
            self._backup = {name: self.memory[name] for name in self._backed_up()}
            self.memory["Backup Ready"] = 1
        else:
            for name, value in self._backup.items():
                self.memory[name] = value
            self.begin_anew(self._backup, "restored backup")
        return Refusal.NONE

    def _admit(self, address: int, data: bytes, *, shadowing: bool) -> tuple[Refusal, list[Change]]:
        """Say whether a write may be done, and what it means."""
        try:
            changes = self.memory.changes(address, data)
        except LengthError:
            return Refusal.DATA_LENGTH, []
        except AddressError:
            return Refusal.ACCESS, []
        if self.shut_down and any(r.name == "Torque Enable" and on for r, on in changes):
            return Refusal.ACCESS, []
        self._beyond_angle = any(register.name == "Goal Position" for register, _ in changes)
        unlocked = not (self.torque_on or shadowing or self.controls.eeprom_locked)
        return refusal(self.memory, self.model, changes, may_write_eeprom=unlocked), changes

    def _restored(self) -> dict[str, int]:
        """Give the registers that come back by themselves at the start."""
        return self._backup if self.memory.get("Startup Configuration") & _RAM_RESTORE else {}

    def _show_registered(self) -> None:
        """Say whether a write is kept for the next action."""
        for name in ("Registered Instruction", "Registered"):
            if name in self.memory:
                self.memory[name] = int(self._registered is not None)

    def _backed_up(self) -> list[str]:
        """Give the registers that a backup covers."""
        eeprom = [r.name for r in self.memory.of(Area.EEPROM) if r.writable]
        indirect = [name for name in self.memory.table if name.startswith("Indirect Address")]
        return [*eeprom, *GAINS, "Profile Velocity", "Profile Acceleration", *indirect]
