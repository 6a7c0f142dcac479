"""The facts about this computer, each behind a small function that may be pointed elsewhere."""

import grp
import importlib.metadata
import importlib.util
import os
import pwd
import stat
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from splinearm.control.realtime import Footing


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    """What the name of a port leads to."""

    path: str
    """The device itself, links followed."""
    is_terminal: bool
    """Whether it is a serial port or a pseudo terminal."""
    group: str = ""
    """The group that owns it."""
    group_may: bool = False
    """Whether that group may read and write it."""


def device_of(port: str) -> Device | None:
    """Give what a port's name leads to; None: nothing."""
    path = os.path.realpath(port)
    try:
        facts = Path(path).stat()
    except OSError:
        return None
    try:
        group = grp.getgrgid(facts.st_gid).gr_name
    except KeyError:
        group = str(facts.st_gid)
    may = facts.st_mode & (stat.S_IRGRP | stat.S_IWGRP) == stat.S_IRGRP | stat.S_IWGRP
    return Device(path=path, is_terminal=_is_terminal(facts), group=group, group_may=may)


def _is_terminal(facts: os.stat_result) -> bool:
    """Tell a serial port, or the end of a pseudo terminal, from other devices."""
    if not stat.S_ISCHR(facts.st_mode):
        return False
    number = f"{os.major(facts.st_rdev)}:{os.minor(facts.st_rdev)}"
    place = Path(os.path.realpath(f"/sys/dev/char/{number}"))
    return not place.exists() or place.parent.name == "tty"  # it names no pseudo terminals


def may_use(port: str) -> bool:
    """Tell whether this user may read and write a port."""
    return os.access(port, os.R_OK | os.W_OK)


def enrolled_groups() -> frozenset[str]:
    """Give the groups that this user is in from the next login on."""
    try:
        user = pwd.getpwuid(os.getuid()).pw_name
    except KeyError:
        return frozenset()
    return frozenset(group.gr_name for group in grp.getgrall() if user in group.gr_mem)


def place_of_module(name: str) -> str | None:
    """Give where a module's code begins; "" for a folder without code; None: there is none."""
    try:
        spec = importlib.util.find_spec(name)
    except (ImportError, ValueError):
        return None
    if spec is None:
        return None
    return spec.origin if spec.origin and spec.origin != "namespace" else ""


def version_of(distribution: str) -> str | None:
    """Give the version of an installed distribution; None: it is not installed."""
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return None


def has_library(name: str) -> bool:
    """Tell whether the system has a shared library, as in "EGL"."""
    from ctypes.util import find_library

    return find_library(name) is not None


def footing() -> "Footing":
    """Try what the system permits to a loop that must be on time, and give it back."""
    from splinearm.control.realtime import real_time

    with real_time() as permitted:
        return permitted


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Computer:
    """Where the checks take their facts from."""

    root: Path = Path("/")
    """The folder in which dev, proc and sys are."""
    python: tuple[int, int] = field(default_factory=lambda: sys.version_info[:2])
    """Version of Python."""
    environment: Mapping[str, str] = field(default_factory=lambda: os.environ)
    """The environment's variables."""
    device: Callable[[str], Device | None] = device_of
    """Gives what a port's name leads to."""
    may_use: Callable[[str], bool] = may_use
    """Tells whether the user may use a port."""
    enrolled: Callable[[], frozenset[str]] = enrolled_groups
    """Gives the groups that the user is in from the next login on."""
    module: Callable[[str], str | None] = place_of_module
    """Gives where a module's code begins."""
    version: Callable[[str], str | None] = version_of
    """Gives the version of an installed distribution."""
    has_library: Callable[[str], bool] = has_library
    """Tells whether the system has a shared library."""
    footing: Callable[[], "Footing"] = footing
    """Gives what the system permits to a loop that must be on time."""

    def folder(self, name: str) -> Path:
        """Give a folder of the system, as in "/proc"."""
        return self.root / name.lstrip("/")
