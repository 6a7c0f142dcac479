"""``splinearm recover ARM --port PORT``: bring servos back that have stopped themselves."""

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from splinearm.config import Cell
    from splinearm.drivers.bus import ServoBus
    from splinearm.drivers.recover import Fault


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "recover",
        help="bring back servos that have stopped themselves",
        description="Say which servos of an arm report a hardware error and why, reboot those (and "
        "no others), restore their settings, and let the arm hold where it stands. Support the arm "
        "meanwhile: a joint without torque sinks.",
    )
    parser.add_argument("arm", help="the arm's file, or the name of an arm that is shipped")
    parser.add_argument("--port", default=None, help="the serial port (default: the arm file's)")
    parser.add_argument(
        "--look", action="store_true", help="only say what is wrong; change nothing"
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Look, reboot, hold."""
    from splinearm.backends import require_chain
    from splinearm.config import load_cell
    from splinearm.drivers.dialect import protocols_of
    from splinearm.drivers.dynamixel import DynamixelBus
    from splinearm.errors import ConfigError

    cell = load_cell(args.arm)
    chain = require_chain(cell)
    port = args.port or chain.usual_port
    if port is None:
        raise ConfigError(cell.file, "bus.usual_port", "says no port; name one with --port")
    bus = DynamixelBus(port, chain.baud, protocols=protocols_of(chain))
    try:
        faults = mend(bus, cell, look=args.look)
    except BaseException:
        bus.close()
        raise
    if args.look:
        bus.close()
        return 2 if faults else 0
    return hold(bus, cell)


def mend(bus: "ServoBus", cell: "Cell", *, look: bool) -> "tuple[Fault, ...]":
    """Say what is wrong and, unless only to look, reboot who says so; also a gripper's servo."""
    from splinearm.backends import require_chain
    from splinearm.drivers.health import health_limits
    from splinearm.drivers.recover import find_faults, recover_servos, restore

    from .output import console

    servos = require_chain(cell).servos
    faults = find_faults(bus, servos)
    for fault in faults:
        console.print(str(fault), markup=False)
    if not faults:
        console.print("no servo reports a hardware error")
    if not look and faults:
        recover_servos(bus, servos, health_limits(bus, servos))
        grippers = [fault.servo for fault in faults if fault.servo.joint is None]
        restore(bus, grippers)
        for servo in grippers:
            console.print(f"{servo.name}: rebooted; its torque stays off", markup=False)
    return faults


def hold(bus: "ServoBus", cell: "Cell") -> int:
    """Let the arm hold where it stands; its joints' servos get their settings."""
    from splinearm.backends import require_chain
    from splinearm.drivers.servo_arm import ServoArm

    from .output import console

    chain, arm = require_chain(cell), cell.arm
    with ServoArm(chain, arm.joint_names, arm.limits, bus) as driver:
        angles = ", ".join(f"{angle:.1f}" for angle in cell.to_file_units(driver.goal))
        console.print(f"the arm holds at {angles}")
    return 0
