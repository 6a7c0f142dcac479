"""The servos of an arm on a port of their own, for any program that speaks to servos.

The port is a pseudo terminal, which every program can open, or a unix socket, which is quicker and
steadier. It speaks both protocols byte for byte. A thread serves it: at every packet, and now and
then without one, the arm is brought up to the time of the wall clock.
"""

import contextlib
import os
import socket
import threading
import time
from collections.abc import Callable, Sequence
from math import inf
from pathlib import Path
from statistics import median
from types import TracebackType
from typing import Self, Unpack

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.drivers.chain import ServoChain
from splinearm.drivers.packets import Instruction
from splinearm.kinematics.arm import Arm

from .bus_option import BusOptions, Wiring
from .ear import Heard
from .habit import LineHabits
from .harness import Harness
from .line import Line, speak_protocol_1
from .line_fault import LineFault, LineFaults
from .motor import motor_of, require_turning
from .no_port import NoPort
from .plant import ArmPlant, Drive, FreePlant
from .pty_port import PtyPort
from .rig import Rig
from .server import LineServer, Port
from .shaft import TIMESTEP, Plant, Shaft
from .socket_port import SocketPort
from .virtual_servo import VirtualServo
from .voice import Reply

MAX_BACKLOG = 0.05
"""How much of the wall clock's time is made up for at once, s. A computer that cannot step the arm
as fast as time goes by would fall behind further and further, and answer nobody meanwhile: there
the arm lives more slowly."""

_IDLE = 2.0 * TIMESTEP
_ASLEEP = 0.5
_HARMLESS = frozenset(
    (
        Instruction.PING,
        Instruction.READ,
        Instruction.SYNC_READ,
        Instruction.FAST_SYNC_READ,
        Instruction.BULK_READ,
        Instruction.FAST_BULK_READ,
    )
)
"""Instructions after which nothing moves that did not move before."""


class VirtualBus:
    """Every servo of a chain, set up as the arm's file says, on a port of their own.

    Joints move in MuJoCo; servos that belong to no joint turn freely. With ``wire_time`` requests
    and replies take their time at the client's baud rate, and servos keep their Return Delay Time.
    Hold ``lock`` while touching servos from another thread. A client that polls, as the maker's SDK
    does, is better off in another process than the bus: Python threads take turns.
    """

    def __init__(
        self,
        arm: Arm,
        chain: ServoChain,
        q_start: ArrayInput | None = None,
        *,
        held: bool = True,
        clock: Callable[[], float] = time.monotonic,
        **options: Unpack[BusOptions],
    ) -> None:
        """Build the servos; the port opens with the with-block.

        Args:
            arm: The arm that they move.
            chain: The servos. A servo whose zero is left to calibration is mounted at its centre.
            q_start: Where the arm stands, shape (n,), rad; None: joint zero, or the nearest within
                the limits.
            held: Whether a hand holds the arm where it stands until a servo's torque comes on;
                else it falls at once.
            clock: Gives the time, s.
            options: The fields of ``Wiring``: ``transport``, ``wire_time``, ``usb_latency``,
                ``realtime``, ``habits``, ``seed``, ``link``, ``fresh``.

        Raises:
            ValueError: If a joint has no servo or slides, a servo has no such joint, or its model
                cannot be simulated.
            LimitError: If ``q_start`` is outside the limits.
        """
        if q_start is None:
            q_start = np.clip(np.zeros(arm.n), arm.limits.q_min, arm.limits.q_max)
        start = frozen_array(q_start, (arm.n,), "q_start")
        arm.limits.check(start)
        chain.leaders_of(arm.joint_names)
        self._wiring = Wiring(**options)
        self._baud = chain.baud
        self._plant, self._free, self._rig, self._line = _build(arm, chain, start, held=held)
        self._line.habits = self._wiring.habits
        self._clock = clock
        self._begun = clock()
        self._server = LineServer(
            self._line,
            self._obey,
            self._idle,
            wire_time=self._wiring.wire_time,
            usb_latency=self._wiring.usb_latency,
        )
        self._port: Port | None = None
        self._spare: Port | None = None
        self.lock = threading.Lock()
        """Held while servos live on or obey."""
        self.changes = 0
        """How many instructions have come that may change something in a servo."""
        self.faults = ()
        names = [servo.name for servo in chain.servos]
        by_name = dict(zip(names, self._line.servos, strict=True))
        self.harness = Harness(by_name, self.lock, self._catch_up)
        """The cables to the servos."""
        if self._wiring.fresh:
            for servo in self._line.servos:
                servo.swap()
            self.harness.disconnect()

    @property
    def port(self) -> str:
        """What a client opens: a device, or ``unix:`` and the path of a socket.

        Raises:
            RuntimeError: Outside the with-block, or while it is unplugged.
        """
        if self._port is None:
            raise RuntimeError("the virtual bus has a port only within its with-block")
        return self._port.name

    @property
    def servos(self) -> dict[int, VirtualServo]:
        """The servos by id; of two with one id the last."""
        return {servo.servo_id: servo for servo in self._line.servos}

    @property
    def all_servos(self) -> tuple[VirtualServo, ...]:
        """The servos in the order of the chain, whatever their ids are now."""
        return self._line.servos

    @property
    def silent(self) -> bool:
        """Whether the cable between the computer and all servos is cut."""
        return self._line.silent

    @silent.setter
    def silent(self, value: bool) -> None:
        self._line.silent = value

    @property
    def faults(self) -> tuple[LineFault, ...]:
        """What goes wrong on the line; set anew, at any time and from any thread, as a whole."""
        return self._line.faults.faults

    @faults.setter
    def faults(self, faults: Sequence[LineFault]) -> None:
        self._line.faults = LineFaults(faults, clock=self._now, seed=self._wiring.seed)

    @property
    def habits(self) -> LineHabits:
        """What servos do where the manual is silent; may be set anew at any time."""
        return self._line.habits

    @habits.setter
    def habits(self, habits: LineHabits) -> None:
        self._line.habits = habits

    @property
    def refused(self) -> tuple[str, ...]:
        """What the system refused of ``realtime``, in words; empty: nothing."""
        return self._server.refused

    @property
    def lateness(self) -> tuple[float, float]:
        """How late replies were of late: median and worst, s; 0 if there were none."""
        late = list(self._server.lateness)
        return (median(late), max(late)) if late else (0.0, 0.0)

    @property
    def rig(self) -> Rig:
        """Servos and what they turn, in one time; hold ``lock`` while touching it."""
        return self._rig

    @property
    def plant(self) -> ArmPlant:
        """The arm; hold ``lock`` while touching it, and wake the ``rig`` afterwards."""
        return self._plant

    @property
    def q(self) -> FloatArray:
        """Where the joints are, shape (n,), rad."""
        with self.lock:
            return self._plant.q

    def grip(self, name: str, between: tuple[float, float] | None) -> None:
        """Put something between a gripper's fingers, or take it away.

        Args:
            name: The gripper's servo.
            between: Angles of its shaft that it cannot pass, rad from where it was mounted, rising;
                None: it turns freely.

        Raises:
            ValueError: If that servo moves a joint, or there is none of that name.
        """
        if name not in self._free:
            raise ValueError(f"name: want one of {', '.join(self._free) or 'none'}, got {name!r}")
        with self.lock:
            self._catch_up()
            self._free[name].between = (-inf, inf) if between is None else between
            self._rig.wake()

    def push(self, torques: ArrayInput | None) -> None:
        """Push the joints from outside from here on, as a hand does.

        Args:
            torques: At each joint, shape (n,), N m; None: no more.
        """
        with self.lock:
            self._catch_up()
            self._plant.push(torques)
            self._rig.wake()

    def connect(self) -> socket.socket:
        """Give the client's end of a socket pair, to be served once the last client has left.

        Raises:
            RuntimeError: If the bus has no socket now.
        """
        if not isinstance(self._port, SocketPort):
            raise RuntimeError(  # noqa: TRY004 - of the bus, not of an argument
                "only a bus with transport='socket' gives sockets away, and only while it is open"
            )
        return self._port.connect()

    def unplug(self) -> None:
        """Let the port vanish, as if its cable was pulled out; servos live on.

        Raises:
            RuntimeError: If it has no port now.
        """
        if self._port is None or self._spare is not None:
            raise RuntimeError("the virtual bus has no port that could be unplugged")
        self._spare = self._new_port()  # opened before the old one closes, it has another name
        self._server.stop()
        self._unlink()
        self._port = NoPort()
        self._server.start(self._port)

    def plug_in(self) -> str:
        """Let the port come back, under another name; give the name.

        Raises:
            RuntimeError: If it is not unplugged.
        """
        if self._spare is None:
            raise RuntimeError("the virtual bus is not unplugged")
        self._server.stop()
        port, self._spare = self._spare, None
        self._open(port)
        return self.port

    def __enter__(self) -> Self:
        """Open the port and begin to serve it."""
        self._open(self._new_port())
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Stop serving and close the port."""
        self._server.stop()
        self._unlink()
        self._port = None
        if self._spare is not None:
            self._spare.close()
            self._spare = None

    def advance(self) -> None:
        """Bring the servos up to the present; they do so by themselves while they are served."""
        with self.lock:
            self._catch_up()

    def _new_port(self) -> Port:
        return SocketPort(self._baud) if self._wiring.transport == "socket" else PtyPort()

    def _open(self, port: Port) -> None:
        self._port = port
        link = self._wiring.link
        if link is not None:
            _link(link, port.name)
        self._server.start(port, realtime=self._wiring.realtime)

    def _unlink(self) -> None:
        link = self._wiring.link
        if link is not None:
            with contextlib.suppress(FileNotFoundError):
                link.unlink()

    def _catch_up(self) -> None:
        now = self._now()
        if self._clock is time.monotonic:
            self._rig.skip_to(now - MAX_BACKLOG)
        self._rig.advance_to(now)

    def _now(self) -> float:
        return self._clock() - self._begun

    def _idle(self) -> float:
        """Bring the servos up to the present; say for how long they can be left alone, s."""
        self.advance()
        return _ASLEEP if self._rig.asleep else _IDLE

    def _obey(self, heard: Heard, baud: int) -> list[Reply]:
        """Let the servos obey what was heard; give what comes back."""
        with self.lock:
            self._catch_up()
            replies = self._line.answer(heard.packet, baud, heard.protocol, damaged=heard.damaged)
            if heard.packet.instruction not in _HARMLESS:
                self.changes += 1
                self._rig.wake()
        return replies


def _link(link: Path, name: str) -> None:
    """Let a symbolic link lead to a port, in place of what it led to."""
    fresh = link.with_name(f"{link.name}.{os.getpid()}")
    with contextlib.suppress(FileNotFoundError):
        fresh.unlink()
    fresh.symlink_to(name.removeprefix("unix:"))
    fresh.replace(link)


def _build(
    arm: Arm, chain: ServoChain, q_start: FloatArray, *, held: bool
) -> tuple[ArmPlant, dict[str, FreePlant], Rig, Line]:
    """Give the plant, by name what turns freely, the rig and the line of a chain."""
    require_turning(arm)
    drives: list[Drive] = []
    free: dict[str, FreePlant] = {}
    servos: list[VirtualServo] = []
    for spec in chain.servos:
        motor, shaft = motor_of(spec.servo_model), Shaft()
        if spec.joint is None:
            free[spec.name] = FreePlant(motor, shaft)
        elif spec.joint in arm.joint_names:
            shaft.angle = float(q_start[arm.joint_names.index(spec.joint)])
            drives.append(Drive(spec.joint, motor, shaft))
        else:
            raise ValueError(f"servo {spec.name!r}: arm {arm.name!r} has no joint {spec.joint!r}")
        servo = VirtualServo.of(spec, chain.baud, shaft)
        if chain.protocol == 1.0:
            speak_protocol_1(servo)
        servos.append(servo)
    plant = ArmPlant(arm, drives, q_start)
    plants: list[Plant] = [plant, *free.values()]
    return plant, free, Rig(servos, plants, held=held), Line(servos)
