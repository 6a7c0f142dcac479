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
def watching(where: str | None, cell: "Cell", show: "Watch | None" = None) -> "Iterator[Watch]":
    """Give what gets every cycle: ``show``, and whoever listens at a HOST:PORT.

    Raises:
        ConfigError: If there is no such address.
    """
    shown: Watch = show if show is not None else _ignore
    if where is None:
        yield shown
        return
    from splinearm.monitoring.motion import MotionDatagrams

    from .output import console

    send = MotionDatagrams(where, cell.arm.joint_names, cell.arm.limits.kinds)

    def both(cycle: "Cycle") -> None:
        shown(cycle)
        send(cycle)

    try:
        yield both
    finally:
        send.close()
        if send.unsent:
            console.print(f"{send.unsent} datagrams could not be sent to {where}", markup=False)


def _ignore(_: object) -> None:
    """Show nothing."""
