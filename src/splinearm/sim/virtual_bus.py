"""The servos of an arm on a port of their own, for any program that speaks to servos.

The port is a pseudo terminal that speaks Protocol 2.0 byte for byte. A thread serves it: at every
packet, and now and then without one, the arm is brought up to the time of the wall clock.
"""

import ctypes
import sys
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Self

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.drivers.chain import ServoChain
from splinearm.drivers.packets import Decoder, Instruction, Packet, stuff
from splinearm.kinematics.arm import Arm

from .line import Line
from .motor import motor_of, require_turning
from .plant import ArmPlant, Drive, FreePlant
from .pty_port import PtyPort
from .rig import Rig
from .shaft import Plant, Shaft
from .virtual_servo import VirtualServo

BITS_PER_BYTE = 10
"""Start bit, eight bits, stop bit."""

PACKET_GAP = 1.5e-3
"""A pause of that length within a packet ends it, s."""

MAX_BACKLOG = 0.05
"""How much of the wall clock's time is made up for at once, s. A computer that cannot step the arm
as fast as time goes by would fall behind further and further, and answer nobody meanwhile: there
the arm lives more slowly."""

_PR_SET_TIMERSLACK = 29
_TIMER_SLACK_NS = 1000
_FRAME_BYTES = 9  # header, id, length, CRC
_IDLE = 0.01
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
    """Every servo of a chain, set up as the arm's file says, on a pseudo terminal.

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
        wire_time: bool = True,
        held: bool = True,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Build the servos; the port opens with the with-block.

        Args:
            arm: The arm that they move.
            chain: The servos. A servo whose zero is left to calibration is mounted at its centre.
            q_start: Where the arm stands, shape (n,), rad; None: joint zero, or the nearest within
                the limits.
            wire_time: Whether bytes take time.
            held: Whether a hand holds the arm where it stands until a servo's torque comes on;
                else it falls at once.
            clock: Gives the time, s.

        Raises:
            ValueError: If a joint has no servo or slides, a servo has no such joint, or its model
                or protocol cannot be simulated.
            LimitError: If ``q_start`` is outside the limits.
        """
        if q_start is None:
            q_start = np.clip(np.zeros(arm.n), arm.limits.q_min, arm.limits.q_max)
        start = frozen_array(q_start, (arm.n,), "q_start")
        arm.limits.check(start)
        chain.leaders_of(arm.joint_names)
        self._plant, self._rig, self._line = _build(arm, chain, start, held=held)
        self._wire_time = wire_time
        self._clock = clock
        self._begun = clock()
        self._decoder = Decoder()
        self._wire_free = 0.0
        self._port: PtyPort | None = None
        self._thread: threading.Thread | None = None
        self._closing = False
        self.lock = threading.Lock()
        """Held while servos live on or obey."""

    @property
    def port(self) -> str:
        """What a client opens.

        Raises:
            RuntimeError: Outside the with-block.
        """
        if self._port is None:
            raise RuntimeError("the virtual bus has a port only within its with-block")
        return self._port.name

    @property
    def servos(self) -> dict[int, VirtualServo]:
        """The servos by id."""
        return {servo.servo_id: servo for servo in self._line.servos}

    @property
    def silent(self) -> bool:
        """Whether the cable between the computer and all servos is cut."""
        return self._line.silent

    @silent.setter
    def silent(self, value: bool) -> None:
        self._line.silent = value

    @property
    def q(self) -> FloatArray:
        """Where the joints are, shape (n,), rad."""
        with self.lock:
            return self._plant.q

    def __enter__(self) -> Self:
        """Open the port and begin to serve it."""
        self._port = PtyPort()
        self._closing = False
        self._thread = threading.Thread(target=self._serve, name="virtual bus", daemon=True)
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Stop serving and close the port."""
        port, thread = self._port, self._thread
        if port is None or thread is None:
            return
        self._closing = True
        port.wake()
        thread.join()
        self._port = self._thread = None
        port.close()

    def advance(self) -> None:
        """Bring the servos up to the present; they do so by themselves while they are served."""
        with self.lock:
            self._catch_up()

    def _catch_up(self) -> None:
        now = self._now()
        if self._clock is time.monotonic:
            self._rig.skip_to(now - MAX_BACKLOG)
        self._rig.advance_to(now)

    def _now(self) -> float:
        return self._clock() - self._begun

    def _serve(self) -> None:
        """Serve until the with-block ends."""
        port = self._port
        assert port is not None  # noqa: S101 - the thread is started after the port
        _sleep_sharply()
        while not self._closing:
            data = port.read(self._patience())
            arrived = self._now()
            if not data:
                self._decoder.reset()
                self.advance()
                continue
            for packet in self._decoder.feed(data):
                self._obey(packet, port, arrived)

    def _patience(self) -> float:
        """Give for how long to wait for bytes."""
        if self._decoder.pending:
            return PACKET_GAP
        return _ASLEEP if self._rig.asleep else _IDLE

    def _obey(self, packet: Packet, port: PtyPort, arrived: float) -> None:
        """Let the servos obey a packet and send what comes back."""
        baud = port.baud
        byte_time = BITS_PER_BYTE / baud if self._wire_time and baud else 0.0
        length = _FRAME_BYTES + len(stuff(bytes((packet.instruction,)) + packet.params))
        # the request has been on the wire since it arrived, or since the wire was free
        due = max(arrived, self._wire_free) + length * byte_time
        with self.lock:
            self._catch_up()
            replies = self._line.answer(packet, baud)
            if packet.instruction not in _HARMLESS:
                self._rig.wake()
        for data, delay in replies:
            if self._wire_time:
                due += delay + len(data) * byte_time
                self._wait_until(due)
            port.write(data)
        self._wire_free = due

    def _wait_until(self, t: float) -> None:
        delay = t - self._now()
        if delay > 0.0:
            time.sleep(delay)


def _sleep_sharply() -> None:
    """Let this thread's sleeps end on time; unless told so Linux lets them end 50 us late."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, _TIMER_SLACK_NS, 0, 0, 0)


def _build(
    arm: Arm, chain: ServoChain, q_start: FloatArray, *, held: bool
) -> tuple[ArmPlant, Rig, Line]:
    """Give the plant, the rig and the line of a chain."""
    require_turning(arm)
    if chain.protocol != 2.0:
        raise ValueError(f"chain: want servos of protocol 2.0, got {chain.protocol}")
    drives: list[Drive] = []
    free: list[Plant] = []
    servos: list[VirtualServo] = []
    for spec in chain.servos:
        motor, shaft = motor_of(spec.servo_model), Shaft()
        if spec.joint is None:
            free.append(FreePlant(motor, shaft))
        elif spec.joint in arm.joint_names:
            shaft.angle = float(q_start[arm.joint_names.index(spec.joint)])
            drives.append(Drive(spec.joint, motor, shaft))
        else:
            raise ValueError(f"servo {spec.name!r}: arm {arm.name!r} has no joint {spec.joint!r}")
        servos.append(VirtualServo.of(spec, chain.baud, shaft))
    plant = ArmPlant(arm, drives, q_start)
    return plant, Rig(servos, [plant, *free], held=held), Line(servos)
