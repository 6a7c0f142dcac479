"""``splinearm monitor [ARM]``: how the servos fare, live; nothing is written to them."""

import argparse
import os
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from .port_words import VIRTUAL, add_port, port_of

if TYPE_CHECKING:
    from splinearm.config import Cell
    from splinearm.control.stop import StopRequest
    from splinearm.monitoring import Monitor, Sample
    from splinearm.monitoring.outlet import Outlet

    from .keyboard import Keyboard
    from .monitor_table import Show

_PAUSE = 0.02
"""How long a key is waited for before samples are taken again, s."""
_TRIES = 3
"""So often ``--once`` looks before who is silent counts as that."""
_LEAST, _MOST = 0.1, 1000.0
"""Bounds of ``--rate``, Hz."""

_EPILOG = """It reads and never writes: torque stays as it is, and nothing moves.

exit codes:
    0  it was watched until q, Ctrl-C or the end of --for; --once: nothing is wrong
    1  --once: a row is red
    2  it could not begin: the port, the arm's file or a word on the command line

PlotJuggler takes --udp localhost:9870: Streaming, "UDP Server", protocol JSON,
"use timestamp"."""


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "monitor",
        help="watch servos: positions, loads, heat, errors, losses",
        description="Show how servos fare, live: of an arm, or without one of whatever answers\n"
        "on a port. q or Ctrl-C ends.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "arm",
        nargs="?",
        default=None,
        help="the arm's file, or the name of an arm that is shipped (default: whoever answers)",
    )
    add_port(parser)
    parser.add_argument(
        "--baud",
        type=int,
        default=None,
        help="bits per second (default: the arm file's, or the rate at which servos answer)",
    )
    parser.add_argument(
        "--rate", type=float, default=None, metavar="HZ", help="samples a second (default: 50)"
    )
    parser.add_argument(
        "--json", action="store_true", help="print each sample as a line of JSON instead"
    )
    parser.add_argument(
        "--udp", default=None, metavar="HOST:PORT", help="send each sample there, for PlotJuggler"
    )
    parser.add_argument("--csv", type=Path, default=None, metavar="FILE", help="write each sample")
    parser.add_argument("--once", action="store_true", help="look once and end")
    parser.add_argument(
        "--for",
        type=float,
        default=None,
        metavar="SECONDS",
        dest="seconds",
        help="end after so long",
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Open, watch, tell."""
    from splinearm.backends import require_chain
    from splinearm.config import load_cell
    from splinearm.errors import ConfigError
    from splinearm.monitoring import Monitor

    from .files import require_new

    rate = _rate(args.rate)
    if args.seconds is not None and not args.seconds > 0.0:
        raise ConfigError("--for", "", f"want a time above zero, got {args.seconds:g}")
    require_new(rows=args.csv)
    cell = None if args.arm is None else load_cell(args.arm)
    if cell is not None:
        require_chain(cell)
    with _port(args, cell) as (port, watched), ExitStack() as stack:
        outlets = stack.enter_context(_outlets(args))
        monitor = stack.enter_context(Monitor(port, watched, baud=args.baud, told=args.arm))
        if args.once:
            return _once(monitor, outlets, is_shown=not args.json)
        try:
            _Watch(args, outlets).until_the_end(monitor, rate)
        except BrokenPipeError:  # who read the lines has had enough, as `head` has
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _rate(rate: float | None) -> float:
    from splinearm.errors import ConfigError
    from splinearm.monitoring.monitor import RATE

    if rate is None:
        return RATE
    if not _LEAST <= rate <= _MOST:
        raise ConfigError(
            "--rate", "", f"want {_LEAST:g} to {_MOST:g} samples a second, got {rate:g}"
        )
    return rate


@contextmanager
def _port(args: argparse.Namespace, cell: "Cell | None") -> "Iterator[tuple[str, Cell | None]]":
    """Give the port and the arm as it is there: virtual servos, or a calibrated arm."""
    from dataclasses import replace

    from splinearm.backends import centred, require_chain, virtual_bus_process
    from splinearm.config.calibration import calibrated
    from splinearm.errors import ConfigError

    where = port_of(args, cell, announce=_say)
    if where != VIRTUAL:
        yield where, None if cell is None else calibrated(cell)
        return
    if cell is None:
        raise ConfigError("--on", "", "virtual servos need an arm: name one before --on virtual")
    with virtual_bus_process(cell, None) as port:
        yield port, replace(cell, chain=centred(require_chain(cell)))


def _say(words: str) -> None:
    print(words, file=sys.stderr)


@contextmanager
def _outlets(args: argparse.Namespace) -> "Iterator[list[Outlet]]":
    """Open where samples go; close it, and say what could not be sent."""
    from splinearm.monitoring.outlet import CsvFile, Datagrams, JsonLines

    outlets: list[Outlet] = []
    try:
        if args.udp is not None:
            outlets.append(Datagrams(args.udp))
        if args.csv is not None:
            outlets.append(CsvFile(args.csv))
        if args.json:
            outlets.append(JsonLines(sys.stdout))
        yield outlets
    finally:
        for outlet in outlets:
            outlet.close()
            if isinstance(outlet, Datagrams) and outlet.unsent:
                _say(f"{outlet.unsent} datagrams could not be sent to {args.udp}")


def _once(monitor: "Monitor", outlets: "list[Outlet]", *, is_shown: bool) -> int:
    """Take one sample, in which nobody is silent by chance."""
    from dataclasses import replace

    from splinearm.monitoring import Level
    from splinearm.monitoring.beat import Rhythm
    from splinearm.monitoring.document import document

    sample = monitor.sample()
    for _ in range(_TRIES - 1):
        if all(servo.answers for servo in sample.servos):
            break
        sample = monitor.sample()
    sample = replace(sample, rhythm=Rhythm())  # one look has none
    for outlet in outlets:
        outlet.take(document(sample))
    if is_shown:
        from .monitor_table import picture
        from .output import console

        console.print(picture(sample, console.width))
    return 1 if sample.level is Level.STOP else 0


class _Watch:
    """What is done with samples as they come."""

    def __init__(self, args: argparse.Namespace, outlets: "list[Outlet]") -> None:
        self._outlets = outlets
        self._is_shown = not args.json
        self._until = None if args.seconds is None else time.monotonic() + args.seconds
        self._draw_due = 0.0
        self._last: Sample | None = None

    def until_the_end(self, monitor: "Monitor", rate: float) -> None:
        """Go on until somebody or the time says that it is enough."""
        from splinearm.control.stop import StopRequest
        from splinearm.monitoring.watching import Watching

        from .monitor_table import Show

        with ExitStack() as stack:
            stop = stack.enter_context(StopRequest())
            keyboard = _keyboard(stack)
            show = stack.enter_context(Show()) if self._is_shown else None
            watching = stack.enter_context(Watching(monitor, rate))
            while not self._is_over(stop, keyboard):
                self._take(watching.take())
                if show is not None:
                    self._draw(show)
            self._take(watching.take())
        if watching.dropped:
            _say(f"{watching.dropped} samples were left out: what takes them is too slow")

    def _is_over(self, stop: "StopRequest", keyboard: "Keyboard | None") -> bool:
        """Wait a little; say whether that was all."""
        key = None
        if keyboard is None:
            time.sleep(_PAUSE)
        else:
            key = keyboard.read(_PAUSE)
        late = self._until is not None and time.monotonic() >= self._until
        return late or stop.requested or key in ("q", "Q", "esc")

    def _take(self, samples: "list[Sample]") -> None:
        from splinearm.monitoring.document import document

        for sample in samples:
            self._last = sample
            said = document(sample) if self._outlets else {}
            for outlet in self._outlets:
                outlet.take(said)

    def _draw(self, show: "Show") -> None:
        """Draw the last sample, if it is time to."""
        now = time.monotonic()
        if self._last is not None and now >= self._draw_due:
            self._draw_due = now + show.period
            show(self._last)


def _keyboard(stack: ExitStack) -> "Keyboard | None":
    """Give the keys of the terminal; None: they are not for us, and a signal or --for ends it."""
    from .keyboard import Keyboard

    if sys.stdin is None or not sys.stdin.isatty():
        return None
    if os.tcgetpgrp(sys.stdin.fileno()) != os.getpgrp():
        return None  # in the background: who touches the terminal there is stopped
    return stack.enter_context(Keyboard())
