"""What is wrong with a port before a byte is sent."""

from collections.abc import Iterator
from pathlib import Path

from splinearm.errors import PortError

from .catalogue import found
from .computer import Computer, Device
from .finding import Finding
from .port_fact import adapter_of, holders, latency_of, ports

_SHORT = 1.5e-3  # s: adapters hold bytes back for 1 ms at least
_SOCKET = "unix:"
_RULES = "/etc/udev/rules.d/99-splinearm.rules"
_RELOAD = "sudo udevadm control --reload && sudo udevadm trigger --action=add"


def check_port(computer: Computer, port: str) -> Iterator[Finding]:
    """Look at a port without opening it."""
    if port.startswith(_SOCKET):
        if not Path(port.removeprefix(_SOCKET)).exists():
            yield _missing(computer, port)
        return
    device = computer.device(port)
    if device is None:
        yield _missing(computer, port)
    elif not device.is_terminal:
        yield found("P07", port, "it is a file or a folder, no serial port", _name_one(computer))
    elif not computer.may_use(port):
        yield _forbidden(computer, port, device)
    else:
        yield from _check_use(computer, port, device)


def check_silent_port(computer: Computer, port: str) -> Iterator[Finding]:
    """Look at what hangs on a port on which nobody answers."""
    device = computer.device(port)
    if device is None or port.startswith(_SOCKET) or device.path.startswith("/dev/pts/"):
        return
    adapter = adapter_of(computer, device)
    if adapter is None:
        cause = "no USB adapter is behind it: it is a port of the computer itself"
    elif not adapter.is_known:
        cause = (
            f"behind it is {adapter.name or 'a device'} ({adapter.vendor}:{adapter.product}), "
            "not known as an adapter for servos, and no servo answers"
        )
    else:
        return
    yield found("P06", port, cause, _name_one(computer))


def unusable(error: PortError) -> Finding:
    """Make the finding of a port that could not be opened, or was lost."""
    if "another program" in error.reason:
        cause = "a program that this user cannot see has it open"
        return found("P04", error.port, cause, f"run `sudo fuser -v {error.port}` and end it")
    return found("P08", error.port, error.reason, error.remedy)


def _missing(computer: Computer, port: str) -> Finding:
    if port.startswith(_SOCKET):
        remedy = "start what serves it, as `splinearm virtual-bus` does, then this"
        return found("P01", port, "nobody serves this socket", remedy)
    remedy = (
        f"plug the adapter in, then look again with `ls /dev/serial/by-id`; {_present(computer)}"
    )
    return found("P01", port, "there is no such port", remedy)


def _present(computer: Computer) -> str:
    there = ports(computer)
    return f"now there is {', '.join(there)}" if there else "now there is no adapter at all"


def _name_one(computer: Computer) -> str:
    return f"name the port of the adapter: `splinearm doctor PORT`; {_present(computer)}"


def _forbidden(computer: Computer, port: str, device: Device) -> Finding:
    """Say what a user must do to be allowed to open a port."""
    group = device.group
    if device.group_may and group in computer.enrolled():
        cause = f"you are in the group {group!r}, but not in this session, which began before"
        return found("P03", port, cause, f"log out and in again, or run `newgrp {group}`")
    if device.group_may and group != "root":
        remedy = f"run `sudo usermod -aG {group} $USER`, then log out and in again"
        return found("P02", port, f"it is for the group {group!r}, which you are not in", remedy)
    adapter = adapter_of(computer, device)
    which = f'KERNEL=="{Path(device.path).name}"'
    if adapter is not None:
        which = f'ATTRS{{idVendor}}=="{adapter.vendor}", ATTRS{{idProduct}}=="{adapter.product}"'
    rule = f'SUBSYSTEM=="tty", {which}, MODE="0660", GROUP="dialout"'
    return found(
        "P02",
        port,
        "only the administrator may open it",
        f"run `echo '{rule}' | sudo tee -a {_RULES} && {_RELOAD}` and "
        "`sudo usermod -aG dialout $USER`, then log out and in again",
    )


def _check_use(computer: Computer, port: str, device: Device) -> Iterator[Finding]:
    for holder in holders(computer, device):
        remedy = f"end it (Ctrl-C where it runs, or `kill {holder.pid}`)"
        if holder.name == "ModemManager":
            remedy = "run `sudo systemctl disable --now ModemManager`: it takes adapters for modems"
        cause = f"{holder.name} (process {holder.pid}) has it open"
        yield found("P04", port, cause, remedy)
    latency = latency_of(computer, device)
    if latency is not None and latency > _SHORT:
        yield _slow_adapter(port, device, latency)


def late_answers(port: str, tick: float) -> Finding:
    """Make the finding of answers that come at ticks of a time (s) where no adapter says why."""
    return found(
        "P05",
        port,
        f"answers are handed over only every {tick * 1e3:.0f} ms, and no latency timer says why",
        "plug the adapter straight into the computer: no hub, and no virtual machine between",
    )


def _slow_adapter(port: str, device: Device, latency: float) -> Finding:
    now = f"echo 1 | sudo tee /sys/class/tty/{Path(device.path).name}/device/latency_timer"
    rule = 'ACTION=="add", SUBSYSTEM=="usb-serial", DRIVER=="ftdi_sio", ATTR{latency_timer}="1"'
    return found(
        "P05",
        port,
        f"its USB latency timer is {latency * 1e3:.0f} ms: no loop is quicker than "
        f"{1.0 / latency:.0f} Hz",
        f"run `{now}`; for good: `echo '{rule}' | sudo tee -a {_RULES} && {_RELOAD}`",
    )
