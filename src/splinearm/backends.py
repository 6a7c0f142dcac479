"""The one place that chooses which arm moves: MuJoCo, virtual servos, or servos on a port."""

import select
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import IO, TYPE_CHECKING, NamedTuple

from splinearm.arrays import FloatArray
from splinearm.config import Cell
from splinearm.control.clock import Clock, StepClock, WallClock
from splinearm.control.realtime import real_time
from splinearm.drivers.base import ArmDriver
from splinearm.drivers.chain import ServoChain, ServoSpec
from splinearm.errors import ConfigError, PortError

if TYPE_CHECKING:
    from splinearm.drivers.bus import ServoBus
    from splinearm.drivers.feedforward import ServoFeedforward
    from splinearm.drivers.gripper import Gripper

_CENTRE_TICKS = 2048
"""Where the horns of virtual servos are mounted when the arm file leaves it to calibration."""

_USB_MARGIN = 0.008
"""How long an answer may take beyond its time on the wire, through a USB adapter, s."""

_VIRTUAL_MARGIN = 0.012
"""The same from the virtual bus, whose process may have to wait for its turn, s. Together with the
wire's time well below the time after which the servos' own watchdog stops them."""

_SILENCE, _LONG_SILENCE, _LONGEST_SILENCE = 0.04, 0.1, 2.5
"""After so long without a word servos stop by themselves, s: with real-time priority, without it,
and at most."""

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
    feedforward: "ServoFeedforward | None" = None
    """By what the goals of its servos are ahead; None: by nothing."""
    gripper: "Gripper | None" = None
    """Its gripper, on the same bus; None: it has none that moves."""


@contextmanager
def open_arm(  # noqa: PLR0913 - all but two may be left out
    cell: Cell,
    where: str,
    *,
    q_start: FloatArray | None = None,
    realtime: bool = False,
    rate: float = 100.0,
    feedforward: str | None = None,
    silence: float | None = None,
) -> Iterator[Station]:
    """Open the arm of a cell somewhere; leaving holds it.

    Servos on a port are taken as the calibration in use says, if the user has one of this arm.

    Args:
        cell: The arm and its servos.
        where: "mujoco", "virtual", or the name of a serial port.
        q_start: Where a simulated arm stands, shape (n,), rad; None: its pose "home".
        realtime: Whether a MuJoCo arm keeps pace with the wall clock. The others always do.
        rate: Setpoints a second that servos will get, Hz, for their feed-forward.
        feedforward: By what their goals are ahead of the setpoints: "off", "velocity" or "full";
            None: as the arm's file says.
        silence: After how long without a word servos stop by themselves, s; None: 0.04 if this
            computer permits real-time priority, else 0.1, and at least three setpoints' time. A
            MuJoCo arm has no such watch.

    Raises:
        ConfigError: If the cell has no servos and is to move some, or its calibration is broken or
            of other servos.
        PortError: If the port cannot be used.
        BusError: If a servo does not answer or is not as the file says.
        ValueError: If servos cannot count so long a silence.
    """
    if where == "mujoco":
        with _open_mujoco(cell, q_start, realtime=realtime) as station:
            yield station
        return
    stream = _Stream(feedforward or cell.feedforward, rate, silence)
    if where == "virtual":
        virtual = replace(cell, chain=centred(require_chain(cell)))
        with (
            virtual_bus_process(cell, q_start) as port,
            _open_servos(virtual, port, stream, _VIRTUAL_MARGIN) as arm,
        ):
            yield replace(arm, where=f"virtual servos on {port}")
    else:
        own, words = _as_calibrated(cell)
        with _open_servos(own, where, stream) as station:
            yield replace(station, where=station.where + words)


def _as_calibrated(cell: Cell) -> tuple[Cell, str]:
    """Give a cell with the user's own calibration, and in words which that is."""
    from splinearm.config.calibration import DEFAULT, calibrated

    own = calibrated(cell)
    return own, "" if own is cell else f", as calibrated ({DEFAULT!r})"


class _Stream(NamedTuple):
    """How goals come to servos: by what they are ahead, how often, and how long a gap may be."""

    feedforward: str
    rate: float
    gap: float | None

    @property
    def silence(self) -> float:
        """After how long without a word the servos shall stop by themselves, s.

        If nothing else is wanted as soon as they can, if this computer can be relied on to be on
        time.
        """
        if self.gap is not None:
            return self.gap
        with real_time() as footing:
            shortest = _SILENCE if footing.fifo else _LONG_SILENCE
        return min(max(shortest, 3.0 / self.rate), _LONGEST_SILENCE)


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
    cell: Cell, port: str, stream: _Stream, margin: float = _USB_MARGIN
) -> Iterator[Station]:
    from splinearm.drivers.dialect import protocols_of
    from splinearm.drivers.dynamixel import DynamixelBus
    from splinearm.drivers.gripper import gripper_on
    from splinearm.drivers.servo_arm import ServoArm

    chain, names = require_chain(cell), cell.arm.joint_names
    bus = DynamixelBus(port, chain.baud, margin=margin, protocols=protocols_of(chain))
    try:
        feedforward = _feedforward(cell, chain, stream, bus)
        limits, silence = cell.arm.limits, stream.silence
        arm = ServoArm(chain, names, limits, bus, watchdog=silence, feedforward=feedforward)
    except BaseException:
        bus.close()
        raise
    with arm:
        yield Station(
            driver=arm,
            clock=WallClock(),
            where=f"servos on {port}",
            feedforward=feedforward,
            gripper=gripper_on(chain, bus),
        )


def _feedforward(
    cell: Cell, chain: ServoChain, stream: _Stream, bus: "ServoBus"
) -> "ServoFeedforward | None":
    """Give by what the servos' goals are ahead: with the weight, if all masses are known."""
    from splinearm.drivers.feedforward import ServoFeedforward, cycle_latency
    from splinearm.kinematics.dynamics import Dynamics

    if stream.feedforward == "off":
        return None
    torque = None
    if stream.feedforward == "full" and all(link.inertia is not None for link in cell.arm.links):
        torque = Dynamics(cell.arm).inverse
    latency = cycle_latency(1.0 / stream.rate, cell.arm.n, chain.baud)
    return ServoFeedforward.of(chain, cell.arm.joint_names, torque, bus=bus, latency=latency)


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
    """Give the chain as virtual servos have it: what is left to calibration is at their centre.

    Joint zero is there, and a gripper is open on one side of it and closed on the other.
    """
    return replace(chain, servos=tuple(map(_centred, chain.servos)))


def _centred(servo: ServoSpec) -> ServoSpec:
    if servo.zero_ticks is None:
        servo = replace(servo, zero_ticks=_CENTRE_TICKS)
    if servo.grip is not None and servo.grip.travel is None:
        centre, turn = servo.servo_model.centre, servo.servo_model.pulses
        ends = {"open_ticks": centre + turn // 6, "closed_ticks": centre - turn // 14}
        servo = replace(servo, grip=replace(servo.grip, **ends))
    return servo


@contextmanager
def virtual_bus_process(cell: Cell, q_start: FloatArray | None) -> Iterator[str]:
    """Start a virtual bus in a process of its own, as a real one has a processor of its own.

    Args:
        cell: The arm; uncalibrated servos are mounted at their centre.
        q_start: Where it stands, shape (n,), rad; None: its pose "home".

    Yields:
        The name of its port.

    Raises:
        PortError: If it does not start.
    """
    command = [sys.executable, "-m", "splinearm", "virtual-bus", str(cell.file), "--until-eof"]
    # a socket: what a pseudo terminal carries is up to 8 ms late on a busy computer
    command += ["--transport", "socket", "--realtime"]
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
