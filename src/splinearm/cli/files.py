"""Files that a command is about to write."""

from pathlib import Path

from splinearm.errors import ConfigError


def require_new(*files: Path | None) -> None:
    """Refuse files that are there already, or whose folder is not, before anything moves.

    Raises:
        ConfigError: With the file.
    """
    for file in files:
        if file is None:
            continue
        if file.exists():
            raise ConfigError(file, "", "is there already and is not overwritten; name another")
        if not file.parent.is_dir():
            raise ConfigError(file, "", "its folder is not there; make it first")


def new_folder(parent: Path, stem: str) -> Path:
    """Make a folder that was not there: ``stem-1``, ``stem-2`` and so on in ``parent``.

    Raises:
        ConfigError: If it cannot be made.
    """
    try:
        parent.mkdir(parents=True, exist_ok=True)
        number = 1
        while (parent / f"{stem}-{number}").exists():
            number += 1
        folder = parent / f"{stem}-{number}"
        folder.mkdir()
    except OSError as error:
        raise ConfigError(parent, "", f"no folder can be made there: {error.strerror}") from error
    return folder
