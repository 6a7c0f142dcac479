"""``splinearm guide ARM``: lead an arm by hand."""

import argparse


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
    parser.add_argument(
        "--port", default=None, metavar="P", help="the serial port (default: the arm file's)"
    )
    parser.add_argument(
        "--on",
        choices=("virtual",),
        default=None,
        help="virtual: servos on a virtual bus instead of a port",
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Open, lead, hold."""
    from splinearm.backends import open_arm, require_chain
    from splinearm.config import load_cell
    from splinearm.errors import ConfigError
    from splinearm.guiding import guide

    from .output import console

    cell = load_cell(args.arm)
    where = args.on or args.port or require_chain(cell).usual_port
    if where is None:
        raise ConfigError(
            cell.file, "bus.usual_port", "says no port; name one with --port, or use --on virtual"
        )
    with open_arm(cell, where, feedforward="full") as station:
        console.print(f"{cell.arm.name}, {station.where}: lead it by hand; Ctrl-C ends and holds")
        goal = guide(station, cell)
    angles = ", ".join(f"{angle:.1f}" for angle in cell.to_file_units(goal))
    console.print(f"the arm holds at {angles}")
    return 0
