"""A few servos on a pseudo terminal: control tables that answer packets, and knobs to misbehave."""

import os
import select
import threading
import tty
from collections import defaultdict
from dataclasses import dataclass, field

import numpy as np
import pytest

from splinearm.drivers.bus import PingReply
from splinearm.drivers.chain import ServoChain, ServoRole, ServoSpec
from splinearm.drivers.dynamixel import DynamixelBus
from splinearm.drivers.groups import (
    FastBlock,
    fast_reply_pieces,
    parse_read,
    parse_sync_read,
    parse_sync_write,
    parse_write,
    read_params,
)
from splinearm.drivers.model import ServoModel, servo_model
from splinearm.drivers.packets import (
    BROADCAST_ID,
    Decoder,
    Instruction,
    Packet,
    encode,
    encode_status,
    write_params,
)
from splinearm.drivers.registers import Area
from splinearm.drivers.servo_arm import ServoArm
from splinearm.errors import BusTimeoutError, PortError, ServoError
from splinearm.joints import JointKind, JointLimits, JointSetpoint
from splinearm.kinematics import Arm, DHConvention, DHLink, Inertia
from splinearm.sim.line import Line as VirtualLine
from splinearm.sim.motor import motor_of
from splinearm.sim.plant import FreePlant
from splinearm.sim.rig import Rig
from splinearm.sim.shaft import Shaft
from splinearm.sim.virtual_bus import VirtualBus
from splinearm.sim.virtual_servo import VirtualServo


@dataclass
class Servo:
    """A control table that obeys; its motor is where its goal is as soon as it has torque."""

    servo_id: int
    model: ServoModel
    stuck: bool = False
    values: dict[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.memory = bytearray(self.model.table.size)
        for register in self.model.table.registers:
            if isinstance(register.initial, int):
                self[register.name] = register.initial
        self["Model Number"] = self.model.number
        self["Firmware Version"] = 46
        self["ID"] = self.servo_id
        self["Present Position"] = 2048
        if "Present Input Voltage" in self.model.table:
            low, high = self["Min Voltage Limit"], self["Max Voltage Limit"]
            self["Present Input Voltage"] = (low + high) // 2
            self["Present Temperature"] = 30
        for name, value in self.values.items():
            self[name] = value

    def __getitem__(self, name: str) -> int:
        register = self.model.table[name]
        return register.decode(bytes(self.memory[register.address : register.end]))

    def __setitem__(self, name: str, value: int) -> None:
        register = self.model.table[name]
        self.memory[register.address : register.end] = register.encode(value)

    @property
    def alert(self) -> int:
        return 0x80 if self["Hardware Error Status"] else 0

    def read(self, address: int, length: int) -> bytes:
        return bytes(self.memory[address : address + length])

    def write(self, address: int, data: bytes) -> tuple[int, str, int]:
        """Store; give error number, register and value."""
        register = self.model.table.at(address)
        value = register.decode(data)
        error = 0
        if not register.writable or (register.area is Area.EEPROM and self["Torque Enable"]):
            error = 7
        elif register.name == "Goal Position" and self["Bus Watchdog"] == 0xFF:
            error = 4
        else:
            self[register.name] = value
        if self["Torque Enable"] and not self.stuck:
            self["Present Position"] = self["Goal Position"]
        return error, register.name, value


class Line:
    """Servos on a pty, served by a thread until ``close``."""

    def __init__(self, *servos: Servo) -> None:
        self.servos = {servo.servo_id: servo for servo in servos}
        self.silent: set[int] = set()
        self.damaged: set[int] = set()
        self.deaf_to: set[str] = set()
        self.mute: set[tuple[int, int]] = set()
        self.drops = 0
        self.knows_fast = True
        self.echoes = False
        self.noise = b""
        self.writes: list[tuple[int, str, int]] = []
        self.instructions: list[int] = []
        self.asked: dict[int, int] = defaultdict(int)
        self.decoder = Decoder()
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.port = os.ttyname(self._slave)
        self._wake_r, self._wake_w = os.pipe()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def close(self) -> None:
        os.write(self._wake_w, b".")
        self._thread.join()
        for fd in (self._slave, self._wake_r, self._wake_w):
            os.close(fd)
        if self._master >= 0:
            os.close(self._master)

    def vanish(self) -> None:
        """Pull the cable: the port hangs up."""
        os.write(self._wake_w, b".")
        self._thread.join()
        os.close(self._master)
        self._master = -1

    def written(self, name: str) -> list[tuple[int, int]]:
        return [(number, value) for number, register, value in self.writes if register == name]

    def _serve(self) -> None:
        while True:
            ready, _, _ = select.select([self._master, self._wake_r], [], [])
            if self._wake_r in ready:
                return
            data = os.read(self._master, 4096)
            answer = data if self.echoes else b""
            for packet in self.decoder.feed(data):
                self.instructions.append(packet.instruction)
                answer += self._answer(packet)
            if answer:
                os.write(self._master, self.noise + answer)

    def _answer(self, packet: Packet) -> bytes:
        servo_id, params = packet.servo_id, packet.params
        match packet.instruction:
            case Instruction.PING:
                answer = b"".join(self._ping(i) for i in self._meant(servo_id))
            case Instruction.READ:
                answer = self._read(servo_id, *parse_read(params))
            case Instruction.WRITE:
                answer = self._write(servo_id, *parse_write(params))
            case Instruction.SYNC_WRITE:
                address, _, blocks = parse_sync_write(params)
                for each, data in blocks:
                    self._write(each, address, data)
                answer = b""
            case Instruction.SYNC_READ:
                address, length, ids = parse_sync_read(params)
                answer = b"".join(self._read(i, address, length) for i in ids)
            case Instruction.FAST_SYNC_READ:
                answer = self._fast(*parse_sync_read(params))
            case Instruction.REBOOT:
                self.servos[servo_id]["Hardware Error Status"] = 0
                answer = self._status(servo_id)
            case _:
                answer = self._status(servo_id)
        return answer

    def _meant(self, servo_id: int) -> list[int]:
        return sorted(self.servos) if servo_id == BROADCAST_ID else [servo_id]

    def _ping(self, servo_id: int) -> bytes:
        if servo_id not in self.servos:
            return b""
        servo = self.servos[servo_id]
        number, firmware = servo["Model Number"], servo["Firmware Version"]
        return self._status(servo_id, number.to_bytes(2, "little") + bytes((firmware,)))

    def _read(self, servo_id: int, address: int, length: int) -> bytes:
        if servo_id not in self.servos:
            return b""
        self.asked[servo_id] += 1
        return self._status(servo_id, self.servos[servo_id].read(address, length))

    def _write(self, servo_id: int, address: int, data: bytes) -> bytes:
        error = None
        for servo in self.servos.values():
            secondary = servo["Secondary(Shadow) ID"]
            if servo_id in (servo.servo_id, secondary) and servo.servo_id not in self.silent:
                if servo.model.table.at(address).name in self.deaf_to:
                    continue
                number, name, value = servo.write(address, data)
                self.writes.append((servo.servo_id, name, value))
                error = number if servo.servo_id == servo_id else error
        return b"" if error is None else self._status(servo_id, error=error)

    def _status(self, servo_id: int, params: bytes = b"", error: int = 0) -> bytes:
        if servo_id in self.silent or (servo_id, self.instructions[-1]) in self.mute:
            return b""
        if self.drops:
            self.drops -= 1
            return b""
        frame = encode_status(servo_id, error | self.servos[servo_id].alert, params)
        if servo_id in self.damaged:
            return frame[:-1] + bytes((frame[-1] ^ 0x10,))
        return frame

    def _fast(self, address: int, length: int, ids: tuple[int, ...]) -> bytes:
        """Answer as far as the first servo that is silent: each waits for the one before."""
        if not self.knows_fast:
            return b""
        servos = [self.servos[i] for i in ids]
        blocks = [FastBlock(s.servo_id, s.alert, s.read(address, length)) for s in servos]
        answer = b""
        for piece, servo_id in zip(fast_reply_pieces(blocks), ids, strict=True):
            if servo_id in self.silent:
                break
            damaged = servo_id in self.damaged
            answer += piece[:-1] + bytes((piece[-1] ^ 0x10,)) if damaged else piece
        return answer


JOINTS = ("waist", "shoulder", "elbow")


def make_limits(low: float = -1.5, high: float = 1.5, names: tuple[str, ...] = JOINTS):
    n = len(names)
    return JointLimits(
        names=names,
        kinds=(JointKind.REVOLUTE,) * n,
        q_min=np.full(n, low),
        q_max=np.full(n, high),
        qd_max=np.full(n, 3.0),
        qdd_max=np.full(n, 20.0),
    )


def spec(name: str, servo_id: int, **changes) -> ServoSpec:
    facts = {
        "name": name,
        "servo_id": servo_id,
        "model": "XM430-W350",
        "role": ServoRole.LEADER,
        "joint": name,
        "zero_ticks": 2048,
    }
    return ServoSpec(**(facts | changes))


SHADOW = {"Drive Mode": 1, "Secondary(Shadow) ID": 2}


def make_chain(**changes) -> ServoChain:
    """Three joints; the shoulder has a shadow, the elbow is of a model that measures no current."""
    servos = (
        spec("waist", 1, **changes),
        spec("shoulder", 2, settings={"Position P Gain": 900, "Velocity Limit": 200}),
        spec("shadow", 3, role=ServoRole.SHADOW, joint="shoulder", settings=SHADOW),
        spec("elbow", 4, model="XL430-W250"),
    )
    return ServoChain(servos=servos)


@pytest.fixture
def line():
    """The servos of ``make_chain``, on a pty."""
    xm, xl = servo_model("XM430-W350"), servo_model("XL430-W250")
    servos = Line(Servo(1, xm), Servo(2, xm), Servo(3, xm, values=SHADOW), Servo(4, xl))
    yield servos
    servos.close()


@pytest.fixture
def make_line():
    """Make lines of other servos; they are closed at the end."""
    made: list[Line] = []

    def make(*servos: Servo) -> Line:
        made.append(Line(*servos))
        return made[-1]

    yield make
    for one in made:
        one.close()


@pytest.fixture(name="make_chain")
def _make_chain():
    return make_chain


@pytest.fixture
def make_spec():
    return spec


@pytest.fixture(name="make_limits")
def _make_limits():
    return make_limits


@pytest.fixture
def open_arm(line):
    """Make arms on the line; their buses are closed at the end."""
    buses: list[DynamixelBus] = []

    def make(chain=None, limits=None, margin=0.15, **options) -> ServoArm:  # a pty may have to wait
        limits = make_limits() if limits is None else limits
        buses.append(DynamixelBus(line.port, margin=margin))
        chain = make_chain() if chain is None else chain
        return ServoArm(chain, limits.names, limits, buses[-1], **options)

    yield make
    for bus in buses:
        bus.close()


@pytest.fixture
def setpoint():
    """Make setpoints at rest."""

    def make(*q: float, t: float = 0.0) -> JointSetpoint:
        return JointSetpoint(t=t, q=np.array(q), qd=np.zeros(len(q)), qdd=np.zeros(len(q)))

    return make


class DirectBus:
    """Virtual servos without port and wire: packets go straight to their line, in its own time.

    Every exchange takes 1 ms; ``watch`` is called after each with the bus.
    """

    port = "direct"
    margin = 0.001
    retries: dict[int, int] = {}  # noqa: RUF012 - nothing is ever sent twice

    def __init__(self, chain: ServoChain) -> None:
        self.baud = chain.baud
        shafts = {spec.joint or spec.name: Shaft() for spec in chain.servos}
        self.servos = {
            spec.servo_id: VirtualServo.of(spec, chain.baud, shafts[spec.joint or spec.name])
            for spec in chain.servos
        }
        self.line = VirtualLine(self.servos.values())
        model = chain.servos[0].servo_model
        plants = [FreePlant(motor_of(model), shaft) for shaft in shafts.values()]
        self.rig = Rig(list(self.servos.values()), plants)
        self.plants = dict(zip(shafts, plants, strict=True))
        self.shafts = shafts
        self.sent: list[Packet] = []
        self.gone = False
        self.watch = lambda: None

    @property
    def now(self) -> float:
        return self.rig.now

    def monotonic(self) -> float:
        return self.rig.now

    def sleep(self, duration: float) -> None:
        self.rig.wake()
        self.rig.advance_to(self.rig.now + duration + 1e-9)
        self.watch()

    def ask(self, frame: bytes) -> bytes:
        if self.gone:
            raise PortError(self.port, "the connection is lost", "check the cable")
        answer = b""
        for packet in Decoder().feed(frame):
            self.sent.append(packet)
            self.rig.wake()
            answer += b"".join(reply.data for reply in self.line.answer(packet, self.baud))
            self.sleep(1e-3)
        return answer

    def status(self, servo_id: int, instruction: Instruction, params: bytes = b"") -> Packet:
        for packet in Decoder().feed(self.ask(encode(servo_id, instruction, params))):
            if packet.servo_id == servo_id and packet.is_status:
                if packet.error_number:
                    raise ServoError(servo_id, "refused", code=packet.error_number)
                return packet
        raise BusTimeoutError(servo_id, port=self.port)

    def speak(self, protocols) -> None:
        assert not [i for i, protocol in protocols.items() if protocol != 2]

    def ping(self, servo_id: int, tries: int = 1) -> PingReply:
        params = self.status(servo_id, Instruction.PING).params
        return PingReply(servo_id, params[0] | params[1] << 8, params[2])

    def scan(self) -> tuple[PingReply, ...]:
        return tuple(self.ping(servo_id) for servo_id in sorted(self.servos))

    def read(self, servo_id: int, register) -> int:
        params = read_params(register.address, register.size)
        return register.decode(self.status(servo_id, Instruction.READ, params).params)

    def write(self, servo_id: int, register, value: int) -> None:
        params = write_params(register.address, register.encode(value))
        self.status(servo_id, Instruction.WRITE, params)

    def sync_read(self, group):
        replies, _ = group.parse(self.ask(group.request))
        group.learn(replies)
        return replies

    fetch = sync_read

    def sync_write(self, group, values) -> None:
        self.ask(group.frame(values))

    def reboot(self, servo_id: int) -> None:
        self.status(servo_id, Instruction.REBOOT)

    def reopen(self, port: str | None = None) -> None:
        self.gone = False

    def close(self) -> None:
        pass


@pytest.fixture
def make_direct():
    """Make buses of virtual servos without port and wire."""
    return DirectBus


@pytest.fixture
def in_their_time(monkeypatch):
    """Let what the driver waits for pass in the time of a direct bus."""

    def live_in(bus: DirectBus) -> None:
        modules = ("recover", "watchdog", "health", "servo_arm", "exchange", "torque", "gripper")
        for module in modules:
            monkeypatch.setattr(f"splinearm.drivers.{module}.time", bus)

    return live_in


class SteppedArm:
    """Virtual servos in MuJoCo on a clock that only the test moves; what they are sent takes no
    time but ``wait``."""

    def __init__(self, arm, chain, q_start, make_feedforward, period=0.01, wait=0.002):
        self.period, self.wait, self.t = period, wait, 0.0
        self.arm, self.chain = arm, chain
        self.virtual = VirtualBus(arm, chain, q_start, wire_time=False, clock=lambda: self.t)
        self.virtual.__enter__()
        self.bus = DynamixelBus(self.virtual.port, chain.baud, margin=1.0)
        self.feedforward = make_feedforward(self.bus)
        self.driver = ServoArm(
            chain,
            arm.joint_names,
            arm.limits,
            self.bus,
            watchdog=None,
            feedforward=self.feedforward,
        )

    def close(self) -> None:
        self.bus.close()
        self.virtual.__exit__(None, None, None)

    def pass_time(self, duration: float) -> None:
        """Let time go by; a write that nobody answers is taken before."""
        self.bus.ping(self.chain.servos[0].servo_id)
        self.t += duration
        self.virtual.advance()

    def cycle(self, setpoint: JointSetpoint) -> np.ndarray:
        """Read, write, and give where the joints were at the time of the setpoint."""
        self.driver.read()
        q = self.virtual.q
        self.pass_time(self.wait)
        self.driver.write(setpoint)
        self.pass_time(self.period - self.wait)
        return q

    def rest(self, q, duration: float) -> np.ndarray:
        """Lead the arm to rest at q from where it is held."""
        start, still = self.driver.goal, np.zeros(len(q))
        count = round(duration / self.period)
        for k in range(count):
            s = min(1.0, 2.0 * k / count)
            way = start + (q - start) * s * s * (3.0 - 2.0 * s)
            self.cycle(JointSetpoint(t=0.0, q=way, qd=still, qdd=still))
        return self.virtual.q

    def push(self, torques) -> None:
        """Push the joints from outside from here on."""
        self.virtual.push(np.broadcast_to(torques, self.arm.n))


@pytest.fixture
def stepped_arm():
    """Make virtual arms on a clock of their own; they are closed at the end."""
    made: list[SteppedArm] = []

    def make(arm, chain, q_start, make_feedforward=lambda _: None, **options) -> SteppedArm:
        made.append(SteppedArm(arm, chain, q_start, make_feedforward, **options))
        return made[-1]

    yield make
    for one in made:
        one.close()


def pendulum(n: int, mass: float, length: float = 0.2, speed: float = 2.0) -> Arm:
    """Give n rods, one on the other, that swing in a vertical plane."""
    names = tuple(f"j{k}" for k in range(n))
    limits = JointLimits(
        names=names,
        kinds=(JointKind.REVOLUTE,) * n,
        q_min=np.full(n, -2.9),
        q_max=np.full(n, 2.9),
        qd_max=np.full(n, speed),
        qdd_max=np.full(n, 20.0),
    )
    across = mass * length**2 / 12.0
    rod = Inertia(mass, np.array([-length / 2, 0, 0]), np.diag([0.1 * across, across, across]))
    upright = np.eye(4)
    upright[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    rows = [DHLink(name, length, 0.0, 0.0, 0.0) for name in names]
    standard = DHConvention.STANDARD
    return Arm.from_dh("pendulum", rows, standard, limits, inertias=[rod] * n, T_world_base=upright)


@pytest.fixture(name="pendulum")
def _pendulum():
    return pendulum
