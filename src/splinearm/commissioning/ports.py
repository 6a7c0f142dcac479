"""The USB ports of this computer by what is behind them, so that an adapter is found by itself."""

from dataclasses import dataclass

from splinearm.doctor.computer import Computer
from splinearm.doctor.port_fact import adapter_of, ports

_KINDS = {
    ("0403", "6014"): "U2D2",
    ("0403", "6001"): "FT232R, as in USB2DYNAMIXEL",
    ("0403", "6015"): "FT230X",
    ("2f5d", "2202"): "OpenRB-150",
    ("fff1", "ff48"): "OpenCM 9.04",
    ("0483", "5740"): "STM32, as in OpenCR",
    ("1a86", "7523"): "CH340",
    ("1a86", "55d3"): "CH343",
    ("1a86", "55d4"): "CH9102",
    ("10c4", "ea60"): "CP210x",
    ("04d8", "00df"): "MCP2200",
    ("067b", "2303"): "PL2303",
}
"""What adapters and boards are called that servos hang on, by vendor and product."""


@dataclass(frozen=True, slots=True, kw_only=True)
class UsbPort:
    """A serial port that a USB device makes."""

    device: str
    """The device now, as in "/dev/ttyUSB0"; another one perhaps when it is plugged in again."""
    by_id: str | None
    """The name that it keeps; None: the system gives none."""
    vendor: str
    """Maker of the USB device, as four hexadecimal digits; empty: it is none."""
    product: str
    """Its kind, the same."""
    serial: str
    """Its serial number; empty: it has none."""
    name: str
    """What it calls itself."""
    is_adapter: bool
    """Whether servos are known to hang on such devices."""

    @property
    def port(self) -> str:
        """The name to use: one that stays the same, if there is one."""
        return self.by_id or self.device

    @property
    def kind(self) -> str:
        """What it is, as far as that is known."""
        return _KINDS.get((self.vendor, self.product), self.name or "unknown device")

    def __str__(self) -> str:
        usb = f", {self.vendor}:{self.product}" if self.vendor else ""
        return f"{self.port} ({self.kind}{usb})"


def usb_ports(computer: Computer | None = None) -> tuple[UsbPort, ...]:
    """Give the ports of USB devices, by name.

    Args:
        computer: Where facts about this computer come from; None: this computer.
    """
    computer = Computer() if computer is None else computer
    return tuple(_port(computer, name) for name in ports(computer))


def _port(computer: Computer, name: str) -> UsbPort:
    """Look at one port."""
    device = computer.device(name)
    adapter = None if device is None else adapter_of(computer, device)
    is_link = device is not None and device.path != name
    return UsbPort(
        device=name if device is None else device.path,
        by_id=name if is_link else None,
        vendor="" if adapter is None else adapter.vendor,
        product="" if adapter is None else adapter.product,
        serial="" if adapter is None else adapter.serial,
        name="" if adapter is None else adapter.name,
        is_adapter=adapter is not None and adapter.is_known,
    )
