"""``splinearm virtual-bus ARM``: a line of virtual servos for any program that speaks to servos."""

import argparse
import sys
import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from splinearm.control.stop import StopRequest


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "virtual-bus",
        help="start virtual servos on a serial port of their own",
        description="Start an arm's servos virtually, on a pseudo terminal that any program can "
        "open as a serial port. Prints the port's name; Ctrl-C ends it.",
    )
    parser.add_argument("arm", help="a shipped arm or the path of an arm file")
    parser.add_argument(
        "--pose", default=None, help="named pose in which the arm stands (default: home)"
    )
    parser.add_argument("--start-deg", default=None, help="or its joint angles: 10,-20.5,...")
    parser.add_argument(
        "--until-eof",
        action="store_true",
        help="end when standard input does: for programs that start the bus themselves",
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Serve until interrupted."""
    from splinearm.backends import serve_virtual_bus
    from splinearm.config import load_cell
    from splinearm.control.stop import StopRequest

    from .words import start_of

    cell = load_cell(args.arm)
    q_start = start_of(cell, args.pose, args.start_deg)
    with StopRequest() as stop:
        if args.until_eof:
            threading.Thread(target=_stop_at_eof, args=(stop,), daemon=True).start()
        serve_virtual_bus(cell, q_start, stop, lambda port: print(f"port: {port}", flush=True))
    return 0


def _stop_at_eof(stop: "StopRequest") -> None:
    sys.stdin.read()
    stop.request()
