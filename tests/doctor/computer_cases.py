"""What is done to a computer and its port, and what the doctor must say of it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from fault_case import FaultCase, nothing

from splinearm.control.realtime import Footing
from splinearm.doctor.computer import Device

PORT = "/dev/ttyUSB0"


@dataclass(frozen=True, kw_only=True)
class ComputerCase(FaultCase):
    """One fault of a computer or a port; ``hurt`` gets a ``FakeComputer``."""

    port: str = PORT


def _fact(name: str, value: Any) -> Callable[[Any], None]:
    def hurt(fake: Any) -> None:
        fake.facts[name] = value

    return hurt


def _missing(module: str) -> Callable[[Any], None]:
    return _fact("module", lambda name: None if name == module else f"/lib/{name}/__init__.py")


def _forbidden(**facts: Any) -> Callable[[Any], None]:
    """Forbid the port; give what owns it, and which groups the user is in."""

    def hurt(fake: Any) -> None:
        fake.facts["may_use"] = lambda _: False
        fake.facts["enrolled"] = lambda: facts.get("enrolled", frozenset())
        fake.devices[PORT] = Device(
            path=PORT,
            is_terminal=True,
            group=facts.get("group", "dialout"),
            group_may=facts.get("group_may", True),
        )

    return hurt


def _no_terminal(fake: Any) -> None:
    fake.devices[PORT] = Device(path=PORT, is_terminal=False)


def _board_port(fake: Any) -> None:
    fake.devices["/dev/ttyS0"] = Device(path="/dev/ttyS0", is_terminal=True, group="dialout")


def _dark(fake: Any) -> None:
    fake.facts["environment"] = {}
    fake.facts["has_library"] = lambda _: False


_PIP_MUJOCO = "pip uninstall -y mujoco mujoco-core && pip install mujoco"

COMPUTER_CASES = (
    ComputerCase("P01", "the adapter is not plugged in", lambda fake: fake.unplug(),
                 "there is no such port", "plug the adapter in.*no adapter at all"),
    ComputerCase("P01", "a wrong name; another adapter is there", nothing,
                 "there is no such port", "now there is /dev/ttyUSB0", port="/dev/ttyUSB7"),
    ComputerCase("P01", "the socket of a virtual bus that has ended", nothing,
                 "nobody serves this socket", "splinearm virtual-bus", port="unix:/nowhere/bus"),
    ComputerCase("P02", "the user is not in the port's group", _forbidden(),
                 "for the group 'dialout', which you are not in",
                 r"`sudo usermod -aG dialout \$USER`, then log out"),
    ComputerCase("P02", "the port is the administrator's alone",
                 _forbidden(group="root", group_may=False),
                 "only the administrator",
                 r'idVendor.=="0403", ATTRS.idProduct.=="6014", MODE="0660".*udevadm.*usermod'),
    ComputerCase("P03", "the user was put into the group after logging in",
                 _forbidden(enrolled=frozenset({"dialout"})),
                 "not in this session", "log out and in again, or run `newgrp dialout`"),
    ComputerCase("P04", "another program has the port open",
                 lambda fake: fake.process(4711, "minicom", "/dev/null", PORT),
                 r"minicom \(process 4711\) has it open", "kill 4711"),
    ComputerCase("P04", "ModemManager takes the adapter for a modem",
                 lambda fake: fake.process(800, "ModemManager", PORT),
                 r"ModemManager \(process 800\)", "systemctl disable --now ModemManager"),
    ComputerCase("P05", "the FTDI latency timer is at its 16 ms",
                 lambda fake: fake.adapter(latency=16),
                 "latency timer is 16 ms: no loop is quicker than 62 Hz",
                 r"echo 1 . sudo tee \S+/ttyUSB0/device/latency_timer.*99-splinearm.rules"),
    ComputerCase("P07", "the name of a file", _no_terminal,
                 "no serial port", "name the port of the adapter"),
    ComputerCase("C01", "Python 3.10", _fact("python", (3, 10)),
                 "Python 3.10; splinearm needs 3.11", "python3.11 -m pip install"),
    ComputerCase("C02", "pyserial is not installed", _missing("serial"),
                 "pyserial is not there", "pip install --force-reinstall pyserial"),
    ComputerCase("C02", "the maker's SDK is not installed", _missing("dynamixel_sdk"),
                 "dynamixel-sdk is not there", "pip install --force-reinstall dynamixel-sdk"),
    ComputerCase("C03", "MuJoCo 3.2 is installed", _fact("version", lambda _: "3.2.7"),
                 "MuJoCo is 3.2.7", _PIP_MUJOCO),
    ComputerCase("C03", "an update of MuJoCo has left an empty folder",
                 _fact("module", lambda name: "" if name == "mujoco" else "/lib/x.py"),
                 "the folder of MuJoCo has no code", _PIP_MUJOCO),
    ComputerCase("C04", "the extra log is not installed", _missing("mcap"),
                 "'log' is not installed", r"pip install 'splinearm\[log\]'"),
    ComputerCase("C05", "neither display nor EGL", _dark,
                 "no display, and neither EGL", "apt install libegl1 libgl1"),
    ComputerCase("C06", "no permission for real-time priority",
                 _fact("footing", lambda: Footing(fifo=False, locked=False)),
                 "no real-time priority", "limits.conf"),
)  # fmt: skip

SILENT_CASES = (
    ComputerCase("P06", "a GPS receiver's port",
                 lambda fake: fake.adapter(vendor="1546", product="01a8", name="u-blox GNSS"),
                 r"u-blox GNSS \(1546:01a8\), not known as an adapter", "splinearm doctor PORT"),
    ComputerCase("P06", "a port of the computer's own board", _board_port,
                 "a port of the computer itself", "splinearm doctor PORT", port="/dev/ttyS0"),
)  # fmt: skip
"""Ports on which nobody answers."""
