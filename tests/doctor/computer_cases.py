"""What is done to a computer and its port, and what the doctor must say of it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from splinearm.control.realtime import Footing
from splinearm.doctor.computer import Device

PORT = "/dev/ttyUSB0"


@dataclass(frozen=True, kw_only=True)
class ComputerCase:
    """One fault of a computer or a port."""

    code: str
    """What must be found."""
    act: str
    """What is done, in words."""
    cause: str
    """What the cause must say (a regular expression)."""
    remedy: str
    """The same of the remedy."""
    hurt: Callable[[Any], None]
    """Hurts a ``FakeComputer``."""
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
    ComputerCase(
        code="P01",
        act="the adapter is not plugged in",
        hurt=lambda fake: fake.unplug(),
        cause="there is no such port",
        remedy="plug the adapter in.*no adapter at all",
    ),
    ComputerCase(
        code="P01",
        act="a wrong name; another adapter is there",
        hurt=lambda _: None,
        port="/dev/ttyUSB7",
        cause="there is no such port",
        remedy="now there is /dev/ttyUSB0",
    ),
    ComputerCase(
        code="P01",
        act="the socket of a virtual bus that has ended",
        hurt=lambda _: None,
        port="unix:/nowhere/bus",
        cause="nobody serves this socket",
        remedy="splinearm virtual-bus",
    ),
    ComputerCase(
        code="P02",
        act="the user is not in the port's group",
        hurt=_forbidden(),
        cause="for the group 'dialout', which you are not in",
        remedy=r"`sudo usermod -aG dialout \$USER`, then log out",
    ),
    ComputerCase(
        code="P02",
        act="the port is the administrator's alone",
        hurt=_forbidden(group="root", group_may=False),
        cause="only the administrator",
        remedy=r'idVendor.=="0403", ATTRS.idProduct.=="6014", MODE="0660".*udevadm.*usermod',
    ),
    ComputerCase(
        code="P03",
        act="the user was put into the group after logging in",
        hurt=_forbidden(enrolled=frozenset({"dialout"})),
        cause="not in this session",
        remedy="log out and in again, or run `newgrp dialout`",
    ),
    ComputerCase(
        code="P04",
        act="another program has the port open",
        hurt=lambda fake: fake.process(4711, "minicom", "/dev/null", PORT),
        cause=r"minicom \(process 4711\) has it open",
        remedy="kill 4711",
    ),
    ComputerCase(
        code="P04",
        act="ModemManager takes the adapter for a modem",
        hurt=lambda fake: fake.process(800, "ModemManager", PORT),
        cause=r"ModemManager \(process 800\)",
        remedy="systemctl disable --now ModemManager",
    ),
    ComputerCase(
        code="P05",
        act="the FTDI latency timer is at its 16 ms",
        hurt=lambda fake: fake.adapter(latency=16),
        cause="latency timer is 16 ms: no loop is quicker than 62 Hz",
        remedy="echo 1 | sudo tee /sys/class/tty/ttyUSB0/device/latency_timer.*99-splinearm.rules",
    ),
    ComputerCase(
        code="P07",
        act="the name of a file",
        hurt=_no_terminal,
        cause="no serial port",
        remedy="name the port of the adapter",
    ),
    ComputerCase(
        code="C01",
        act="Python 3.10",
        hurt=_fact("python", (3, 10)),
        cause="Python 3.10; splinearm needs 3.11",
        remedy="python3.11 -m pip install",
    ),
    ComputerCase(
        code="C02",
        act="pyserial is not installed",
        hurt=_missing("serial"),
        cause="pyserial is not there",
        remedy="pip install --force-reinstall pyserial",
    ),
    ComputerCase(
        code="C02",
        act="the maker's SDK is not installed",
        hurt=_missing("dynamixel_sdk"),
        cause="dynamixel-sdk is not there",
        remedy="pip install --force-reinstall dynamixel-sdk",
    ),
    ComputerCase(
        code="C03",
        act="MuJoCo 3.2 is installed",
        hurt=_fact("version", lambda _: "3.2.7"),
        cause="MuJoCo is 3.2.7",
        remedy=_PIP_MUJOCO,
    ),
    ComputerCase(
        code="C03",
        act="an update of MuJoCo has left an empty folder",
        hurt=_fact("module", lambda name: "" if name == "mujoco" else "/lib/x.py"),
        cause="the folder of MuJoCo has no code",
        remedy=_PIP_MUJOCO,
    ),
    ComputerCase(
        code="C04",
        act="the extra log is not installed",
        hurt=_missing("mcap"),
        cause="'log' is not installed",
        remedy=r"pip install 'splinearm\[log\]'",
    ),
    ComputerCase(
        code="C05",
        act="neither display nor EGL",
        hurt=_dark,
        cause="no display, and neither EGL",
        remedy="apt install libegl1 libgl1",
    ),
    ComputerCase(
        code="C06",
        act="no permission for real-time priority",
        hurt=_fact("footing", lambda: Footing(fifo=False, locked=False)),
        cause="no real-time priority",
        remedy="limits.conf",
    ),
)

SILENT_CASES = (
    ComputerCase(
        code="P06",
        act="a GPS receiver's port",
        hurt=lambda fake: fake.adapter(vendor="1546", product="01a8", name="u-blox GNSS"),
        cause=r"u-blox GNSS \(1546:01a8\), not known as an adapter",
        remedy="splinearm doctor PORT",
    ),
    ComputerCase(
        code="P06",
        act="a port of the computer's own board",
        hurt=_board_port,
        port="/dev/ttyS0",
        cause="a port of the computer itself",
        remedy="splinearm doctor PORT",
    ),
)
"""Ports on which nobody answers."""
