"""The virtual bus on a socket: time on the wire, faults of the line, both protocols at once."""

import socket
import time
from pathlib import Path

import pytest
import serial

from splinearm.drivers import packets_v1
from splinearm.drivers.chain import ServoChain, ServoRole, ServoSpec
from splinearm.drivers.packets import Decoder, Instruction, encode, read_params, sync_read_params
from splinearm.sim.habit import LineHabits
from splinearm.sim.line_fault import FaultKind, LineFault
from splinearm.sim.virtual_bus import VirtualBus

pytestmark = pytest.mark.bus

PING = encode(1, Instruction.PING)
PATIENCE = 0.15


class Client:
    """A client that reads until it has enough bytes or nothing comes for a while."""

    def __init__(self, wire: socket.socket) -> None:
        self.wire = wire
        wire.settimeout(PATIENCE)

    def ask(self, request: bytes, want: int = 14) -> bytes:
        self.wire.sendall(request)
        return self.read(want)

    def read(self, want: int) -> bytes:
        got = b""
        while len(got) < want:
            try:
                data = self.wire.recv(4096)
            except TimeoutError:
                break
            if not data:
                break
            got += data
        return got


@pytest.fixture
def make_bus(make_arm, make_chain):
    """Give a maker of buses of three servos on a socket, with their clients."""
    made = []

    def make(chain: ServoChain | None = None, **options):
        bus = VirtualBus(make_arm(3), chain or make_chain(3), transport="socket", **options)
        made.append(bus.__enter__())
        made.append(bus.connect())
        return bus, Client(made[-1])

    yield make
    for each in reversed(made):
        each.__exit__(None, None, None)


def faults(*words: str) -> tuple[LineFault, ...]:
    return tuple(LineFault.parse(text) for text in words)


# time


def took(client: Client, request: bytes, want: int) -> float:
    begun = time.perf_counter()
    assert len(client.ask(request, want)) == want
    return time.perf_counter() - begun


def test_no_answer_comes_before_the_wire_has_had_its_time(make_bus, make_chain):
    _, client = make_bus(make_chain(3, baud=115_200))
    read = encode(0xFE, Instruction.SYNC_READ, sync_read_params(126, 10, [1, 2, 3]))
    least = (len(read) + 63) * 10 / 115_200
    assert min(took(client, read, 63) for _ in range(20)) >= least


def test_every_servo_keeps_its_return_delay(make_bus, make_chain):
    _, client = make_bus(make_chain(3, **{"Return Delay Time": 250}))
    read = encode(0xFE, Instruction.SYNC_READ, sync_read_params(126, 10, [1, 2, 3]))
    assert took(client, read, 63) >= (len(read) + 63) * 1e-5 + 3 * 500e-6


def test_a_usb_adapter_makes_every_transaction_wait_for_its_tick(make_bus):
    _, client = make_bus(usb_latency=0.016)
    took(client, PING, 14)
    assert sum(took(client, PING, 14) for _ in range(6)) >= 5 * 0.016


def test_how_late_it_is_is_told(make_bus):
    bus, client = make_bus()
    assert bus.lateness == (0.0, 0.0)
    for _ in range(20):
        client.ask(PING)
    middle, worst = bus.lateness
    assert 0.0 <= middle <= worst


def test_a_request_into_a_reply_loses_both(make_bus, make_chain):
    bus, client = make_bus(make_chain(3, baud=9600))
    read = encode(1, Instruction.READ, read_params(0, 100))
    client.wire.sendall(read)
    time.sleep(len(read) * 10 / 9600 + 0.03)
    client.wire.sendall(encode(2, Instruction.WRITE, b"\x41\x00\x01"))
    got = client.read(111)
    assert len(got) == 111
    assert Decoder().feed(got) == []
    assert bus.servos[2].value("LED") == 0
    assert len(Decoder().feed(client.ask(PING))) == 1


def test_requests_sent_at_once_are_obeyed_one_after_the_other(make_bus):
    bus, client = make_bus()
    led = encode(0xFE, Instruction.WRITE, b"\x41\x00\x01")
    assert len(client.ask(led + led + PING)) == 14
    assert [servo.value("LED") for servo in bus.servos.values()] == [1, 1, 1]


# faults


def replies(bus, client: Client, *words: str, request: bytes = PING, want: int = 14) -> list:
    bus.faults = faults(*words)
    return Decoder().feed(client.ask(request, want))


def test_faults_are_set_while_it_runs(make_bus):
    bus, client = make_bus()
    assert bus.faults == ()
    assert len(replies(bus, client)) == 1
    assert replies(bus, client, "lost id=1") == []
    assert bus.faults[0].kind is FaultKind.LOST
    assert replies(bus, client, "dead id=1") == []
    assert replies(bus, client, "corrupt id=1 n=1") == []
    assert replies(bus, client, "truncated n=1") == []
    assert len(replies(bus, client, "noise size=20", want=34)) == 1
    assert len(replies(bus, client, "doubled", want=28)) == 2
    assert len(replies(bus, client, "lost id=2")) == 1


def test_a_servo_is_silent_for_a_time(make_bus):
    bus, client = make_bus()
    bus.faults = faults("dead id=1 for=0.3")
    assert client.ask(PING) == b""
    time.sleep(0.3)
    assert len(client.ask(PING)) == 14


def test_a_late_reply_comes_after_all(make_bus):
    bus, client = make_bus()
    bus.faults = faults("late by=0.2 n=1")
    assert client.ask(PING) == b""
    assert len(client.read(14)) == 14


def test_an_adapter_may_hear_itself(make_bus):
    bus, client = make_bus()
    bus.faults = faults("echo")
    assert client.ask(PING, len(PING) + 14)[: len(PING)] == PING
    everyone = encode(0xFE, Instruction.WRITE, b"\x41\x00\x01")
    assert client.ask(everyone, len(everyone)) == everyone


def test_a_bus_that_pauses_answers_late(make_bus):
    bus, client = make_bus()
    bus.faults = faults("pause by=0.05 n=1")
    assert took(client, PING, 14) >= 0.05
    assert not bus._line.faults.strikes(FaultKind.PAUSE)


def test_habits_are_set_while_it_runs(make_bus):
    bus, client = make_bus()
    damaged = PING[:-1] + bytes((PING[-1] ^ 1,))
    assert client.ask(damaged) == b""
    bus.habits = LineHabits(answers_bad_crc=True)
    assert [p.error for p in Decoder().feed(client.ask(damaged, 11))] == [3]


def test_two_servos_with_one_id_answer_at_once(make_bus):
    bus, client = make_bus()
    with bus.lock:
        bus.all_servos[1].memory["ID"] = 1
        bus.all_servos[1].memory["Firmware Version"] = 44
    assert Decoder().feed(client.ask(PING)) == []
    assert [servo.servo_id for servo in bus.all_servos] == [1, 1, 3]


# ports that come and go


def test_a_port_vanishes_and_comes_back_under_another_name(make_bus):
    bus, client = make_bus()
    before = bus.port
    bus.unplug()
    assert client.wire.recv(1) == b""
    with pytest.raises(RuntimeError, match="unplugged"):
        _ = bus.port
    with pytest.raises(RuntimeError, match="transport='socket'"):
        bus.connect()
    now = bus.servos[1].now
    time.sleep(0.1)
    bus.advance()
    assert bus.servos[1].now > now + 0.05
    after = bus.plug_in()
    assert after == bus.port != before
    with socket.socket(socket.AF_UNIX) as wire:
        wire.connect(after.removeprefix("unix:"))
        assert len(Client(wire).ask(PING)) == 14
    with pytest.raises(RuntimeError, match="not unplugged"):
        bus.plug_in()


def test_a_device_comes_back_under_another_name_and_a_link_leads_to_it(
    make_arm, make_chain, tmp_path
):
    link = tmp_path / "arm"
    with VirtualBus(make_arm(2), make_chain(2), link=link) as bus:
        before = bus.port
        assert link.readlink() == Path(before)
        with serial.Serial(before, 1_000_000, timeout=1.0) as wire:
            bus.unplug()
            assert not link.is_symlink()
            assert not Path(before).exists()
            with pytest.raises(serial.SerialException):
                wire.read(1)
        assert bus.plug_in() != before
        with serial.Serial(str(link), 1_000_000, timeout=1.0) as wire:
            wire.write(PING)
            assert len(wire.read(14)) == 14
    assert not link.is_symlink()


def test_a_bus_that_ends_unplugged_leaves_nothing(make_arm, make_chain):
    with VirtualBus(make_arm(2), make_chain(2), transport="socket") as bus:
        folder = Path(bus.port.removeprefix("unix:")).parent
        bus.unplug()
        with pytest.raises(RuntimeError, match="no port"):
            bus.unplug()
    assert not folder.exists()


@pytest.mark.parametrize("options", [{"transport": "usb"}, {"usb_latency": -1.0}])
def test_wiring_that_there_is_not_is_refused(make_arm, make_chain, options):
    with pytest.raises(ValueError, match=next(iter(options))):
        VirtualBus(make_arm(2), make_chain(2), **options)


# both protocols on one wire


@pytest.fixture
def mixed() -> ServoChain:
    """Give an AX-12A and two XM430, one of which speaks Protocol 1.0."""

    def spec(k: int, model: str, **settings: int) -> ServoSpec:
        named = {name.replace("_", " "): value for name, value in settings.items()}
        return ServoSpec(
            name=f"s{k}",
            servo_id=k + 1,
            model=model,
            role=ServoRole.LEADER,
            joint=f"j{k}",
            settings={"Return Delay Time": 0, **named},
        )

    servos = (spec(0, "AX-12A"), spec(1, "XM430-W350", Protocol_Type=1), spec(2, "XM430-W350"))
    return ServoChain(servos=servos, baud=1_000_000)


def test_both_protocols_live_on_one_wire(make_bus, mixed):
    bus, client = make_bus(mixed)
    old = [packets_v1.encode(k, Instruction.PING) for k in (1, 2, 3)]
    new = [encode(k, Instruction.PING) for k in (1, 2, 3)]
    assert [len(client.ask(ping, 6)) for ping in old] == [6, 6, 0]
    assert [len(client.ask(ping)) for ping in new] == [0, 0, 14]
    carrier = encode(3, Instruction.WRITE, b"\x41\x00" + packets_v1.encode(1, 3, b"\x19\x01"))
    client.ask(carrier, 11)
    assert bus.servos[1].value("LED") == 0
    led = packets_v1.encode(0xFE, Instruction.WRITE, b"\x19\x01")
    assert len(client.ask(led + new[2])) == 14
    assert bus.servos[1].value("LED") == 1


def test_a_gap_of_a_tenth_of_a_second_ends_a_packet_of_protocol_1(make_bus, mixed):
    _, client = make_bus(mixed)
    ping = packets_v1.encode(1, Instruction.PING)
    client.wire.sendall(ping[:3])
    time.sleep(0.02)
    assert len(client.ask(ping[3:], 6)) == 6
    client.wire.sendall(ping[:3])
    time.sleep(0.15)
    assert client.ask(ping[3:], 6) == b""
    assert len(client.ask(ping, 6)) == 6
