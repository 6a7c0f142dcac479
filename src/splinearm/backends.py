"""The one place that chooses which arm moves: MuJoCo, virtual servos, or servos on a port."""

import select
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import IO

from splinearm.arrays import FloatArray
from splinearm.config import Cell
from splinearm.control.clock import Clock, StepClock, WallClock
from splinearm.control.stop import StopRequest
from splinearm.drivers.base import ArmDriver
from splinearm.drivers.chain import ServoChain
from splinearm.errors import ConfigError, PortError

_CENTRE_TICKS = 2048
"""Where the horns of virtual servos are mounted when the arm file leaves it to calibration."""

_USB_MARGIN = 0.008
"""How long an answer may take beyond its time on the wire, through a USB adapter, s."""

_PTY_MARGIN = 0.05
"""The same on the pseudo terminal of the virtual bus, on a busy computer, s."""

_BUS_START_TIMEOUT = 20.0
"""How long the virtual bus may take to start, s."""

_BUS_END_TIMEOUT = 5.0
"""How long it may take to end, s."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Station:
    """An arm that is ready to move, and its time."""

    driver: ArmDriver
    """The arm, entered and holding."""
    clock: Clock
    """The arm's time."""
    where: str
    """What moves, in words."""


@contextmanager
def open_arm(
    cell: Cell, where: str, *, q_start: FloatArray | None = None, realtime: bool = False
) -> Iterator[Station]:
    """Open the arm of a cell somewhere; leaving holds it.

    Args:
        cell: The arm and its servos.
        where: "mujoco", "virtual", or the name of a serial port.
        q_start: Where a simulated arm stands, shape (n,), rad; None: its pose "home".
        realtime: Whether a MuJoCo arm keeps pace with the wall clock. The others always do.

    Raises:
        ConfigError: If the cell has no servos and is to move some.
        PortError: If the port cannot be used.
        BusError: If a servo does not answer or is not as the file says.
    """
    if where == "mujoco":
        with _open_mujoco(cell, q_start, realtime=realtime) as station:
            yield station
    elif where == "virtual":
        chain = centred(require_chain(cell))
        with (
            _virtual_bus_process(cell, q_start) as port,
            _open_servos(cell, chain, port, _PTY_MARGIN) as arm,
        ):
            yield replace(arm, where=f"virtual servos on {port}")
    else:
        with _open_servos(cell, require_chain(cell), where) as station:
            yield station


@contextmanager
def _open_mujoco(cell: Cell, q_start: FloatArray | None, *, realtime: bool) -> Iterator[Station]:
    from splinearm.sim.motor import motors_for
    from splinearm.sim.mujoco_arm import MujocoArm

    start = cell.poses["home"] if q_start is None else q_start
    with MujocoArm(cell.arm, motors_for(cell.arm, cell.chain), start) as arm:
        clock = StepClock(arm.advance, lambda: arm.now, realtime=realtime)
        yield Station(driver=arm, clock=clock, where="MuJoCo")


@contextmanager
def _open_servos(
    cell: Cell, chain: ServoChain, port: str, margin: float = _USB_MARGIN
) -> Iterator[Station]:
    from splinearm.drivers.dynamixel import DynamixelBus
    from splinearm.drivers.servo_arm import ServoArm

    bus = DynamixelBus(port, chain.baud, margin=margin)
    with ServoArm(chain, cell.arm.joint_names, cell.arm.limits, bus) as arm:
        yield Station(driver=arm, clock=WallClock(), where=f"servos on {port}")


def require_chain(cell: Cell) -> ServoChain:
    """Give the servos of a cell.

    Raises:
        ConfigError: If it has none.
    """
    if cell.chain is None:
        raise ConfigError(
            cell.file, "servo", "the arm has no servos; add [[servo]] tables or use --on mujoco"
        )
    return cell.chain


def centred(chain: ServoChain) -> ServoChain:
    """Give the chain with joint zero at the centre of servos that are not calibrated."""
    servos = tuple(
        replace(servo, zero_ticks=_CENTRE_TICKS) if servo.zero_ticks is None else servo
        for servo in chain.servos
    )
    return replace(chain, servos=servos)


def serve_virtual_bus(
    cell: Cell, q_start: FloatArray, stop: StopRequest, on_ready: Callable[[str], object]
) -> None:
    """Serve the virtual servos of a cell until a stop is asked for.

    Args:
        cell: The arm and its servos.
        q_start: Where the arm stands, shape (n,), rad.
        stop: Ends the serving.
        on_ready: Gets the port's name once it can be opened.

    Raises:
        ConfigError: If the cell has no servos.
    """
    from splinearm.sim.virtual_bus import VirtualBus

    with VirtualBus(cell.arm, centred(require_chain(cell)), q_start) as bus:
        on_ready(bus.port)
        while not stop.requested:
            time.sleep(0.05)


@contextmanager
def _virtual_bus_process(cell: Cell, q_start: FloatArray | None) -> Iterator[str]:
    """Start a virtual bus in a process of its own, as a real one has a processor of its own."""
    command = [sys.executable, "-m", "splinearm", "virtual-bus", str(cell.file), "--until-eof"]
    if q_start is not None:
        degrees = ",".join(repr(float(angle)) for angle in cell.to_file_units(q_start))
        command.append(f"--start-deg={degrees}")
    # what it complains of goes to a file: a pipe that nobody empties would stop it in the end
    with tempfile.TemporaryFile("w+") as complaints:
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=complaints,
            text=True,
            start_new_session=True,  # Ctrl-C is for us: the bus outlives the stop along the path
        )
        try:
            yield _await_port(process, complaints)
        finally:
            _end(process)


def _await_port(process: "subprocess.Popen[str]", complaints: IO[str]) -> str:
    """Give the port that the bus prints once it can be opened."""
    assert process.stdout is not None  # noqa: S101 - a pipe was asked for
    ready, _, _ = select.select([process.stdout], (), (), _BUS_START_TIMEOUT)
    line = process.stdout.readline() if ready else ""
    if line.startswith("port: "):
        return line.removeprefix("port: ").strip()
    _end(process)
    complaints.seek(0)
    last = (complaints.read().strip().splitlines() or ["it said nothing"])[-1]
    raise PortError(
        "virtual",
        f"the virtual bus did not start: {last}",
        "try `splinearm virtual-bus` with the arm by itself",
    )


def _end(process: "subprocess.Popen[str]") -> None:
    """End the bus, by force if it does not listen."""
    process.terminate()
    try:
        process.communicate(timeout=_BUS_END_TIMEOUT)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
