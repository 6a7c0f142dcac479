"""The calibrations that a user has: one folder an arm, one file a calibration, none ever lost.

They lie in ``calibrations/ARM/NAME.toml`` of the user's folder. The one called "default" is in use.
Whatever takes the place of another leaves that one there under its date.
"""

import logging
import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from urllib.parse import quote

from splinearm.errors import ConfigError

from .calibration_table import (
    Calibration,
    ServoCalibration,
    apply_calibration,
    calibration_text,
    read_calibration,
)
from .cell import Cell
from .folder import is_there, user_folder, write_whole

DEFAULT = "default"
"""Name of the calibration that is in use."""

_log = logging.getLogger(__name__)

_NAME = re.compile(r"\w[\w.-]{0,99}")


def calibration_file(arm: str, name: str = DEFAULT) -> Path:
    """Give where a calibration of an arm lies, or would lie.

    Raises:
        ConfigError: If the name is none that a file can have everywhere.
    """
    if _NAME.fullmatch(name) is None:
        raise ConfigError(
            name, "", "is no name of a calibration; it takes letters, digits, and _ - . within"
        )
    return _folder(arm) / f"{name}.toml"


def calibration_names(arm: str) -> tuple[str, ...]:
    """Give the names of an arm's calibrations: the one in use first, then the newest."""
    files = [f for f in _folder(arm).glob("*.toml") if not f.name.startswith(".") and f.is_file()]
    files.sort(key=lambda file: (file.stem != DEFAULT, -file.stat().st_mtime_ns, file.stem))
    return tuple(file.stem for file in files)


def find_calibration(arm: str, name: str | None = None) -> Calibration | None:
    """Give a calibration of an arm; None if none is named and none is in use.

    Raises:
        ConfigError: If there is none of that name, or its file cannot be used.
    """
    file = calibration_file(arm, name or DEFAULT)
    if name is None and not is_there(file):
        return None
    return _read(arm, file)


def calibrated(cell: Cell, name: str | None = None) -> Cell:
    """Give a cell as the user's own arm is: with the calibration in use, or the one of a name.

    A cell without any, or without servos, is given back as it is.

    Raises:
        ConfigError: If there is none of that name, it is broken (with file, key and line), or it
            is not of this arm's servos.
    """
    if cell.chain is None and name is None:
        return cell
    calibration = find_calibration(cell.name, name)
    if calibration is None:
        return cell
    file = calibration_file(cell.name, calibration.name)
    _log.info("%s: calibration %r of %s", cell.name, calibration.name, calibration.date)
    return apply_calibration(cell, calibration, file)


def fitting(cell: Cell, calibration: Calibration) -> Calibration:
    """Give a calibration without the servos that do not fit the arm's file, as it is by now."""
    file = calibration_file(cell.name, calibration.name)

    def fits(servo: ServoCalibration) -> bool:
        try:
            apply_calibration(cell, replace(calibration, servos=(servo,)), file)
        except ConfigError:
            return False
        return True

    return replace(calibration, servos=tuple(filter(fits, calibration.servos)))


def save_calibration(calibration: Calibration, *, over: Calibration | None = None) -> Path:
    """Write a calibration; one of the same name stays, under its date.

    Args:
        calibration: What to write.
        over: What need not stay: one that grows joint by joint, as it was written before.

    Returns:
        Its file.

    Raises:
        ConfigError: If it cannot be written. What was there then still is.
    """
    file = calibration_file(calibration.arm, calibration.name)
    text = calibration_text(calibration)
    own = [text] if over is None else [text, calibration_text(over)]
    with _blaming(file):
        if file.exists() and file.read_bytes() not in [words.encode() for words in own]:
            _put_aside(file)
    write_whole(file, text)
    return file


def rename_calibration(arm: str, name: str, fresh: str) -> Path:
    """Give a calibration another name.

    Returns:
        Its file.

    Raises:
        ConfigError: If there is none of that name, or already one of the other.
    """
    calibration = _read(arm, calibration_file(arm, name))
    file = calibration_file(arm, fresh)
    if is_there(file):
        raise ConfigError(file, "", "is there already; take another name")
    write_whole(file, calibration_text(replace(calibration, name=fresh)))
    former = calibration_file(arm, name)
    with _blaming(former):
        former.unlink()
    return file


def use_calibration(arm: str, name: str) -> Path:
    """Take a calibration in use; the one that was in use stays, under its date.

    Returns:
        The file that is in use.

    Raises:
        ConfigError: If there is none of that name, or it is broken.
    """
    calibration = _read(arm, calibration_file(arm, name))
    return save_calibration(replace(calibration, name=DEFAULT))


def _read(arm: str, file: Path) -> Calibration:
    """Read a calibration that must be there."""
    if not is_there(file):
        there = ", ".join(calibration_names(arm)) or "none"
        reason = f"there is no such calibration of {arm}; there are: {there}"
        raise ConfigError(file, "", reason)
    calibration = read_calibration(file)
    if calibration.name != file.stem:
        reason = f"is {calibration.name!r} in a file called {file.stem!r}; make them the same"
        raise ConfigError(file, "name", reason)
    return calibration


def _folder(arm: str) -> Path:
    """Give the folder of an arm; its name may have anything in it."""
    return user_folder() / "calibrations" / quote(arm, safe=" ").replace(".", "%2E")


def _put_aside(file: Path) -> None:
    """Keep what is there under its date; of a broken file the bytes as they are."""
    try:
        former = read_calibration(file)
    except ConfigError:
        file.replace(_free(file.with_name(f"{file.stem}-broken.toml.txt")))
        return
    if _is_elsewhere(file, former):
        return
    day = former.date.strftime("%Y%m%d-%H%M%S")
    aside = _free(file.with_name(f"{file.stem}-{day}{file.suffix}"))
    write_whole(aside, calibration_text(replace(former, name=aside.stem)))


def _is_elsewhere(file: Path, calibration: Calibration) -> bool:
    """Tell whether a calibration lies beside its file under another name too."""
    text = calibration_text(calibration)
    for other in file.parent.glob("*.toml"):
        with suppress(ConfigError):
            same = replace(read_calibration(other), name=calibration.name)
            if other != file and calibration_text(same) == text:
                return True
    return False


@contextmanager
def _blaming(file: Path) -> Iterator[None]:
    """Turn what the disk refuses into an error that names the file."""
    try:
        yield
    except OSError as error:
        raise ConfigError(file, "", f"cannot be kept ({error.strerror or error})") from error


def _free(file: Path) -> Path:
    """Give this file, or one like it that is not there yet."""
    names = (file.with_name(f"{file.stem}-{k}{file.suffix}") for k in range(2, 1000))
    return next(name for name in (file, *names) if not name.exists())
