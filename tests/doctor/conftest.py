"""Patients for the doctor: virtual arms to hurt, and computers made of a folder."""

import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # line_cases, computer_cases

from splinearm.backends import centred
from splinearm.config import load_cell
from splinearm.control.realtime import Footing
from splinearm.doctor.computer import Computer, Device
from splinearm.sim.virtual_bus import VirtualBus


@contextmanager
def virtual(arm: str, transport: str = "socket", **options):
    """A cell and the virtual bus of its arm, at home."""
    cell = load_cell(arm)
    home = cell.poses["home"]
    with VirtualBus(cell.arm, centred(cell.chain), home, transport=transport, **options) as bus:
        yield cell, bus


@pytest.fixture(name="virtual")
def _virtual():
    return virtual


class FakeComputer:
    """A computer whose dev, proc and sys lie in a folder; one adapter is plugged in."""

    port = "/dev/ttyUSB0"

    def __init__(self, root: Path) -> None:
        self.root = root
        self.facts: dict[str, object] = {
            "python": (3, 11),
            "environment": {"DISPLAY": ":0"},
            "device": self._device,
            "may_use": lambda _: True,
            "enrolled": lambda: frozenset({"dialout"}),
            "module": lambda name: f"/lib/{name}/__init__.py",
            "version": lambda _: "4.0.0",
            "has_library": lambda _: True,
            "footing": lambda: Footing(fifo=True, locked=True),
        }
        self.devices = {
            self.port: Device(path=self.port, is_terminal=True, group="dialout", group_may=True)
        }
        self.file(self.port, "")
        self.adapter()

    def _device(self, port: str) -> Device | None:
        return self.devices.get(port)

    def file(self, name: str, text: str) -> Path:
        """Write a file of the system."""
        file = self.root / name.lstrip("/")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="ascii")
        return file

    def adapter(
        self, vendor: str = "0403", product: str = "6014", name: str = "U2D2", latency: int = 1
    ) -> None:
        """Plug an adapter in."""
        usb = "/sys/devices/usb1/1-1"
        for key, value in (("idVendor", vendor), ("idProduct", product), ("product", name)):
            self.file(f"{usb}/{key}", value + "\n")
        self.file(f"{usb}/1-1:1.0/ttyUSB0/latency_timer", f"{latency}\n")
        place = self.root / "sys/class/tty/ttyUSB0"
        place.mkdir(parents=True, exist_ok=True)
        link = place / "device"
        if not link.is_symlink():
            link.symlink_to(self.root / "sys/devices/usb1/1-1/1-1:1.0/ttyUSB0")

    def unplug(self) -> None:
        """Pull the adapter out."""
        self.devices.clear()
        (self.root / "dev/ttyUSB0").unlink()

    def process(self, pid: int, name: str, *opened: str) -> None:
        """Let a process run that has files open."""
        self.file(f"/proc/{pid}/comm", name + "\n")
        folder = self.root / f"proc/{pid}/fd"
        folder.mkdir()
        for k, file in enumerate(opened):
            (folder / str(k)).symlink_to(file)

    @property
    def computer(self) -> Computer:
        return Computer(root=self.root, **self.facts)


@pytest.fixture
def fake(tmp_path) -> FakeComputer:
    return FakeComputer(tmp_path)
