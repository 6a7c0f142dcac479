"""What setup and restore have in common: ask, keep what was, write, start anew, read again."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from splinearm.errors import BusTimeoutError, DeclinedError, ServoError

from .backup import Backup, SavedServo, backup_file, write_backup
from .bench import Address, Bench, Found
from .image import ControlImage
from .person import Person
from .search import call_at
from .task import ANSWER_ALL, LEVEL, Task
from .writing import Writer

ERRORS = "Hardware Error Status"
"""The register that says which hardware errors are latched."""


@dataclass(slots=True, eq=False, kw_only=True)
class SessionReport:
    """What was found and done."""

    tasks: list[Task] = field(default_factory=list)
    """What was, or is, to be done, servo by servo; those of which nothing is are here too."""
    left: list[str] = field(default_factory=list)
    """What is left to do, in words."""
    notes: list[str] = field(default_factory=list)
    """What else was seen."""
    written: int = 0
    """How many registers were written, reboots included."""
    backup: Path | None = None
    """Where the control tables are kept as they were; None: nothing was written."""


class Session:
    """Writes into servos what a person agrees to.

    Args:
        bench: The line.
        person: Who is asked.
        arm: Name of the arm, for the backup; empty: none is named.
    """

    def __init__(self, bench: Bench, person: Person, arm: str) -> None:
        self._bench = bench
        self._person = person
        self._arm = arm
        self._saved: list[SavedServo] = []
        self.writer = Writer(bench)
        """What writes."""
        self.report = SessionReport()
        """What was done so far."""

    def closed(self) -> SessionReport:
        """Give what was done."""
        self.report.written = self.writer.count
        return self.report

    def let_answer(self, one: Found) -> None:
        """Make a servo answer that answers pings alone; one that has gone is no error."""
        if one.model is not None:
            with suppress(BusTimeoutError):
                self.writer.let_answer(one.address, one.model.table[LEVEL])

    def carry_out(
        self,
        tasks: Sequence[Task],
        images: Mapping[Address, ControlImage],
        names: Mapping[Address, str],
        *,
        moves_first: bool = True,
    ) -> None:
        """Ask, back up, write, start anew, and see that it stays.

        Args:
            tasks: What is to be done.
            images: Everyone on the line.
            names: What those of them are called that are known.
            moves_first: Whether a servo gets its address before the rest: then it is known again,
                whoever stops this.

        Raises:
            DeclinedError: If the person does not agree; nothing was written.
            BusError: If a servo does not do as it is told.
        """
        self._require_free(tasks, images)
        self._ask(tasks, images, names)
        self._back_up(tasks)
        for task in tasks:
            self._open_up(task)
        writer = self.writer
        here = {task.name: task.image.address for task in tasks}
        if not moves_first:
            for task in tasks:
                writer.fill(here[task.name], task.fills)
        here = writer.move_all(tasks, images)
        if moves_first:
            for task in tasks:
                writer.fill(here[task.name], task.fills)
        writer.restart([here[task.name] for task in tasks if not task.wakes])
        for task in tasks:
            self._verify(task, here[task.name])

    def _require_free(self, tasks: Sequence[Task], images: Mapping[Address, ControlImage]) -> None:
        """See that nobody unseen has an address that a servo shall have, be it for a moment.

        Raises:
            ServoError: If somebody has.
        """
        for task in tasks:
            ways = [address for address in task.path(task.image.address) if address not in images]
            presence = call_at(self._bench, ways)
            for address in (*(one.address for one in presence.found), *presence.garbled):
                raise ServoError(
                    task.image.address.servo_id,
                    f"it shall get {address}, where another servo answers: disconnect that one, "
                    "then try again",
                    name=task.name,
                )

    def _ask(
        self,
        tasks: Sequence[Task],
        images: Mapping[Address, ControlImage],
        names: Mapping[Address, str],
    ) -> None:
        """Let the person agree to what is written, and to torque that goes off."""
        if not self._person.agrees(tasks):
            raise DeclinedError("not agreed to; nothing of it was written")
        energised = [a for a, image in images.items() if image.value("Torque Enable")]
        if energised and not self._person.lets_fall([names.get(a, str(a)) for a in energised]):
            raise DeclinedError(
                "servos hold with torque, and it was not agreed that they lose it; nothing written"
            )

    def _back_up(self, tasks: Sequence[Task]) -> None:
        """Keep what the servos hold before the first write."""
        file = self.report.backup or backup_file(self._arm, self._bench.port)
        known = {saved.name for saved in self._saved}
        for task in tasks:
            if task.name not in known:
                then = task.path(task.image.address)
                self._saved.append(SavedServo(task.name, task.image, then[-1] if then else None))
        backup = Backup(arm=self._arm, port=self._bench.port, servos=tuple(self._saved))
        write_backup(file, backup)
        if self.report.backup is None:
            self._person.tell(f"the servos as they were: {file}")
        self.report.backup = file

    def _open_up(self, task: Task) -> None:
        """Let a servo's answers be heard and its EEPROM be written."""
        image, address = task.image, task.image.address
        if image.value("Lock"):
            raise ServoError(
                address.servo_id,
                "its EEPROM is locked (Lock is 1): switch its power off and on, then start again",
                name=task.name,
            )
        if image.value(LEVEL) not in (None, ANSWER_ALL):
            self.writer.let_answer(address, image.model.table[LEVEL])
        if task.has_torque:
            self.writer.write(address, image.model.table["Torque Enable"], 0)

    def _verify(self, task: Task, address: Address) -> None:
        """See that a servo holds what was written, and is well."""
        image = self.writer.verify(task.image.found._replace(address=address), task.changes)
        status = image.value(ERRORS) or 0
        if status:
            errors = " and ".join(image.model.hardware_errors(status))
            raise ServoError(
                address.servo_id,
                f"it reports {errors} again after a reboot: mend the cause (`splinearm doctor` "
                "says more), then start again",
                name=task.name,
            )
        self._person.tell(f"{task.name}: done, {address}")
