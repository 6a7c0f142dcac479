"""Registers written into servos, one by one, each read back; and servos moved to other addresses.

A write whose answer is lost is read back as well: it may have been obeyed. Whoever is stopped
between two writes leaves a servo at one of two addresses, and both are looked at.
"""

from collections.abc import Iterable, Sequence

from splinearm.drivers.chain import MAX_SERVO_ID
from splinearm.drivers.cyclic import GroupWrite
from splinearm.drivers.registers import Register
from splinearm.errors import BusError, BusTimeoutError, PacketError, PortError, ServoError

from .bench import Address, Bench, Found
from .image import ControlImage, read_image
from .task import ANSWER_ALL, Change, Task, moved

_TRIES = 3
_BOOT_TIMEOUT, _PAUSE = 3.0, 0.05  # s
_SETTLED = 0.15  # s: after that time a servo has looked at its supply and temperature again


class Writer:
    """Writes into servos on a line, and counts.

    Args:
        bench: The line.
    """

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self.count = 0
        """How many registers were written, reboots included."""

    def let_answer(self, address: Address, register: Register) -> None:
        """Make a servo answer every instruction; it need not answer this one.

        Raises:
            BusError: If it cannot be read afterwards.
        """
        bus = self._bench.to(address)
        self.count += 1
        bus.sync_write(GroupWrite([(address.servo_id, register)]), [ANSWER_ALL])
        bus.read(address.servo_id, register)

    def write(self, address: Address, register: Register, value: int) -> None:
        """Write a register after which a servo is reached as before, and read it back.

        What says that it was taken may be the late answer to something before: only what is read
        back counts.

        Raises:
            BusError: If it does not answer, refuses, or holds something else then.
        """
        bus, servo_id = self._bench.to(address), address.servo_id
        self.count += 1
        lost: BusError | None = None
        for _ in range(_TRIES):
            try:
                bus.write(servo_id, register, value)
            except ServoError as error:
                raise _refused(error, register, value) from error
            except (BusTimeoutError, PacketError) as error:
                lost = error  # it may have been obeyed
            try:
                if bus.read(servo_id, register) == value:
                    return
            except (BusTimeoutError, PacketError) as error:
                lost = error
            self._bench.sleep(_PAUSE)
        if lost is not None:
            raise lost
        raise ServoError(servo_id, f"{register.name} does not keep {value}")

    def fill(self, address: Address, changes: Iterable[Change]) -> None:
        """Write registers after which a servo is reached as before.

        Raises:
            BusError: As ``write``.
        """
        for change in changes:
            self.write(address, change.register, change.new)

    def readdress(self, here: Address, image: ControlImage, change: Change) -> Address:
        """Write a register after which a servo is reached otherwise; give how.

        Raises:
            BusError: If it is reached neither way afterwards, or refuses.
        """
        there = moved(here, image, change)
        register, value = change.register, change.new
        self.count += 1
        for _ in range(_TRIES):
            try:
                self._bench.to(here).write(here.servo_id, register, value)
            except ServoError as error:
                raise _refused(error, register, value) from error
            except (BusTimeoutError, PacketError):
                pass  # it may have answered at its new address
            if self._holds(there, register, value):
                return there
            if there.protocol != here.protocol and self._holds(here, register, value):
                self.restart([here])  # some take a new protocol only then
                if self._holds(there, register, value):
                    return there
        raise BusTimeoutError(there.servo_id, register.name, port=self._bench.port)

    def restart(self, addresses: Iterable[Address]) -> None:
        """Let servos start anew and wait until they answer; not those that speak Protocol 1.0.

        There no such instruction is known to all of them.

        Raises:
            BusTimeoutError: If one does not come back.
        """
        able = [address for address in addresses if address.protocol == 2]
        for address in able:
            self.count += 1
            for _ in range(_TRIES):
                try:
                    self._bench.to(address).reboot(address.servo_id)
                except (BusTimeoutError, PacketError):  # perhaps it starts with its leader already
                    self.await_answer(address)
                else:
                    break
        for address in able:
            self.await_answer(address)
        if able:
            self._bench.sleep(_SETTLED)

    def await_answer(self, address: Address) -> None:
        """Ask a servo until it answers.

        Raises:
            BusTimeoutError: If it does not for seconds.
        """
        until = self._bench.clock() + _BOOT_TIMEOUT
        while True:
            try:
                self._bench.to(address).ping(address.servo_id, tries=1)
            except PortError:
                raise
            except BusError:
                if self._bench.clock() > until:
                    raise
                self._bench.sleep(_PAUSE)
            else:
                return

    def move_all(self, tasks: Sequence[Task], present: Iterable[Address]) -> dict[str, Address]:
        """Bring servos to the addresses that their tasks say; give by name where they are then.

        No servo ever gets the address of another: where two must change places, one waits at an id
        that nobody has.

        Args:
            tasks: What is to be done; nobody outside of them is in the way.
            present: Where servos are now, those of the tasks included.

        Raises:
            BusError: As ``readdress``.
        """
        here = {task.name: task.image.address for task in tasks}
        taken = set(present) | set(here.values())
        waiting = [task for task in tasks if task.moves]
        reserved = {address.servo_id for task in tasks for address in task.path(here[task.name])}

        def step(task: Task, change: Change) -> None:
            taken.discard(here[task.name])
            here[task.name] = self.readdress(here[task.name], task.image, change)
            taken.add(here[task.name])

        while waiting:
            free = [t for t in waiting if not _blocked(t, here[t.name], taken)]
            if free:
                task = free[0]
                for change in task.moves:
                    if _value_at(here[task.name], task.image, change) != change.new:
                        step(task, change)
                waiting.remove(task)
                continue
            task = _in_the_way(waiting, here, taken, self._bench.port)
            register = task.image.model.table["ID"]
            spare = free_id(taken, reserved)
            step(task, Change(register, here[task.name].servo_id, spare))
        return here

    def verify(self, found: Found, changes: Sequence[Change]) -> ControlImage:
        """Read a servo again and see that it holds what was written.

        Raises:
            ServoError: If it does not.
            BusError: If it does not answer.
        """
        image = read_image(self._bench, found)
        for change in changes:
            register = change.register
            if image.value(register.name) == change.new:
                continue
            self._bench.sleep(_PAUSE)
            if self._bench.to(found.address).read(found.address.servo_id, register) != change.new:
                raise ServoError(
                    found.address.servo_id,
                    f"its {register.name} is {image.value(register.name)} again after {change.new} "
                    "was written: try once more, or update its firmware with DYNAMIXEL Wizard 2",
                )
        return image

    def _holds(self, address: Address, register: Register, value: int) -> bool:
        """Tell whether a servo at an address holds a value; not if nobody is there."""
        try:
            return self._bench.to(address).read(address.servo_id, register) == value
        except PortError:
            raise
        except BusError:
            return False


def free_id(taken: Iterable[Address], reserved: Iterable[int]) -> int:
    """Give an id that nobody has or shall have, near to the others so that a scan finds it.

    Raises:
        ServoError: If there is none.
    """
    used = {address.servo_id for address in taken} | set(reserved)
    for servo_id in range(1, MAX_SERVO_ID + 1):
        if servo_id not in used:
            return servo_id
    raise ServoError(MAX_SERVO_ID, "no id is free: disconnect servos that are not of the arm")


def _blocked(task: Task, here: Address, taken: set[Address]) -> bool:
    """Tell whether someone else is on the way of a task, whose id it may have meanwhile."""
    return any(address in taken and address != here for address in task.path(here))


def _in_the_way(
    waiting: Sequence[Task], here: dict[str, Address], taken: set[Address], port: str
) -> Task:
    """Give one that is to move too and keeps another from its way.

    Raises:
        ServoError: If none of them does: whoever does would have to be disconnected.
    """
    for first in waiting:
        path = set(first.path(here[first.name])) & taken
        for task in waiting:
            if task is not first and here[task.name] in path:
                return task
    first = waiting[0]
    own = here[first.name]
    address = next(a for a in first.path(own) if a in taken and a != own)
    raise ServoError(
        own.servo_id,
        f"it shall get {address}, which another servo on {port} has: disconnect that one, then try "
        "again",
        name=first.name,
    )


def _value_at(here: Address, image: ControlImage, change: Change) -> int:
    """Give what an addressing register holds, by how a servo is reached now."""
    name = change.register.name
    if name == "ID":
        return here.servo_id
    if name == "Protocol Type":
        return here.protocol
    return change.new if moved(here, image, change) == here else change.old


def _refused(error: ServoError, register: Register, value: int) -> ServoError:
    """Say of a refusal what may be behind it."""
    return ServoError(
        error.servo_id,
        f"{register.name} = {value} refused ({error.reason.rpartition(': ')[2]}): its torque may "
        "be on, or its firmware too old for that value",
        code=error.code,
        alert=error.alert,
    )
