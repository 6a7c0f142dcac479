"""``splinearm virtual-bus ARM``: a line of virtual servos for any program that speaks to servos."""

import argparse
import gc
import sys
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING

from splinearm.errors import ConfigError

if TYPE_CHECKING:
    from splinearm.control.stop import StopRequest
    from splinearm.sim.line_fault import LineFault
    from splinearm.sim.virtual_bus import VirtualBus

_ORDERS = """
Orders, one a line on standard input (with --orders):
  fault WHAT [id=N] [p=SHARE] [n=TIMES] [for=SECONDS] [by=SECONDS] [size=BYTES]
        WHAT: lost, corrupt, garbled, truncated, doubled, late, noise, echo, dead, pause
  clear      no fault any more
  unplug     the port vanishes
  plug in    it comes back under another name, which is printed
  connect NAME, disconnect NAME
             a servo's own cable, with data and power; NAME is its name in the arm's file, or all
  power off, power on
             the supply of all servos
"""


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "virtual-bus",
        help="start virtual servos on a serial port of their own",
        description="Start an arm's servos virtually, on a pseudo terminal that any program can "
        "open as a serial port. Prints the port's name; Ctrl-C ends it.",
        epilog=_ORDERS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("arm", help="a shipped arm or the path of an arm file")
    parser.add_argument(
        "--pose", default=None, help="named pose in which the arm stands (default: home)"
    )
    parser.add_argument("--start-deg", default=None, help="or its joint angles: 10,-20.5,...")
    parser.add_argument(
        "--transport",
        choices=("pty", "socket"),
        default="pty",
        help="a pseudo terminal, or a unix socket: quicker and steadier, for splinearm only",
    )
    parser.add_argument(
        "--usb-latency-ms",
        type=float,
        default=0.0,
        help="hold replies back to such ticks, as an FTDI adapter does (default: 0, not at all)",
    )
    parser.add_argument(
        "--realtime", action="store_true", help="go before other programs, where permitted"
    )
    parser.add_argument(
        "--fresh",
        action="store_true",
        help="servos as they come out of the box: factory settings, and none connected until an "
        "order does it",
    )
    parser.add_argument("--link", type=Path, default=None, help="symbolic link to the port")
    parser.add_argument(
        "--fault",
        action="append",
        type=_fault_word,
        default=[],
        help='what goes wrong, as in "lost id=3 p=0.01"; may be given often',
    )
    parser.add_argument("--seed", type=int, default=0, help="of the faults' dice (default: 0)")
    parser.add_argument("--orders", action="store_true", help="take orders from standard input")
    parser.add_argument(
        "--until-eof",
        action="store_true",
        help="end when standard input does: for programs that start the bus themselves",
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Serve until interrupted."""
    from splinearm.backends import centred, require_chain
    from splinearm.config import load_cell
    from splinearm.control.stop import StopRequest
    from splinearm.sim.virtual_bus import VirtualBus

    from .words import start_of

    _check(args)
    cell = load_cell(args.arm)
    q_start = start_of(cell, args.pose, args.start_deg)
    bus = VirtualBus(
        cell.arm,
        centred(require_chain(cell)),
        q_start,
        transport=args.transport,
        usb_latency=args.usb_latency_ms * 1e-3,
        realtime=args.realtime,
        link=args.link,
        seed=args.seed,
        fresh=args.fresh,
    )
    bus.faults = tuple(args.fault)
    gc.freeze()  # what is there by now stays: the collector need not look at it while servos answer
    with StopRequest() as stop, bus:
        print(f"port: {bus.port}", flush=True)
        for refusal in bus.refused:
            print(f"not permitted: {refusal}", flush=True)
        if args.until_eof or args.orders:
            threading.Thread(target=_listen, args=(bus, stop, args), daemon=True).start()
        while not stop.requested:
            time.sleep(0.05)
    return 0


def _check(args: argparse.Namespace) -> None:
    """Refuse what no bus can have.

    Raises:
        ConfigError: With the word and what came.
    """
    latency = args.usb_latency_ms
    if not 0.0 <= latency <= 1000.0:
        raise ConfigError("--usb-latency-ms", "", f"wants 0 to 1000 ms, got {latency:g}")
    if args.link is not None and args.link.exists() and not args.link.is_symlink():
        raise ConfigError("--link", "", f"{args.link} is there and is no link; take another name")


def _listen(bus: "VirtualBus", stop: "StopRequest", args: argparse.Namespace) -> None:
    """Take orders until standard input ends."""
    for line in sys.stdin:
        if args.orders:
            try:
                _take_order(bus, line.strip())
            except (ValueError, RuntimeError) as error:
                print(f"not understood: {error}", flush=True)
    if args.until_eof:
        stop.request()


def _take_order(bus: "VirtualBus", order: str) -> None:
    if order.startswith("fault "):
        bus.faults = (*bus.faults, _fault(order.removeprefix("fault ")))
    elif order == "clear":
        bus.faults = ()
    elif order == "unplug":
        bus.unplug()
    elif order == "plug in":
        print(f"port: {bus.plug_in()}", flush=True)
    elif order in ("power on", "power off"):
        bus.harness.power(on=order == "power on")
    elif order.startswith("connect "):
        bus.harness.connect(*_named(order))
    elif order.startswith("disconnect "):
        bus.harness.disconnect(*_named(order))
    elif order:
        raise ValueError(
            f"want fault, clear, unplug or plug in, connect, disconnect or power, got {order!r}"
        )


def _named(order: str) -> tuple[str, ...]:
    """Give the servos that an order names; none for all of them."""
    name = order.partition(" ")[2].strip()
    return () if name == "all" else (name,)


def _fault(text: str) -> "LineFault":
    from splinearm.sim.line_fault import LineFault

    return LineFault.parse(text)


def _fault_word(text: str) -> "LineFault":
    """Read a fault of the command line, where only one kind of error is told in its own words."""
    try:
        return _fault(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
