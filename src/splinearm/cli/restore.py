"""``splinearm restore FILE``: the EEPROM of servos as it was when it was backed up."""

import argparse
import json
from typing import TYPE_CHECKING

from .port_words import add_port, port_of

if TYPE_CHECKING:
    from splinearm.commissioning.session import SessionReport

_SCHEMA = "splinearm-restore/1"


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "restore",
        help="write servos back as they were when they were backed up",
        description="Write the EEPROM of servos back from a backup of `splinearm backup` or "
        "`splinearm setup`, byte for byte, after showing old and new values and asking. Ids and "
        "rates come last. Model and firmware can only be read, and RAM begins anew with the power.",
        epilog="exit codes: 0 the servos are as in the file; 1 it was not agreed to; 2 it cannot "
        "be done; 130 Ctrl-C",
    )
    parser.add_argument("file", help="the backup")
    add_port(parser, virtual=False)
    parser.add_argument(
        "--servo",
        action="append",
        default=[],
        metavar="NAME",
        help="only this servo; may be given again",
    )
    parser.add_argument("--yes", action="store_true", help="write without asking")
    parser.add_argument(
        "--release",
        action="store_true",
        help="let servos lose their torque without asking: the arm is supported",
    )
    parser.add_argument("--json", action="store_true", help="print the outcome for programs")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Compare, ask, write, read again."""
    from splinearm.commissioning.backup import read_backup
    from splinearm.commissioning.bench import Bench
    from splinearm.commissioning.restore import restore
    from splinearm.errors import DeclinedError

    from .setup_person import TerminalPerson, console_for, counted

    backup = read_backup(args.file)
    console = console_for(as_json=args.json)
    port = port_of(args, None, announce=lambda words: console.print(words, markup=False))
    said = f"{counted(len(backup.servos), 'servo')} of {backup.arm or 'no named arm'}"
    console.print(f"{args.file}: {said}, {backup.time}, {backup.port}", markup=False)
    person = TerminalPerson(console, yes=args.yes, release=args.release)
    try:
        with Bench(port) as bench:
            report = restore(bench, backup, person, only=args.servo)
    except DeclinedError as declined:
        console.print(f"{declined}", markup=False)
        return 1
    if args.json:
        print(json.dumps(_document(report, args.file, port), indent=2))
    else:
        for note in report.notes:
            console.print(note, markup=False, highlight=False)
        if report.backup is None:
            console.print("the servos are as in the file; there is nothing to write")
    return 0


def _document(report: "SessionReport", file: str, port: str) -> dict[str, object]:
    from .setup import servo_document

    return {
        "schema": _SCHEMA,
        "file": file,
        "port": port,
        "written": report.written,
        "backup": None if report.backup is None else str(report.backup),
        "notes": report.notes,
        "servos": [servo_document(task) for task in report.tasks],
    }
