"""Whole control tables in a file, byte for byte, and back from it.

The file is TOML (``schema = "splinearm-backup/1"``)::

    arm, port, time             whose servos, where, and when (UTC)
    [[servo]]
        name id baud protocol   what it was called, and how it was reached
        model model_number firmware
        [servo.then]            where it was going to be: id baud protocol (in backups of setup)
        [[servo.block]]         area = "EEPROM" or "RAM", address, bytes in hexadecimal
"""

import re
from dataclasses import dataclass
from datetime import UTC, datetime
from os import PathLike
from pathlib import Path

from splinearm.config.folder import quoted, user_folder, write_whole
from splinearm.config.reader import Table, read_file
from splinearm.drivers.chain import MAX_SERVO_ID
from splinearm.drivers.model import servo_model, servo_models
from splinearm.drivers.registers import Area

from .bench import Address, Found
from .image import Block, ControlImage, kept

BACKUP_SCHEMA = "splinearm-backup/1"
"""What a backup says it is."""

_WIDTH = 32


@dataclass(frozen=True, slots=True, eq=False)
class SavedServo:
    """One servo of a backup."""

    name: str
    """What it was called."""
    image: ControlImage
    """What it held."""
    then: Address | None = None
    """Where it was going to be; None: where it was."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Backup:
    """What a backup says."""

    arm: str
    """Name of the arm; empty: none was named."""
    port: str
    """The port."""
    servos: tuple[SavedServo, ...]
    """The servos."""
    time: str = ""
    """When it was made (UTC, ISO 8601); empty: it is to be written yet."""


def backup_file(arm: str, port: str) -> Path:
    """Give a new file for a backup in the user's folder, by arm, time and port."""
    folder = user_folder() / "backups" / (_plain(arm) or "servos")
    now = datetime.now(UTC).strftime("%Y%m%d-%H%M%S")
    stem = f"{now}-{_plain(Path(port.removeprefix('unix:')).name) or 'port'}"
    path = folder / f"{stem}.toml"
    count = 1
    while path.exists():
        count += 1
        path = folder / f"{stem}-{count}.toml"
    return path


def write_backup(file: Path, backup: Backup) -> None:
    """Write a backup; what was in the file stays whole until the new one is.

    Raises:
        ConfigError: If it cannot be written.
    """
    now = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    lines = [
        "# Control tables of servos as they were; `splinearm restore FILE` writes the EEPROM back.",
        f"schema = {quoted(BACKUP_SCHEMA)}",
        f"arm = {quoted(backup.arm)}",
        f"port = {quoted(backup.port)}",
        f"time = {quoted(now)}",
    ]
    for servo in backup.servos:
        lines += _servo_lines(servo)
    write_whole(file, "\n".join(lines) + "\n")


def read_backup(file: str | PathLike[str]) -> Backup:
    """Read a backup.

    Raises:
        ConfigError: If it is none, or says something that cannot be.
    """
    root = read_file(file, BACKUP_SCHEMA)
    servos = tuple(_read_servo(table) for table in root.tables("servo"))
    arm, port, time = (root.text(key, "") for key in ("arm", "port", "time"))
    root.finish()
    if not servos:
        raise root.refuse("servo", "is missing; a backup has [[servo]] tables")
    names = [servo.name for servo in servos]
    if len({*names}) < len(names):
        name = next(name for k, name in enumerate(names) if name in names[:k])
        raise root.refuse("servo", f"has two of the name {name!r}")
    return Backup(arm=arm, port=port, servos=servos, time=time)


def _servo_lines(servo: SavedServo) -> list[str]:
    image, address = servo.image, servo.image.address
    lines = ["", "[[servo]]", f"name = {quoted(servo.name)}", *_address_lines(address)]
    lines += [
        f"model = {quoted(image.model.name)}",
        f"model_number = {image.found.model_number}",
        f"firmware = {image.found.firmware}",
    ]
    if servo.then is not None:
        lines += ["[servo.then]", *_address_lines(servo.then)]
    for block in image.blocks:
        lines += ["[[servo.block]]", f'area = "{block.area.value}"', f"address = {block.address}"]
        words = [f"{byte:02x}" for byte in block.data]
        rows = [" ".join(words[i : i + _WIDTH]) for i in range(0, len(words), _WIDTH)]
        lines += ['bytes = """', *rows, '"""']
    return lines


def _address_lines(address: Address) -> list[str]:
    return [
        f"id = {address.servo_id}",
        f"baud = {address.baud}",
        f"protocol = {address.protocol}",
    ]


def _read_servo(table: Table) -> SavedServo:
    name = table.text("name")
    if not name.isprintable():
        raise table.refuse("name", "wants letters that can be shown")
    address = _read_address(table)
    model = servo_model(table.choice("model", [model.name for model in servo_models()]))
    number = table.integer("model_number", low=0, high=0xFFFF)
    if number != model.number:
        raise table.refuse("model_number", f"of a {model.name} is {model.number}, got {number}")
    firmware = table.integer("firmware", low=0, high=0xFF)
    then = _read_address(table.table("then"), finish=True) if "then" in table else None
    blocks = tuple(_read_block(block) for block in table.tables("block"))
    table.finish()
    image = ControlImage(found=Found(address, number, firmware), model=model, blocks=blocks)
    lacking = [r.name for r in kept(model.table) if image.value(r.name) is None]
    if lacking:
        raise table.refuse("block", f"has no bytes of {', '.join(lacking)}: was the file cut off?")
    if image.value("ID") != address.servo_id:
        raise table.refuse("block", f"has no EEPROM with the ID {address.servo_id}")
    return SavedServo(name, image, then)


def _read_address(table: Table, *, finish: bool = False) -> Address:
    address = Address(
        table.integer("baud", low=1),
        table.integer("protocol", low=1, high=2),
        table.integer("id", low=0, high=MAX_SERVO_ID + 1),
    )
    if finish:
        table.finish()
    return address


def _read_block(table: Table) -> Block:
    area = Area(table.choice("area", [area.value for area in Area]))
    address = table.integer("address", low=0, high=0xFFFF)
    text = table.text("bytes")
    try:
        data = bytes.fromhex(text)
    except ValueError as error:
        raise table.refuse("bytes", "wants pairs of hexadecimal digits") from error
    table.finish()
    return Block(area, address, data)


def _plain(text: str) -> str:
    """Give a text as a part of a file's name."""
    return re.sub(r"[^A-Za-z0-9._-]+", "_", text).strip("._")
