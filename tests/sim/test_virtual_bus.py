"""The virtual bus as the maker's own SDK sees it: through a serial port.

Most tests have the bus in the same process, to look into it. There the SDK, which polls, would take
the bus its turns, so its reads wait for a millisecond. ``test_virtual_bus_sdk.py`` has the SDK as
it is, in a process of its own.
"""

import os
import signal
import subprocess
import sys
import threading
import time
from math import tau

import dynamixel_sdk as sdk
import numpy as np
import pytest
import serial

from splinearm.drivers.chain import ServoChain, ServoRole, ServoSpec
from splinearm.drivers.packets import Instruction, encode, read_params
from splinearm.errors import LimitError
from splinearm.sim.virtual_bus import VirtualBus

pytestmark = pytest.mark.bus

OK = sdk.COMM_SUCCESS
ID, TORQUE, LED, HARDWARE, WATCHDOG = 7, 64, 65, 70, 98
VELOCITY, GOAL, PRESENT_VELOCITY, PRESENT = 104, 116, 128, 132
Q_START = (0.4, -0.3)


def ticks(q: float) -> int:
    return 2048 + round(q * 4096 / tau)


def until(condition, patience: float = 3.0) -> bool:
    """Wait for a condition; tell whether it came true."""
    deadline = time.monotonic() + patience
    while time.monotonic() < deadline:
        if condition():
            return True
        time.sleep(0.002)
    return False


@pytest.fixture(autouse=True)
def _fair_turns(monkeypatch):
    """Let the SDK sleep while it waits, and be patient with a busy computer."""
    setup = sdk.PortHandler.setupPort

    def set_up_with_a_pause(self, baud_code):
        done = setup(self, baud_code)
        self.ser.timeout = 1e-3
        return done

    monkeypatch.setattr(sdk.PortHandler, "setupPort", set_up_with_a_pause)
    monkeypatch.setattr(sdk.port_handler, "LATENCY_TIMER", 150)
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-4)
    yield
    sys.setswitchinterval(before)


@pytest.fixture
def bus(make_arm, make_chain):
    with VirtualBus(make_arm(2), make_chain(2), Q_START, wire_time=False) as made:
        yield made


@pytest.fixture
def port(bus):
    made = sdk.PortHandler(bus.port)
    assert made.openPort()
    assert made.setBaudRate(1_000_000)
    yield made
    made.closePort()


@pytest.fixture
def client():
    return sdk.PacketHandler(2.0)


# one servo at a time


def test_ping(client, port):
    assert client.ping(port, 1) == (1020, OK, 0)
    assert client.ping(port, 9)[1] == sdk.COMM_RX_TIMEOUT


def test_broadcast_ping(client, port):
    assert client.broadcastPing(port) == ({1: [1020, 53], 2: [1020, 53]}, OK)


def test_read(client, port):
    assert client.read1ByteTxRx(port, 1, ID) == (1, OK, 0)
    assert client.read2ByteTxRx(port, 2, 144) == (120, OK, 0)
    assert client.read4ByteTxRx(port, 1, PRESENT) == (ticks(0.4), OK, 0)
    assert client.read4ByteTxRx(port, 2, PRESENT) == (ticks(-0.3), OK, 0)


def test_write(client, port, bus):
    assert client.write1ByteTxRx(port, 1, LED, 1) == (OK, 0)
    assert client.write2ByteTxRx(port, 1, 84, 640) == (OK, 0)
    assert client.write4ByteTxRx(port, 1, 112, 30) == (OK, 0)
    with bus.lock:
        servo = bus.servos[1]
        assert [servo.value(n) for n in ("LED", "Position P Gain", "Profile Velocity")] == [
            1, 640, 30,
        ]  # fmt: skip


@pytest.mark.parametrize(
    ("address", "size", "value", "error"),
    [
        (PRESENT, 4, 0, 7),
        (TORQUE, 1, 2, 4),
        (GOAL, 4, 4096, 6),
        (GOAL, 2, 100, 5),
        (66, 1, 0, 7),
    ],
)
def test_refused_writes_come_back_with_their_error(client, port, address, size, value, error):
    write = {
        1: client.write1ByteTxRx,
        2: client.write2ByteTxRx,
        4: client.write4ByteTxRx,
    }[size]
    assert write(port, 1, address, value) == (OK, error)


def test_the_eeprom_lock(client, port):
    client.write1ByteTxRx(port, 1, TORQUE, 1)
    assert client.write1ByteTxRx(port, 1, 10, 4) == (OK, 7)


def test_reg_write_and_action(client, port):
    assert client.regWriteTxRx(port, 1, LED, 1, [1]) == (OK, 0)
    assert client.read1ByteTxRx(port, 1, LED)[0] == 0
    assert client.action(port, sdk.BROADCAST_ID) == OK  # alone it would not await its answer
    assert client.read1ByteTxRx(port, 1, LED)[0] == 1


def test_clear_multi_turn(client, port, bus):
    client.write1ByteTxRx(port, 1, 11, 4)
    assert client.clearMultiTurn(port, 1) == (OK, 0)


def test_reboot(client, port):
    client.write1ByteTxRx(port, 1, LED, 1)
    assert client.reboot(port, 1) == (OK, 0)
    assert client.ping(port, 1)[1] == sdk.COMM_RX_TIMEOUT  # it boots
    assert until(lambda: client.ping(port, 1)[1] == OK)
    assert client.read1ByteTxRx(port, 1, LED) == (0, OK, 0)


def test_factory_reset(client, port):
    client.write1ByteTxRx(port, 2, 10, 4)
    assert client.factoryReset(port, 2, 0x02) == (OK, 0)
    assert until(lambda: client.ping(port, 2)[1] == OK)
    assert client.read1ByteTxRx(port, 2, 10) == (0, OK, 0)
    assert client.factoryReset(port, 2, 0x01) == (OK, 0)
    port.setBaudRate(57_600)  # as from the factory
    assert until(lambda: client.ping(port, 2)[1] == OK)


def test_a_changed_id_and_baud_rate_hold_at_once(client, port):
    assert client.write1ByteTxRx(port, 2, ID, 22) == (OK, 0)
    assert client.ping(port, 22)[1] == OK
    assert client.write1ByteTxRx(port, 22, 8, 4) == (OK, 0)
    assert client.ping(port, 22)[1] == sdk.COMM_RX_TIMEOUT
    port.setBaudRate(2_000_000)
    assert client.ping(port, 22)[1] == OK


def test_at_the_wrong_baud_rate_nobody_answers(client, port):
    port.setBaudRate(57_600)
    assert client.ping(port, 1)[1] == sdk.COMM_RX_TIMEOUT
    port.setBaudRate(1_000_000)
    assert client.ping(port, 1)[1] == OK


# groups


def test_group_sync_write_and_read(client, port):
    writer = sdk.GroupSyncWrite(port, client, GOAL, 4)
    for servo_id, goal in ((1, 1500), (2, 2600)):
        assert writer.addParam(servo_id, list(goal.to_bytes(4, "little")))
    assert writer.txPacket() == OK
    reader = sdk.GroupSyncRead(port, client, GOAL, 4)
    assert all(reader.addParam(servo_id) for servo_id in (2, 1))
    assert reader.txRxPacket() == OK
    assert [reader.getData(servo_id, GOAL, 4) for servo_id in (1, 2)] == [1500, 2600]


def test_group_fast_sync_read(client, port):
    reader = sdk.GroupSyncRead(port, client, 126, 10)
    assert all(reader.addParam(servo_id) for servo_id in (1, 2))
    assert reader.fastSyncRead() == OK
    assert [reader.getData(k, PRESENT, 4) for k in (1, 2)] == [ticks(0.4), ticks(-0.3)]


def test_group_bulk_write_and_read(client, port):
    writer = sdk.GroupBulkWrite(port, client)
    assert writer.addParam(1, LED, 1, [1])
    assert writer.addParam(2, GOAL, 4, list((2100).to_bytes(4, "little")))
    assert writer.txPacket() == OK
    reader = sdk.GroupBulkRead(port, client)
    assert reader.addParam(1, LED, 1)
    assert reader.addParam(2, GOAL, 4)
    assert reader.txRxPacket() == OK
    assert (reader.getData(1, LED, 1), reader.getData(2, GOAL, 4)) == (1, 2100)


def test_group_fast_bulk_read(client, port):
    reader = sdk.GroupBulkRead(port, client)
    assert reader.addParam(2, PRESENT, 4)
    assert reader.addParam(1, 146, 1)
    assert reader.fastBulkRead() == OK
    assert (reader.getData(2, PRESENT, 4), reader.getData(1, 146, 1)) == (ticks(-0.3), 30)


# the arm


def test_the_torque_holds_the_arm_where_it_stands(client, port, bus):
    for servo_id in (1, 2):
        assert client.write1ByteTxRx(port, servo_id, TORQUE, 1) == (OK, 0)
    assert until(lambda: bus.servos[1].now > 0.1)
    np.testing.assert_allclose(bus.q, Q_START, atol=2e-3)


def test_goals_move_joints(client, port, bus):
    for servo_id, q in ((1, -0.5), (2, 0.6)):
        client.write1ByteTxRx(port, servo_id, TORQUE, 1)
        assert client.write4ByteTxRx(port, servo_id, GOAL, ticks(q)) == (OK, 0)
    assert until(lambda: bus.rig.asleep)
    np.testing.assert_allclose(bus.q, (-0.5, 0.6), atol=0.01)
    assert abs(client.read4ByteTxRx(port, 1, PRESENT)[0] - ticks(-0.5)) < 8


def test_a_hardware_error_is_told_by_the_alert_bit(client, port, bus):
    with bus.lock:
        bus.servos[1].hardware_error(0x20)
    assert client.read1ByteTxRx(port, 1, HARDWARE) == (0x20, OK, 0x80)
    assert client.read1ByteTxRx(port, 2, HARDWARE) == (0, OK, 0)


def test_a_gripper_turns_freely(make_arm, make_chain, client):
    gripper = ServoSpec(name="g", servo_id=9, model="XL330-M288", role=ServoRole.GRIPPER)
    chain = ServoChain(servos=(*make_chain(2).servos, gripper), baud=1_000_000)
    with VirtualBus(make_arm(2), chain, wire_time=False) as bus:
        port = sdk.PortHandler(bus.port)
        port.setBaudRate(1_000_000)
        client.write1ByteTxRx(port, 9, TORQUE, 1)
        assert client.write4ByteTxRx(port, 9, GOAL, 2500) == (OK, 0)
        assert until(lambda: abs(client.read4ByteTxRx(port, 9, PRESENT)[0] - 2500) < 8)
        np.testing.assert_allclose(bus.q, 0.0, atol=1e-6)
        port.closePort()


def test_a_shadow_helps_its_leader_without_a_packet_of_its_own(make_arm, client):
    def servo(servo_id: int, role: ServoRole, **settings: int) -> ServoSpec:
        return ServoSpec(
            name=role.value,
            servo_id=servo_id,
            model="XM430-W350",
            role=role,
            joint="j0",
            zero_ticks=2048,
            settings=settings,
        )

    leader = servo(1, ServoRole.LEADER)
    facing = {"Drive Mode": 1, "Secondary(Shadow) ID": 1}
    chain = ServoChain(servos=(leader, servo(2, ServoRole.SHADOW, **facing)), baud=1_000_000)
    with VirtualBus(make_arm(1), chain, wire_time=False) as bus:
        port = sdk.PortHandler(bus.port)
        port.setBaudRate(1_000_000)
        assert client.write1ByteTxRx(port, 1, TORQUE, 1) == (OK, 0)
        assert client.write4ByteTxRx(port, 1, GOAL, ticks(0.5)) == (OK, 0)
        assert client.read1ByteTxRx(port, 2, TORQUE) == (1, OK, 0)
        assert until(lambda: bus.rig.asleep)
        assert abs(bus.q[0] - 0.5) < 0.01
        positions = [client.read4ByteTxRx(port, k, PRESENT)[0] for k in (1, 2)]
        assert abs(positions[0] - positions[1]) <= 2
        port.closePort()


CLIENT = """
import sys, dynamixel_sdk as sdk
port, client = sdk.PortHandler(sys.argv[1]), sdk.PacketHandler(2.0)
port.setBaudRate(1_000_000)
client.write1ByteTxRx(port, 1, 11, 1)
client.write1ByteTxRx(port, 1, 64, 1)
client.write1ByteTxRx(port, 1, 98, 20)
while True:
    client.write4ByteTxRx(port, 1, 104, 40)
    print("moving", flush=True)
"""


def test_a_killed_client_leaves_the_arm_standing(bus):
    process = subprocess.Popen(
        [sys.executable, "-c", CLIENT, bus.port], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    servo = bus.servos[1]
    while process.stdout.readline() and servo.value("Present Velocity") < 30:
        pass
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    assert until(lambda: servo.tripped)
    assert until(lambda: servo.value("Present Velocity") == 0)
    assert servo.torque_on


# faults on the wire


def raw(bus, *chunks: bytes, pause: float = 0.0, want: int = 14) -> bytes:
    """Send chunks with pauses between them; give what comes back."""
    with serial.Serial(bus.port, 1_000_000, timeout=0.05) as wire:
        for k, chunk in enumerate(chunks):
            if k and pause:
                time.sleep(pause)
            wire.write(chunk)
        return wire.read(want)


PING = encode(1, Instruction.PING)


def test_noise_before_a_packet_is_ignored(bus):
    assert len(raw(bus, b"\x00\xff\xff\x12" + PING)) == 14


def test_a_damaged_packet_is_ignored_and_the_next_is_answered(bus):
    assert raw(bus, PING[:-1] + bytes((PING[-1] ^ 1,))) == b""
    assert len(raw(bus, PING)) == 14


def test_a_packet_in_pieces_is_answered_if_they_come_quickly(bus):
    pieces = [PING[k : k + 1] for k in range(len(PING))]
    assert until(lambda: len(raw(bus, *pieces)) == 14)  # unless this machine makes a pause


def test_a_gap_within_a_packet_loses_it(bus):
    assert raw(bus, PING[:6], PING[6:], pause=0.02) == b""
    assert len(raw(bus, PING)) == 14


def test_a_mute_and_an_unplugged_servo_do_not_answer(bus, client, port):
    bus.servos[1].mute = True
    bus.servos[2].unplugged = True
    assert client.write1ByteTxRx(port, 1, LED, 1)[0] == sdk.COMM_RX_TIMEOUT
    assert client.write1ByteTxRx(port, 2, LED, 1)[0] == sdk.COMM_RX_TIMEOUT
    assert [bus.servos[k].value("LED") for k in (1, 2)] == [1, 0]


def test_a_corrupt_reply_is_told_from_a_good_one(bus, client, port):
    bus.servos[1].corrupt_replies = 1
    assert client.ping(port, 1)[1] == sdk.COMM_RX_CORRUPT
    assert client.ping(port, 1)[1] == OK


def test_a_silent_bus_is_silent(bus, client, port):
    bus.silent = True
    assert client.ping(port, 1)[1] == sdk.COMM_RX_TIMEOUT
    bus.silent = False
    assert client.ping(port, 1)[1] == OK


# time on the wire


def test_bytes_take_their_time(make_arm, make_chain):
    chain = make_chain(2, baud=57_600, **{"Return Delay Time": 250})
    request = encode(1, Instruction.READ, read_params(0, 147))
    length = len(request) + 11 + 147
    with (
        VirtualBus(make_arm(2), chain) as bus,
        serial.Serial(bus.port, 57_600, timeout=1.0) as wire,
    ):
        begun = time.monotonic()
        wire.write(request)
        reply = wire.read(11 + 147)
        took = time.monotonic() - begun
    assert len(reply) == 11 + 147
    assert took >= length * 10 / 57_600 + 500e-6
    assert took < length * 10 / 57_600 + 0.05


def test_without_wire_time_they_do_not(bus):
    begun = time.monotonic()
    assert len(raw(bus, encode(1, Instruction.READ, read_params(0, 147)), want=158)) == 158
    assert time.monotonic() - begun < 0.05


# the bus itself


def test_an_idle_bus_costs_next_to_nothing(bus, client, port):
    client.write1ByteTxRx(port, 1, TORQUE, 1)
    assert until(lambda: bus.rig.asleep)
    begun, worked = time.monotonic(), time.process_time()
    time.sleep(0.3)
    assert time.process_time() - worked < 0.1 * (time.monotonic() - begun)


def test_leaving_closes_the_port_and_ends_the_thread(make_arm, make_chain):
    before = threading.active_count()
    with VirtualBus(make_arm(2), make_chain(2)) as bus:
        name = bus.port
        assert threading.active_count() == before + 1
    assert threading.active_count() == before
    assert not os.path.exists(name)  # noqa: PTH110 - the name of a device
    with pytest.raises(RuntimeError, match="within its with-block"):
        _ = bus.port


def test_it_can_be_opened_again(make_arm, make_chain):
    bus = VirtualBus(make_arm(2), make_chain(2))
    for _ in range(2):
        with bus:
            assert len(raw(bus, PING)) == 14


def test_a_clock_that_is_stepped_moves_the_servos(make_arm, make_chain):
    now = 0.0
    bus = VirtualBus(make_arm(2), make_chain(2), Q_START, clock=lambda: now)
    servo = bus.servos[1]
    servo.write(TORQUE, b"\x01")
    servo.write(GOAL, ticks(0.0).to_bytes(4, "little"))
    now = 2.0
    bus.advance()
    assert servo.now == pytest.approx(2.0, abs=1e-6)
    assert bus.q[0] == pytest.approx(0.0, abs=0.01)


def test_a_start_outside_the_limits_is_refused(make_arm, make_chain):
    with pytest.raises(LimitError, match="'j0'"):
        VirtualBus(make_arm(2), make_chain(2), (3.0, 0.0))


def test_an_arm_with_a_joint_that_no_servo_moves_is_refused(make_arm, make_chain):
    with pytest.raises(ValueError, match="no servo moves joint 'j2'"):
        VirtualBus(make_arm(3), make_chain(2))


def test_a_servo_of_another_arms_joint_is_refused(make_arm, make_chain):
    with pytest.raises(ValueError, match="servo 's2': arm 'arm' has no joint 'j2'"):
        VirtualBus(make_arm(2), make_chain(3))


def test_a_model_that_does_not_speak_protocol_1_is_refused_in_a_chain_that_does(make_arm):
    def chain(model: str) -> ServoChain:
        spec = ServoSpec(name="s", servo_id=1, model=model, role=ServoRole.LEADER, joint="j0")
        return ServoChain(servos=(spec,), baud=1_000_000, protocol=1.0)

    with pytest.raises(ValueError, match=r"XL330-M288 does not speak 1\.0"):
        VirtualBus(make_arm(1), chain("XL330-M288"))
    assert VirtualBus(make_arm(1), chain("XM430-W350")).servos[1].value("Protocol Type") == 1
