"""``splinearm backup ARM``: the control tables of servos in a file, byte for byte."""

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from splinearm.errors import ConfigError

from .port_words import add_port, port_of

if TYPE_CHECKING:
    from splinearm.commissioning.save import Saved

_SCHEMA = "splinearm-backup-report/1"


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "backup",
        help="keep the control tables of servos in a file",
        description="Read the whole control table, EEPROM and RAM, of an arm's servos, or of "
        "whoever answers on a port, and keep it in a file. Nothing is written to a servo. "
        "`splinearm restore FILE` writes the EEPROM back.",
        epilog="exit codes: 0 all servos are in the file; 1 some are missing; 2 none could be read",
    )
    parser.add_argument(
        "arm", nargs="?", default=None, help="the arm's file or name (default: whoever is there)"
    )
    add_port(parser, virtual=False)
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        default=None,
        metavar="FILE",
        help="the file (default: a new one in the user's folder, by arm, time and port)",
    )
    parser.add_argument("--json", action="store_true", help="print the outcome for programs")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Read, and write the file."""
    from splinearm.backends import require_chain
    from splinearm.commissioning.backup import backup_file, write_backup
    from splinearm.commissioning.bench import Bench
    from splinearm.commissioning.save import save_arm, save_everyone
    from splinearm.config import load_cell
    from splinearm.config.folder import is_there

    from .setup_person import console_for, counted

    cell = None if args.arm is None else load_cell(args.arm)
    chain = None if cell is None else require_chain(cell)
    console = console_for(as_json=args.json)
    if args.output is not None and is_there(args.output):
        raise ConfigError(args.output, "", "is there already; a backup overwrites nothing")
    port = port_of(args, cell, announce=lambda words: console.print(words, markup=False))
    name = "" if cell is None else cell.name
    with console.status(f"reading the servos on {port} ..."), Bench(port) as bench:
        saved = save_everyone(bench) if chain is None else save_arm(bench, name, chain)
    file = args.output or backup_file(name, port)
    write_backup(file, saved.backup)
    if args.json:
        print(json.dumps(_document(saved, file), indent=2))
    else:
        for words in saved.lacking:
            console.print(f"not in it: {words}", markup=False, highlight=False)
        servos = counted(len(saved.backup.servos), "servo")
        console.print(f"{servos} in {file}", markup=False, highlight=False, soft_wrap=True)
    return 1 if saved.lacking else 0


def _document(saved: "Saved", file: Path) -> dict[str, object]:
    return {
        "schema": _SCHEMA,
        "arm": saved.backup.arm,
        "port": saved.backup.port,
        "file": str(file),
        "servos": [servo.name for servo in saved.backup.servos],
        "lacking": list(saved.lacking),
    }
