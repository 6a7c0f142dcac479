"""Which port a command means: the one that is named, the arm's usual one, or the one adapter."""

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING

from splinearm.errors import ConfigError

from . import doctor

if TYPE_CHECKING:
    from splinearm.config import Cell

VIRTUAL = "virtual"
"""What ``--on virtual`` says in place of a port."""


def add_port(parser: argparse.ArgumentParser, *, virtual: bool = True) -> None:
    """Declare ``--port`` and, unless that makes no sense, ``--on virtual``.

    Args:
        parser: The command's parser.
        virtual: Whether the command can start a virtual bus of its own.
    """
    parser.add_argument(
        "--port",
        default=None,
        metavar="P",
        help="the serial port (default: the arm file's, or the only adapter that is there)",
    )
    if virtual:
        parser.add_argument(
            "--on",
            choices=(VIRTUAL,),
            default=None,
            help="virtual: servos on a virtual bus instead of a port",
        )


def port_of(
    args: argparse.Namespace,
    cell: "Cell | None",
    *,
    announce: Callable[[str], object] | None = None,
) -> str:
    """Give the port that is meant: "virtual" or the name of a port.

    Args:
        args: What was said, with ``port`` and perhaps ``on``.
        cell: The arm; None: whichever is there.
        announce: Is told in a line which port was found, where nobody named it.

    Raises:
        ConfigError: If it is not clear, with the ports that are there.
    """
    from splinearm.commissioning.ports import usb_ports

    named = getattr(args, "on", None) or getattr(args, "port", None)
    if named is not None:
        return str(named)
    computer = doctor.this_computer()
    usual = None if cell is None or cell.chain is None else cell.chain.usual_port
    if usual is not None and computer.device(usual) is not None:
        return usual
    there = usb_ports(computer)
    adapters = [port for port in there if port.is_adapter]
    if len(adapters) == 1:
        if announce is not None:
            announce(f"port: {adapters[0]}")
        return adapters[0].port
    listed = ", ".join(map(str, adapters or there))
    if len(adapters) > 1:
        raise ConfigError("--port", "", f"there is more than one adapter; name one: {listed}")
    gone = f"the arm's usual port {usual} is not there, and " if usual is not None else ""
    found = f"none of these is known as one: {listed}" if there else "none is plugged in"
    more = ", or use --on virtual" if hasattr(args, "on") else ""
    raise ConfigError(
        "--port",
        "",
        f"{gone}no adapter for servos was found ({found}); plug it in, or name the port{more}",
    )
