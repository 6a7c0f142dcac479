"""The EEPROM of servos written back from a backup, byte for byte.

What can be written and outlives the power is restored. What can only be read (model, firmware)
cannot, and RAM begins anew with the power: it is in the backup to be looked at.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import permutations

from splinearm.drivers.chain import MAX_SERVO_ID
from splinearm.drivers.model import ServoModel
from splinearm.drivers.registers import Area, Register
from splinearm.errors import ConfigError, ServoError

from .backup import Backup, SavedServo
from .bench import Address, Bench, Found
from .image import ControlImage, kept, read_image
from .person import Person
from .search import call_at, call_everyone
from .session import Session, SessionReport
from .task import ADDRESSING, SECONDARY_ID, STARTUP, Change, Task


def restore(
    bench: Bench, backup: Backup, person: Person, *, only: Sequence[str] = ()
) -> SessionReport:
    """Write the EEPROM of servos back.

    A servo is looked for where it was going to be when it was saved, then where it was.

    Args:
        bench: The line.
        backup: What they held.
        person: Who is asked.
        only: Names of the servos to restore; none: all.

    Raises:
        ConfigError: If the backup has no such servo, or servos that cannot be on one line.
        DeclinedError: If the person does not agree.
        BusError: If a servo is not there, or does not do as it is told.
    """
    saved = _chosen(backup, only)
    session = Session(bench, person, backup.arm)
    found = _everyone(bench, saved)
    others = [one for one in backup.servos if one not in saved]
    who = _who_is_who(saved, others, found, bench)
    images = {one.address: read_image(bench, one) for one in found if one.model}
    tasks = [_task(bench, one, images[who[one.name].address]) for one in saved]
    todo = [task for task in tasks if not task.is_done]
    if todo:
        names = {one.address: name for name, one in who.items()}
        session.carry_out(todo, images, names, moves_first=False)
    session.report.tasks = tasks
    session.report.notes = [_left_out(one) for one in saved]
    session.report.notes += [
        f"{task.name}: it switches its torque on by itself when it gets its power ({STARTUP})"
        for task in tasks
        if task.wakes
    ]
    return session.closed()


def differences(saved: ControlImage, now: ControlImage) -> tuple[Change, ...]:
    """Give what is to be written for a servo's EEPROM to be as it was; where it is reached last."""
    table = saved.model.table

    def order(register_name: str) -> tuple[int, int]:
        if register_name in ADDRESSING:
            return 2, ADDRESSING.index(register_name)
        return int(register_name == SECONDARY_ID), table[register_name].address

    was, have = saved.settings(), now.settings()
    return tuple(
        Change(table[name], have[name], was[name])
        for name in sorted(was.keys() & have.keys(), key=order)
        if was[name] != have[name]
    )


def _chosen(backup: Backup, only: Sequence[str]) -> list[SavedServo]:
    """Give the servos to restore.

    Raises:
        ConfigError: If there is none of a name, or two would be at the same address.
    """
    names = [servo.name for servo in backup.servos]
    for name in only:
        if name not in names:
            raise ConfigError("--servo", "", f"{name!r} is not one of {', '.join(names)}")
    saved = [servo for servo in backup.servos if not only or servo.name in only]
    first: dict[Address, str] = {}
    for servo in saved:
        other = first.setdefault(servo.image.address, servo.name)
        if other != servo.name:
            raise ConfigError(
                "--servo",
                "",
                f"{other!r} and {servo.name!r} both were {servo.image.address}, which cannot be on "
                "one line: connect one of them alone and restore it with --servo NAME",
            )
    return saved


def _everyone(bench: Bench, saved: Sequence[SavedServo]) -> tuple[Found, ...]:
    """Give who is there: first where the servos should be, then everywhere."""
    likely = [a for one in saved for a in (one.then, one.image.address) if a is not None]
    there = call_at(bench, dict.fromkeys(likely)).found
    if len(there) >= len(saved):
        return there
    rates = dict.fromkeys(address.baud for address in likely)
    more = call_everyone(bench, None, rates).found
    if len({*there, *more}) < len(saved):
        more = call_everyone(bench, None).found
    return tuple(dict.fromkeys((*there, *more)))


def _who_is_who(
    saved: Sequence[SavedServo],
    others: Sequence[SavedServo],
    found: Iterable[Found],
    bench: Bench,
) -> dict[str, Found]:
    """Give by name who each servo is.

    Args:
        saved: The servos to restore.
        others: The others of the backup, which must not be taken for one of them.
        found: Who answers.
        bench: The line.

    Raises:
        ServoError: If one is not there, or another model is in its place.
    """
    left = list(found)
    who: dict[str, Found] = {}
    ways: tuple[Callable[[SavedServo, Found], bool], ...] = (_is_then, _is_there, _has_its_id)
    for is_it in ways:
        for one in saved:
            able = [f for f in left if is_it(one, f) and f.model_number == one.image.model.number]
            if one.name not in who and len(able) == 1:
                who[one.name] = able[0]
                left.remove(able[0])
    missing = [one for one in saved if one.name not in who]
    if len(missing) == 1:
        free = [f for f in left if not any(_is_home(other, f) for other in others)]
        able = [f for f in free if f.model_number == missing[0].image.model.number]
        if len(able) == 1:
            who[missing[0].name] = able[0]
            return who
    if missing:
        one = missing[0]
        raise ServoError(
            (one.then or one.image.address).servo_id,
            f"no {one.image.model.name} on {bench.port} can be told to be it; connect it (if need "
            "be alone, with --servo)",
            name=one.name,
        )
    return who


def _is_then(one: SavedServo, found: Found) -> bool:
    return one.then is not None and found.address == one.then


def _is_there(one: SavedServo, found: Found) -> bool:
    return found.address == one.image.address


def _is_home(one: SavedServo, found: Found) -> bool:
    """Tell whether a servo of that model answers where one was last."""
    same = found.model_number == one.image.model.number
    return same and found.address == (one.then or one.image.address)


def _has_its_id(one: SavedServo, found: Found) -> bool:
    return found.address.servo_id == (one.then or one.image.address).servo_id


def _task(bench: Bench, saved: SavedServo, now: ControlImage) -> Task:
    """Say what is to be done to a servo, by a way on which nobody else is."""
    changes = differences(saved.image, now)
    for change in changes:
        _require_possible(saved, change)
    task = Task(name=saved.name, image=now, changes=changes)
    for moves in permutations(task.moves):
        other = replace(task, changes=(*task.fills, *moves))
        presence = call_at(bench, other.path(now.address))
        if not (presence.found or presence.garbled):
            return other
    return task


def _require_possible(saved: SavedServo, change: Change) -> None:
    """Refuse what a servo would refuse, before anything is written.

    Raises:
        ConfigError: With the register, what it would be, and what it may be.
    """
    register, model = change.register, saved.image.model
    allowed = _allowed(register, model)
    if allowed is None or change.new in allowed or change.new == register.initial:
        return
    if register.name == SECONDARY_ID and change.new >= MAX_SERVO_ID:
        return  # all of them mean that there is none
    words = f"{allowed[0]} to {allowed[-1]}"
    if not isinstance(allowed, range):
        words = ", ".join(map(str, allowed))
    raise ConfigError(
        "the backup",
        f"{saved.name}.{register.name}",
        f"is {change.new}, a {model.name} takes {words}: was the file edited?",
    )


def _allowed(register: Register, model: ServoModel) -> Sequence[int] | None:
    """Give what a register takes; None: what it takes hangs on other registers."""
    if register.name == "Baud Rate":
        return tuple(model.baud_codes)
    if register.name == "Operating Mode":
        return model.modes
    low, high = register.minimum, register.maximum
    return range(low, high + 1) if isinstance(low, int) and isinstance(high, int) else None


def _left_out(saved: SavedServo) -> str:
    """Say what of a servo's table is restored, and what cannot be."""
    table = saved.image.model.table
    writable = sum(register.size for register in kept(table))
    fixed = [r.name for r in table.registers if r.area is Area.EEPROM and not r.writable]
    return (
        f"{saved.name}: {writable} bytes of EEPROM are as in the backup; not written: "
        f"{', '.join(fixed)} (read only), and RAM, which begins anew with the power"
    )
