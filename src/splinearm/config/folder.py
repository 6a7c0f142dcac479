"""Where a user's own files lie: calibrations, backups. No update of the program touches it."""

import json
import os
import sys
from contextlib import suppress
from pathlib import Path

from splinearm.errors import ConfigError

HOME = "SPLINEARM_HOME"
"""The environment variable that puts the folder elsewhere."""

_NAME = "splinearm"


def user_folder() -> Path:
    """Give the folder of the user's own files; it need not exist yet.

    $SPLINEARM_HOME if that is set; else ``splinearm`` in the configuration folder of the system:
    $XDG_CONFIG_HOME or ~/.config, on Windows %APPDATA%, on macOS ~/Library/Application Support.

    Raises:
        ConfigError: If whose home is meant is nobody's.
    """
    own = os.environ.get(HOME)
    try:
        if own:
            return Path(own).expanduser().absolute()
        return _configuration_folder(sys.platform) / _NAME
    except RuntimeError as error:  # ~somebody, or a user without a home
        reason = f"there is no such home folder; set {HOME} to a folder"
        raise ConfigError(own or "~", "", reason) from error


def _configuration_folder(platform: str) -> Path:
    """Give where programs keep what is a user's own."""
    if platform == "win32":
        roaming = os.environ.get("APPDATA")
        return Path(roaming) if roaming else Path.home() / "AppData" / "Roaming"
    if platform == "darwin":
        return Path.home() / "Library" / "Application Support"
    xdg = os.environ.get("XDG_CONFIG_HOME", "")
    # the XDG Base Directory Specification 0.8: a path that is not absolute is to be ignored
    return Path(xdg) if Path(xdg).is_absolute() else Path.home() / ".config"


def is_there(file: Path) -> bool:
    """Say whether a file is there.

    Raises:
        ConfigError: If that cannot be told, or no file can have that name.
    """
    try:
        return file.exists()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ConfigError(file, "", f"cannot be looked at ({reason}); check its name") from error


def write_whole(file: Path, text: str) -> None:
    """Write a file so that whenever the computer stops it is the old one or the new one, whole.

    The folder is made if need be. What the file was is gone afterwards.

    Raises:
        ConfigError: If it cannot be written; the old one then is still there.
    """
    draft = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with draft.open("w", encoding="utf-8", newline="\n") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        draft.replace(file)
        _sync_folder(file.parent)
    except OSError as error:
        with suppress(OSError):
            draft.unlink()
        reason = error.strerror or str(error)
        remedy = f"make room, or choose another folder (of your own files: {HOME})"
        raise ConfigError(file, "", f"cannot be written ({reason}); {remedy}") from error


def quoted(text: str) -> str:
    """Give a text as a basic string of TOML: that of JSON, where DEL must be escaped too."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _sync_folder(folder: Path) -> None:
    """Have the folder's entries on the disk too; where a folder cannot be opened that is so."""
    if sys.platform != "win32":
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
