"""``--udp``: every cycle of a motion sent to another program while the arm moves."""

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from splinearm.config import Cell
    from splinearm.control.cycle import Cycle

    Watch = Callable[[Cycle], object]


def add_udp(parser: argparse.ArgumentParser) -> None:
    """Declare the word."""
    parser.add_argument(
        "--udp",
        default=None,
        metavar="HOST:PORT",
        help="send every cycle there as JSON, for PlotJuggler",
    )


@contextmanager
def watching(where: str | None, cell: "Cell") -> "Iterator[Watch]":
    """Give what gets every cycle: whoever listens at a HOST:PORT; nobody without one.

    Raises:
        ConfigError: If there is no such address.
    """
    if where is None:
        yield _ignore
        return
    from splinearm.monitoring.motion import MotionDatagrams

    from .output import console

    send = MotionDatagrams(where, cell.arm.joint_names, cell.arm.limits.kinds)

    try:
        yield send
    finally:
        send.close()
        if send.unsent:
            console.print(f"{send.unsent} datagrams could not be sent to {where}")


def _ignore(_: object) -> None:
    """Send nothing."""
