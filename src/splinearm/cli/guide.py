"""``splinearm guide ARM``: lead an arm by hand."""

import argparse
import json
import sys

from .port_words import add_port, port_of

SCHEMA = "splinearm-guide/1"
"""What the document of ``--json`` says it is."""


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "guide",
        help="lead an arm by hand",
        description="Let the servos carry the arm's weight, so that a hand can lead it; the tool "
        "does no more than 250 mm/s. Where it is left it stays. Ctrl-C ends that: the arm holds. "
        "What the arm carries must be in its file, else it sinks slowly.",
    )
    parser.add_argument("arm", help="the arm's file, or the name of an arm that is shipped")
    add_port(parser)
    parser.add_argument(
        "--json", action="store_true", help="print for programs where the arm is held in the end"
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Open, lead, hold."""
    from splinearm.backends import open_arm, require_chain
    from splinearm.config import load_cell
    from splinearm.guiding import guide

    from .output import console

    def tell(words: str) -> None:
        if args.json:  # what a program reads is only where the arm is in the end
            print(words, file=sys.stderr)
        else:
            console.print(words, markup=False)

    cell = load_cell(args.arm)
    require_chain(cell)
    where = port_of(args, cell, announce=tell)
    with open_arm(cell, where, feedforward="full") as station:
        tell(f"{cell.arm.name}, {station.where}: lead it by hand; Ctrl-C ends and holds")
        angles = cell.to_file_units(guide(station, cell)).tolist()
    if args.json:
        held = dict(zip(cell.arm.joint_names, angles, strict=True))
        print(json.dumps({"schema": SCHEMA, "arm": cell.name, "holds_at": held}))
    else:
        tell(f"the arm holds at {', '.join(f'{angle:.1f}' for angle in angles)}")
    return 0
