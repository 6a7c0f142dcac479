"""``splinearm setup ARM``: from servos fresh out of the box to an arm that is ready."""

import argparse
import json
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from splinearm.errors import ConfigError

from .port_words import add_port, port_of

if TYPE_CHECKING:
    from splinearm.commissioning.session import SessionReport
    from splinearm.commissioning.task import Task
    from splinearm.config import Cell

_SCHEMA = "splinearm-setup/1"

_MORE = """Every step looks first and skips what is done: stop it at any time and start it again.
Nothing moves and no servo gets torque. Before the first write the control tables of the servos are
kept in a file; `splinearm restore FILE` brings them back.

exit codes:
    0    the arm is set up
    1    something is left to do (--check lists it), or it was not agreed to
    2    it cannot be done: no port, a servo of another model, no answer
    130  Ctrl-C"""


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "setup",
        help="set servos up: ids, baud rate, limits and all else that the arm's file says",
        description="Find the servos of an arm at any rate and in both protocols, give each its id "
        "(one by one where it cannot be told which is which), and write what the arm's file says, "
        "after showing old and new values and asking.",
        epilog=_MORE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("arm", help="the arm's file, or the name of an arm that is shipped")
    add_port(parser, virtual=False)
    parser.add_argument("--check", action="store_true", help="say what is left; write nothing")
    parser.add_argument("--yes", action="store_true", help="write without asking")
    parser.add_argument(
        "--release",
        action="store_true",
        help="let servos lose their torque without asking: the arm is supported",
    )
    parser.add_argument(
        "--one-by-one",
        action="store_true",
        help="ask for each servo by itself, whatever ids they have now",
    )
    parser.add_argument(
        "--wait-s",
        type=float,
        default=300.0,
        metavar="S",
        help="how long to wait for a servo to be connected (default: 300)",
    )
    parser.add_argument("--json", action="store_true", help="print the outcome for programs")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Look, ask, write, read again."""
    from splinearm.backends import require_chain
    from splinearm.commissioning.bench import Bench
    from splinearm.commissioning.setup import Setup
    from splinearm.config import load_cell
    from splinearm.errors import DeclinedError

    from .setup_person import TerminalPerson, console_for

    if not 0.0 <= args.wait_s < math.inf:
        raise ConfigError("--wait-s", "", f"wants seconds, got {args.wait_s}")
    console = console_for(as_json=args.json)

    def tell(words: str) -> None:
        console.print(words, markup=False, highlight=False)

    cell = _own(load_cell(args.arm), args.arm, tell)
    require_chain(cell)
    port = port_of(args, cell, announce=tell)
    person = TerminalPerson(console, yes=args.yes or args.check, release=args.release)
    tell(f"looking for the servos on {port} ...")
    with Bench(port) as bench:
        setup = Setup(bench, cell, person, one_by_one=args.one_by_one, patience=args.wait_s)
        try:
            report = setup.check() if args.check else setup.run()
        except DeclinedError as declined:
            report = setup.report
            report.left.append(str(declined))
    if args.json:
        print(json.dumps(document(report, cell, port), indent=2))
    else:
        _show(args, report, cell)
    return 1 if report.left else 0


def _own(cell: "Cell", arm: str, tell: Callable[[str], None]) -> "Cell":
    """Give the arm with its calibration, without what of that no longer fits the arm's file.

    Servos must be set up before they can be calibrated anew.
    """
    from splinearm.config.calibration import calibration_file, find_calibration, fitting
    from splinearm.config.calibration_table import apply_calibration

    calibration = None if cell.chain is None else find_calibration(cell.name)
    if calibration is None:
        return cell
    own = fitting(cell, calibration)
    kept = {servo.name for servo in own.servos}
    gone = [servo.name for servo in calibration.servos if servo.name not in kept]
    if gone:
        tell(
            f"the calibration does not fit the arm's file any more: {', '.join(gone)} (calibrate "
            f"anew once the servos are set up: `splinearm calibrate {arm}`)"
        )
    return apply_calibration(cell, own, calibration_file(cell.name, calibration.name))


def document(report: "SessionReport", cell: "Cell", port: str) -> dict[str, Any]:
    """Give the outcome for JSON."""
    return {
        "schema": _SCHEMA,
        "arm": cell.name,
        "port": port,
        "ready": not report.left,
        "left": report.left,
        "notes": report.notes,
        "written": report.written,
        "backup": None if report.backup is None else str(report.backup),
        "servos": [servo_document(task) for task in report.tasks],
    }


def servo_document(task: "Task") -> dict[str, Any]:
    """Give what is, or was, to be done to a servo."""
    found = task.image.found
    return {
        "name": task.name,
        "model": task.image.model.name,
        "firmware": found.firmware,
        "id": found.address.servo_id,
        "baud": found.address.baud,
        "protocol": found.address.protocol,
        "errors": list(task.errors),
        "changes": [
            {
                "register": change.register.name,
                "address": change.register.address,
                "old": change.old,
                "new": change.new,
            }
            for change in task.changes
        ],
    }


def _show(args: argparse.Namespace, report: "SessionReport", cell: "Cell") -> None:
    """Say how it ended."""
    from .output import console
    from .setup_person import counted, show_task

    for task in report.tasks if args.check else ():
        if not task.is_done:
            show_task(console, task)
    for note in report.notes if args.check else ():
        console.print(note, markup=False, highlight=False)
    if report.left:
        console.print("left to do:")
        for words in report.left:
            console.print(f"  {words}", markup=False, highlight=False)
        if args.check:
            again = f"`splinearm setup {args.arm}{_port_words(args)}` does it"
            console.print(again, markup=False, highlight=False)
    else:
        count = report.written
        done = f"{counted(count, 'register')} written" if count else "there is nothing to write"
        next_one = _next(args, cell)
        console.print(
            f"all servos are set up; {done}. Next: `{next_one}`", markup=False, highlight=False
        )


def _next(args: argparse.Namespace, cell: "Cell") -> str:
    """Give the command that comes after this one."""
    from splinearm.backends import require_chain

    chain = require_chain(cell)
    if any(servo.joint is not None and servo.zero_ticks is None for servo in chain.servos):
        return f"splinearm calibrate {args.arm}{_port_words(args)}"
    port = "" if args.port is None else f"{args.port} "
    return f"splinearm doctor {port}--arm {args.arm}"


def _port_words(args: argparse.Namespace) -> str:
    return "" if args.port is None else f" --port {args.port}"
