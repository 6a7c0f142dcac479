"""Files that a command is about to write."""

from pathlib import Path

from splinearm.errors import ConfigError

_PICTURES = (".png", ".svg", ".pdf")


def require_new(*, rows: Path | None = None, picture: Path | None = None) -> None:
    """Refuse what could not be written in the end, before anything moves.

    Args:
        rows: A file for text.
        picture: A file for a picture; its ending says of which kind.

    Raises:
        ConfigError: With the file, if it is there already, its folder is not, both are the same,
            or its ending names no kind of picture.
    """
    if picture is not None and picture.suffix.lower() not in _PICTURES:
        raise ConfigError(picture, "", f"a picture's name ends in {', '.join(_PICTURES)}")
    if rows is not None and rows == picture:
        raise ConfigError(rows, "", "cannot hold both rows and picture; name two files")
    for file in (rows, picture):
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
