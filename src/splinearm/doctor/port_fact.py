"""What the system knows of a port: its adapter, who holds it, which others there are."""

import os
from dataclasses import dataclass
from pathlib import Path

from .computer import Computer, Device

_NAMES = ("ttyUSB*", "ttyACM*", "ttyDXL*")
_KNOWN = frozenset(
    (
        "0403",  # FTDI: U2D2, USB2DYNAMIXEL, many others
        "10c4",  # Silicon Labs CP210x
        "1a86",  # WCH CH340, CH343
        "067b",  # Prolific
        "04d8",  # Microchip MCP2200
        "2f5d",  # ROBOTIS: OpenRB-150
        "fff1",  # ROBOTIS: OpenCM 9.04
        "0483",  # ST: OpenCR
    )
)
"""Makers of USB adapters and boards that servos are known to hang on."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Adapter:
    """A USB device behind a port."""

    vendor: str
    """Its maker, as four hexadecimal digits."""
    product: str
    """Its kind, the same."""
    name: str
    """What it calls itself."""
    serial: str = ""
    """Its serial number; empty if it has none."""

    @property
    def is_known(self) -> bool:
        """Whether servos are known to hang on such adapters."""
        return self.vendor in _KNOWN


@dataclass(frozen=True, slots=True)
class Holder:
    """A process that has a port open."""

    pid: int
    """Its number."""
    name: str
    """Its name."""


def ports(computer: Computer) -> tuple[str, ...]:
    """Give the ports at which adapters are, by the names that they keep when plugged in anew."""
    folder = computer.folder("/dev")
    by_id = folder / "serial" / "by-id"
    links = sorted(by_id.iterdir()) if by_id.is_dir() else []
    known = {os.path.realpath(link) for link in links}
    devices = sorted(path for pattern in _NAMES for path in folder.glob(pattern))
    others = [path for path in devices if os.path.realpath(path) not in known]
    return tuple("/" + str(path.relative_to(computer.root)) for path in (*links, *others))


def adapter_of(computer: Computer, device: Device) -> Adapter | None:
    """Give the USB device behind a port; None: there is none."""
    place = computer.folder("/sys/class/tty") / Path(device.path).name / "device"
    folder = Path(os.path.realpath(place))
    for parent in (folder, *folder.parents):
        vendor = _text(parent / "idVendor")
        if vendor:
            words = (_text(parent / name) for name in ("manufacturer", "product"))
            name = " ".join(word for word in words if word)
            return Adapter(
                vendor=vendor,
                product=_text(parent / "idProduct"),
                name=name,
                serial=_text(parent / "serial"),
            )
    return None


def latency_of(computer: Computer, device: Device) -> float | None:
    """Give for how long the adapter of a port holds bytes back, s; None: it does not say."""
    place = computer.folder("/sys/class/tty") / Path(device.path).name / "device/latency_timer"
    text = _text(place)
    return int(text) * 1e-3 if text.isdigit() else None


def holders(computer: Computer, device: Device) -> tuple[Holder, ...]:
    """Give the other processes that have a port open, as far as this user may know.

    Who holds both ends of a pseudo terminal serves it and does not count.
    """
    found: list[Holder] = []
    for process in sorted(computer.folder("/proc").glob("[0-9]*"), key=lambda path: int(path.name)):
        opened = _opened(process)
        serves = any(name.endswith("/ptmx") for name in opened)
        if device.path in opened and int(process.name) != os.getpid() and not serves:
            found.append(Holder(int(process.name), _text(process / "comm") or "?"))
    return tuple(found)


def _opened(process: Path) -> set[str]:
    """Give the names of the files that a process has open."""
    names: set[str] = set()
    try:
        descriptors = list((process / "fd").iterdir())
    except OSError:
        return names
    for descriptor in descriptors:
        try:
            names.add(str(descriptor.readlink()))
        except OSError:
            continue
    return names


def _text(file: Path) -> str:
    """Give what a small file of the system says; nothing if it is not there."""
    try:
        return file.read_text(encoding="ascii", errors="replace").strip()
    except OSError:
        return ""
