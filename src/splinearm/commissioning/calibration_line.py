"""What is spoken to the servos of an arm that is calibrated: looked at, kept in a file, written."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from splinearm.backends import require_chain
from splinearm.config import Cell
from splinearm.config.calibration_table import CALIBRATED_REGISTERS
from splinearm.drivers.asking import read_torque
from splinearm.drivers.chain import ServoSpec
from splinearm.drivers.dialect import protocol_of
from splinearm.drivers.registers import Area
from splinearm.drivers.startup import call_roll, check_health, let_all_answer
from splinearm.errors import BusTimeoutError, ServoError

from .backup import Backup, SavedServo, backup_file, write_backup
from .bench import Address, Bench, Found
from .image import read_image
from .task import ANSWER_ALL, LEVEL, Change
from .writing import Writer

if TYPE_CHECKING:
    from splinearm.drivers.dynamixel import DynamixelBus


class CalibrationLine:
    """Some servos of an arm, on a line that is open at their rate; it stays open.

    Args:
        bus: The line.
        cell: The arm.
        servos: The servos.
    """

    def __init__(self, bus: "DynamixelBus", cell: Cell, servos: Sequence[ServoSpec]) -> None:
        self._bus, self._servos, self._arm = bus, tuple(servos), cell.name
        self._protocol = require_chain(cell).protocol
        self._bench = Bench(bus.port, opener=lambda port, baud: bus)
        self._writer = Writer(self._bench)
        self._firmwares: dict[int, int] = {}
        self.registers: dict[int, dict[str, int]] = {}
        """By id and name what registers hold that a calibration may set."""

    @property
    def port(self) -> str:
        """Its port."""
        return self._bus.port

    def survey(self) -> None:
        """See that the servos are there and well, and read their EEPROM.

        Raises:
            BusError: If a servo does not answer, is of another model, or reports a hardware error.
        """
        roll = call_roll(self._bus, self._servos)
        self._firmwares = {servo_id: reply.firmware for servo_id, reply in roll.items()}
        self._let_answer()
        check_health(self._bus, self._servos)
        for servo in self._servos:
            table = servo.servo_model.table
            self.registers[servo.servo_id] = {
                name: self._bus.read(servo.servo_id, table[name])
                for name in CALIBRATED_REGISTERS
                if name in table
            }

    def energised(self) -> tuple[ServoSpec, ...]:
        """Give the servos whose torque is on.

        Raises:
            BusError: If a servo does not answer.
        """
        on = read_torque(self._bus, self._servos)
        return tuple(servo for servo in self._servos if on[servo.servo_id])

    def release(self) -> None:
        """Switch the torque off. What nobody supports falls.

        Raises:
            BusError: If a servo does not answer, or keeps its torque.
        """
        for servo in self._servos:
            torque = servo.servo_model.table["Torque Enable"]
            self._writer.write(self._address(servo), torque, 0)

    def back_up(self) -> Path:
        """Keep the whole control tables of the servos in a file, as they are now; give the file.

        Raises:
            BusError: If a servo does not answer.
            ConfigError: If the file cannot be written.
        """
        saved = []
        for servo in self._servos:
            firmware = self._firmwares[servo.servo_id]
            found = Found(self._address(servo), servo.servo_model.number, firmware)
            saved.append(SavedServo(servo.name, read_image(self._bench, found)))
        file = backup_file(self._arm, self.port)
        write_backup(file, Backup(arm=self._arm, port=self.port, servos=tuple(saved)))
        return file

    def fill(self, servo: ServoSpec, changes: Sequence[Change]) -> None:
        """Write registers of a servo, and read each back.

        Raises:
            BusError: If it does not answer, refuses, or holds something else then.
        """
        for change in changes:
            self._writer.write(self._address(servo), change.register, change.new)
            self.registers[servo.servo_id][change.register.name] = change.new

    def _let_answer(self) -> None:
        """Let servos answer that were told not to, unless that would be written for good."""
        mute = [servo for servo in self._servos if not self._answers(servo)]
        for servo in mute:
            if servo.servo_model.table[LEVEL].area is Area.EEPROM:
                raise ServoError(
                    servo.servo_id,
                    f"its {LEVEL} keeps it from answering: `splinearm setup` puts that right",
                    name=servo.name,
                )
        if mute:
            let_all_answer(self._bus, mute)

    def _answers(self, servo: ServoSpec) -> bool:
        """Tell whether a servo that is there answers every instruction."""
        try:
            return self._bus.read(servo.servo_id, servo.servo_model.table[LEVEL]) == ANSWER_ALL
        except BusTimeoutError:
            return False

    def _address(self, servo: ServoSpec) -> Address:
        return Address(self._bus.baud, protocol_of(servo, self._protocol), servo.servo_id)
