"""``splinearm recover ARM --port PORT``: bring servos back that have stopped themselves."""

import argparse
import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from .port_words import add_port, port_of

if TYPE_CHECKING:
    from splinearm.config import Cell
    from splinearm.drivers.bus import ServoBus
    from splinearm.drivers.recover import Fault

SCHEMA = "splinearm-recover/1"
"""What the document of ``--json`` says it is."""


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "recover",
        help="bring back servos that have stopped themselves",
        description="Say which servos of an arm report a hardware error and why, reboot those (and "
        "no others), restore their settings, and let the arm hold where it stands. Support the arm "
        "meanwhile: a joint without torque sinks. Exit code 2 of --look: a servo reports an error.",
    )
    parser.add_argument("arm", help="the arm's file, or the name of an arm that is shipped")
    add_port(parser, virtual=False)
    parser.add_argument(
        "--look", action="store_true", help="only say what is wrong; change nothing"
    )
    parser.add_argument("--json", action="store_true", help="print it for programs")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Look, reboot, hold."""
    from splinearm.backends import require_chain
    from splinearm.config import load_cell
    from splinearm.config.calibration import calibrated
    from splinearm.drivers.dialect import protocols_of
    from splinearm.drivers.dynamixel import DynamixelBus

    from .output import console

    cell = load_cell(args.arm)
    require_chain(cell)
    tell = None if args.json else console.print
    port = port_of(args, cell, announce=tell)
    cell = calibrated(cell)
    chain = require_chain(cell)
    bus = DynamixelBus(port, chain.baud, protocols=protocols_of(chain))
    try:
        faults = mend(bus, cell, look=args.look, quiet=args.json)
    except BaseException:
        bus.close()
        raise
    held = None
    if args.look:
        bus.close()
    else:
        held = hold(bus, cell, quiet=args.json)
    if args.json:
        print(json.dumps(_document(cell, port, faults, held), indent=2))
    return 2 if args.look and faults else 0


def mend(bus: "ServoBus", cell: "Cell", *, look: bool, quiet: bool = False) -> "tuple[Fault, ...]":
    """Say what is wrong and, unless only to look, reboot who says so; also a gripper's servo."""
    from splinearm.backends import require_chain
    from splinearm.drivers.health import health_limits
    from splinearm.drivers.recover import find_faults, recover_servos, restore

    servos = require_chain(cell).servos
    faults = find_faults(bus, servos)
    _say([str(fault) for fault in faults] or ["no servo reports a hardware error"], quiet=quiet)
    if not look and faults:
        recover_servos(bus, servos, health_limits(bus, servos))
        grippers = [fault.servo for fault in faults if fault.servo.joint is None]
        restore(bus, grippers)
        _say([f"{s.name}: rebooted; its torque stays off" for s in grippers], quiet=quiet)
    return faults


def hold(bus: "ServoBus", cell: "Cell", *, quiet: bool = False) -> list[float]:
    """Let the arm hold where it stands; its joints' servos get their settings.

    Returns:
        Where it is held, in the units of files.
    """
    from splinearm.backends import require_chain
    from splinearm.drivers.servo_arm import ServoArm

    chain, arm = require_chain(cell), cell.arm
    with ServoArm(chain, arm.joint_names, arm.limits, bus) as driver:
        angles: list[float] = cell.to_file_units(driver.goal).tolist()
    _say([f"the arm holds at {', '.join(f'{angle:.1f}' for angle in angles)}"], quiet=quiet)
    return angles


def _say(lines: Sequence[str], *, quiet: bool) -> None:
    from .output import console

    for line in () if quiet else lines:
        console.print(line, markup=False)


def _document(
    cell: "Cell", port: str, faults: "Sequence[Fault]", held: list[float] | None
) -> dict[str, Any]:
    """Give what was found and done; ``holds_at`` is None where only was looked."""
    joints = cell.arm.joint_names
    return {
        "schema": SCHEMA,
        "arm": cell.name,
        "port": port,
        "faults": [
            {
                "id": fault.servo.servo_id,
                "name": fault.servo.name,
                "joint": fault.servo.joint,
                "status": fault.status,
                "causes": list(fault.causes),
            }
            for fault in faults
        ],
        "recovered": held is not None,
        "holds_at": None if held is None else dict(zip(joints, held, strict=True)),
    }
