"""``splinearm scan PORT``: the servos that answer on a port."""

import argparse

_BAUDS = (57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000)
"""Rates at which servos are usually found."""


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "scan",
        help="list the servos that answer on a port",
        description="List the servos that answer on a serial port, in protocols 1.0 and 2.0.",
    )
    parser.add_argument("port", help="the serial port, such as /dev/ttyUSB0")
    parser.add_argument(
        "--baud",
        type=int,
        action="append",
        help=f"a baud rate to try; may be given again (default: {', '.join(map(str, _BAUDS))})",
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print a row for each servo found."""
    from splinearm.drivers.dynamixel import scan

    from .output import console, table

    bauds = tuple(args.baud) if args.baud else _BAUDS
    with console.status(f"scanning {args.port} ..."):
        found = scan(args.port, bauds)
    if not found:
        rates = ", ".join(map(str, bauds))
        console.print(
            f"no servo answers on {args.port} at {rates} baud; check power and cables, "
            "or try another rate with --baud"
        )
        return 2
    rows = [
        (
            str(servo.servo_id),
            servo.model,
            str(servo.firmware),
            str(servo.baud),
            f"{servo.protocol}.0",
        )
        for servo in found
    ]
    console.print(table(("id", "model", "firmware", "baud", "protocol"), rows))
    return 0
