"""``splinearm scan PORT``: the servos that answer on a port."""

import argparse
import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

    from splinearm.commissioning.bench import Bench
    from splinearm.commissioning.search import Presence

_SCHEMA = "splinearm-scan/1"

_CODES = """A scan ends when the line is quiet: after 40 ids in a row without a servo. Only if
nobody answers at any rate every id is waited for, which takes a while: a servo's turn to answer
comes by its id, one after the other.

exit codes: 0 servos were found; 1 some share an id; 2 no servo answers, or there is no such port"""


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "scan",
        help="list the servos that answer on a port",
        description="List the servos that answer on a serial port, in protocols 1.0 and 2.0.",
        epilog=_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("port", help="the serial port, such as /dev/ttyUSB0")
    parser.add_argument(
        "--baud",
        type=int,
        action="append",
        help="a baud rate to try; may be given again (default: the usual ones, 57600 to 4000000)",
    )
    parser.add_argument("--json", action="store_true", help="print it for programs")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print a row for each servo found."""
    from splinearm.commissioning.bench import QUICK_MARGIN, Bench

    from .setup_person import console_for

    bauds = _rates(args.baud)
    console = console_for(as_json=args.json)
    with (
        console.status(f"scanning {args.port} ...") as status,
        Bench(args.port, margin=QUICK_MARGIN) as bench,
    ):
        for baud in args.baud or ():
            bench.at(baud)  # the search passes over rates that a port does not have
        presence = _search(bench, bauds, status.update)
    if args.json:
        print(json.dumps(_document(args.port, presence), indent=2))
    else:
        _show(args.port, presence, bauds)
    if presence.garbled:
        return 1
    return 0 if presence.found else 2


def _rates(wanted: list[int] | None) -> tuple[int, ...]:
    """Give the rates to try.

    Raises:
        ConfigError: If no servo has one of them, with those that servos have.
    """
    from splinearm.commissioning.search import rare_rates, usual_rates
    from splinearm.errors import ConfigError

    usual = usual_rates(None)
    if wanted is None:
        return usual
    known = sorted({*usual, *rare_rates(None)})
    for baud in wanted:
        if baud not in known:
            names = ", ".join(map(str, known))
            raise ConfigError("--baud", "", f"no servo has {baud}; choose one of {names}")
    return tuple(wanted)


def _search(bench: "Bench", bauds: tuple[int, ...], tell: "Callable[[str], None]") -> "Presence":
    """Find who is there; at last those with ids far from any other."""
    from splinearm.commissioning.search import call_everyone, without_twins
    from splinearm.drivers.chain import MAX_SERVO_ID

    presence = without_twins(bench, call_everyone(bench, None, bauds))
    if presence.found or presence.garbled:
        return presence
    tell(f"nobody with a low id on {bench.port}; asking every id at every rate ...")
    return call_everyone(bench, None, bauds, quiet_slots=MAX_SERVO_ID)


def _show(port: str, presence: "Presence", bauds: tuple[int, ...]) -> None:
    from .output import console, table

    rows = [
        (
            str(one.address.servo_id),
            one.model_words,
            str(one.firmware),
            str(one.address.baud),
            f"{one.address.protocol}.0",
        )
        for one in presence.found
    ]
    if rows:
        console.print(table(("id", "model", "firmware", "baud", "protocol"), rows))
    for address in presence.garbled:
        console.print(
            f"{address}: something answers, but garbled: several servos have this id, as all have "
            f"fresh out of the box; `splinearm setup ARM --port {port}` gives each its own, one by "
            "one",
            markup=False,
            highlight=False,
        )
    if not (rows or presence.garbled):
        rates = ", ".join(map(str, bauds))
        console.print(
            f"no servo answers on {port} at {rates} baud; check power and cables, "
            "or try another rate with --baud"
        )


def _document(port: str, presence: "Presence") -> dict[str, Any]:
    return {
        "schema": _SCHEMA,
        "port": port,
        "servos": [
            {
                "id": one.address.servo_id,
                "model": one.model_words,
                "model_number": one.model_number,
                "firmware": one.firmware,
                "baud": one.address.baud,
                "protocol": one.address.protocol,
            }
            for one in presence.found
        ],
        "shared": [
            {"id": address.servo_id, "baud": address.baud, "protocol": address.protocol}
            for address in presence.garbled
        ],
    }
