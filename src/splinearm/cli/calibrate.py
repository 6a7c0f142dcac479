"""``splinearm calibrate ARM``: where the joints of your own arm are zero, by hand."""

import argparse
import json
import sys
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from .port_words import VIRTUAL, add_port, port_of

if TYPE_CHECKING:
    from splinearm.config import Cell
    from splinearm.config.calibration_table import Calibration

_STEPS = """It asks you to support the arm before its torque goes off. Then you turn each joint from
end to end, turn each joint as it says, and put the arm in a pose. It shows every register that is
to be written and asks. Before the first write the control tables of the servos are kept in a file;
`splinearm restore FILE` brings them back. Stopped in the middle it has written nothing, or whole
joints: started again it takes those that are missing.

Calibrations lie in the folder `calibrations` of your configuration ($SPLINEARM_HOME). The one that
is called "default" is in use on real ports. Former ones stay there under their date."""


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "calibrate",
        help="find where the joints of your arm are zero, by hand",
        description="Find by hand how the servos of your arm are mounted: where each joint is "
        "zero, which way it counts and how far it goes. The servos are set so that no angle is "
        "ambiguous.",
        epilog=_STEPS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("arm", help="the arm's file, or the name of an arm that is shipped")
    add_port(parser)
    parser.add_argument(
        "--joint",
        action="append",
        default=None,
        metavar="NAME",
        help="only that joint, or the gripper's servo; may be given often (default: all)",
    )
    parser.add_argument(
        "--all",
        action="store_true",
        help="all joints anew, also where only some are missing in the calibration",
    )
    parser.add_argument(
        "--zero",
        choices=("pose", "ends"),
        default="pose",
        help="how zero is found: by a pose of the arm (default), or by the ends of the travel, "
        "where the limits in the arm's file are its stops",
    )
    parser.add_argument(
        "--pose", default=None, metavar="POSE", help='which pose (default: "zero", else "home")'
    )
    parser.add_argument("--name", default=None, help='what to call it (default: "default")')
    parser.add_argument("--list", action="store_true", help="list the calibrations of the arm")
    parser.add_argument("--use", default=None, metavar="NAME", help="take that one in use")
    parser.add_argument(
        "--rename", nargs=2, default=None, metavar=("NAME", "NEW"), help="give one another name"
    )
    parser.add_argument("--json", action="store_true", help="print what came out for programs")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Do what was asked with the calibrations that are there, or make one."""
    from splinearm.backends import require_chain
    from splinearm.config import load_cell

    cell = load_cell(args.arm)
    require_chain(cell)
    if args.list or args.use is not None or args.rename is not None:
        _look_after(cell, args)
        return 0
    return _calibrate(cell, args)


def _look_after(cell: "Cell", args: argparse.Namespace) -> None:
    """Rename, take in use, list."""
    from splinearm.config.calibration import DEFAULT, rename_calibration, use_calibration

    from .output import console

    if args.rename is not None:
        file = rename_calibration(cell.name, *args.rename)
        if not args.json:
            console.print(f"{file}", markup=False, soft_wrap=True, highlight=False)
            if args.rename[0] == DEFAULT:
                again = f"`splinearm calibrate {args.arm} --use {args.rename[1]}`"
                console.print(f"none is in use now; {again} takes it in use again", markup=False)
    if args.use is not None:
        file = use_calibration(cell.name, args.use)
        if not args.json:
            console.print(f"in use: {file}", markup=False, soft_wrap=True, highlight=False)
    if args.list:
        _list(cell, as_json=args.json)


def _list(cell: "Cell", *, as_json: bool) -> None:
    """Show the calibrations of an arm; a broken one with what is wrong."""
    from splinearm.config.calibration import calibration_file, calibration_names, find_calibration
    from splinearm.errors import ConfigError

    from .output import console, table

    rows: list[dict[str, Any]] = []
    for name in calibration_names(cell.name):
        row: dict[str, Any] = {"name": name, "file": str(calibration_file(cell.name, name))}
        try:
            calibration = find_calibration(cell.name, name)
        except ConfigError as error:
            row["broken"] = str(error)
        else:
            assert calibration is not None  # noqa: S101 - it was listed
            row |= _document(calibration)
        rows.append(row)
    if as_json:
        print(json.dumps(rows, indent=2))
    elif not rows:
        console.print(f"{cell.name} has no calibration yet: `splinearm calibrate {cell.name}`")
    else:
        cells = [
            (
                row["name"],
                row.get("date", ""),
                row.get("broken") or ", ".join(servo["name"] for servo in row["servos"]),
                row.get("usb_serial") or "",
            )
            for row in rows
        ]
        console.print(table(("name", "made", "servos", "adapter"), cells))


def _document(calibration: "Calibration") -> dict[str, Any]:
    """Give a calibration as a program reads it."""
    from splinearm.units import DEG

    servos = [
        {
            "name": servo.name,
            "id": servo.servo_id,
            "model": servo.model,
            "zero_ticks": servo.zero_ticks,
            "zero_by": servo.zero_by,
            "open_ticks": servo.open_ticks,
            "closed_ticks": servo.closed_ticks,
            "travel_deg": None if servo.travel is None else [q / DEG for q in servo.travel],
            "registers": dict(servo.settings),
        }
        for servo in calibration.servos
    ]
    return {
        "arm": calibration.arm,
        "name": calibration.name,
        "date": calibration.date.isoformat(),
        "usb_serial": calibration.usb_serial,
        "servos": servos,
    }


def _calibrate(cell: "Cell", args: argparse.Namespace) -> int:
    """Make a calibration with a person at the arm."""
    from splinearm.backends import require_chain
    from splinearm.commissioning.bench import MARGIN
    from splinearm.commissioning.calibration_bench import CalibrationBench
    from splinearm.config.calibration import DEFAULT, calibration_file
    from splinearm.drivers.dialect import protocols_of
    from splinearm.drivers.dynamixel import DynamixelBus

    from .calibrate_steps import Steps
    from .keyboard import Keyboard
    from .words import start_of

    name = DEFAULT if args.name is None else args.name
    calibration_file(cell.name, name)
    pose = args.pose or ("zero" if "zero" in cell.poses else "home")
    start_of(cell, pose, None)
    where, chain = port_of(args, cell), require_chain(cell)
    with ExitStack() as stack:
        keys = stack.enter_context(Keyboard())
        hand, port = None, where
        if where == VIRTUAL:
            from splinearm.commissioning.calibration_hand import virtual_arm

            port, hand = stack.enter_context(virtual_arm(cell))
        protocols = protocols_of(chain)
        bus = DynamixelBus(port, chain.baud, margin=MARGIN, protocols=protocols)
        stack.enter_context(bus)
        bench = CalibrationBench(bus, cell, _joints(cell, args))
        bench.survey()
        steps = Steps(cell, bench, keys, hand, arm=args.arm, to_errors=args.json)
        made = steps.take(name, pose, by_ends=args.zero == "ends", serial=_serial(port))
    if args.json:
        print(json.dumps(_document(made), indent=2))
    return 0


def _joints(cell: "Cell", args: argparse.Namespace) -> list[str] | None:
    """Give what is to be calibrated: of a calibration that is not whole yet, what it lacks."""
    from splinearm.backends import require_chain
    from splinearm.config.calibration import find_calibration, fitting
    from splinearm.drivers.chain import ServoRole
    from splinearm.errors import ConfigError

    if args.joint is not None or args.all or args.on == VIRTUAL:
        return None if args.joint is None else list(args.joint)
    try:
        former = find_calibration(cell.name, args.name)
    except ConfigError:  # none of that name, or a broken one: all is calibrated
        return None
    servos = [s for s in require_chain(cell).servos if s.role is not ServoRole.SHADOW]
    former = None if former is None else fitting(cell, former)
    lacking = [s.joint or s.name for s in servos if former is None or not former.servo(s.name)]
    if not lacking or len(lacking) == len(servos):
        return None
    words = f"calibrated already, and kept: all but {', '.join(lacking)} (--all: all anew)"
    print(words, file=sys.stderr)
    return lacking


def _serial(port: str) -> str | None:
    """Give the serial number of a port's USB adapter, if it has one."""
    from splinearm.commissioning.ports import usb_ports

    for usb in usb_ports():
        if port in (usb.device, usb.by_id):
            return usb.serial or None
    return None
