import os
import time

import pytest

from splinearm.drivers.bus import Loss, PingReply
from splinearm.drivers.cyclic import GroupRead, GroupWrite
from splinearm.drivers.dynamixel import DynamixelBus, scan
from splinearm.drivers.groups import BulkRead
from splinearm.drivers.model import servo_model
from splinearm.drivers.packets import Instruction
from splinearm.errors import BusTimeoutError, PacketError, PortError, ServoError

pytestmark = pytest.mark.bus

TABLE = servo_model("XM430-W350").table
GOAL, POSITION, TORQUE = TABLE["Goal Position"], TABLE["Present Position"], TABLE["Torque Enable"]
MARGIN = 0.15  # a busy machine may let a pty wait


@pytest.fixture
def bus(line):
    with DynamixelBus(line.port, margin=MARGIN) as opened:
        yield opened


def read_group(*ids: int, fast: bool) -> GroupRead:
    return GroupRead([BulkRead(i, POSITION.address, 4) for i in ids], fast=fast)


def test_a_servo_says_what_it_is(bus):
    assert bus.ping(1) == PingReply(1, 1020, 46)
    assert bus.ping(4) == PingReply(4, 1060, 46)


def test_a_scan_finds_everyone_and_ends_when_the_bus_is_quiet(bus):
    begun = time.monotonic()
    assert [reply.servo_id for reply in bus.scan()] == [1, 2, 3, 4]
    assert time.monotonic() - begun < 0.7  # the SDK waits 0.81 s for ids that are not there


def test_registers_are_read_and_written(bus, line):
    bus.write(1, GOAL, -131073)  # its bytes need stuffing, which the SDK does not do
    assert line.servos[1]["Goal Position"] == -131073
    assert bus.read(1, GOAL) == -131073
    assert line.decoder.noise_bytes == 0


def test_a_refusal_says_what_and_why(bus):
    with pytest.raises(ServoError, match=r"Model Number = 7 refused: .*access error") as caught:
        bus.write(1, TABLE["Model Number"], 7)
    assert (caught.value.servo_id, caught.value.code) == (1, 7)


def test_a_value_that_a_register_cannot_hold_never_leaves(bus, line):
    before = len(line.instructions)
    with pytest.raises(ValueError, match="Torque Enable"):
        bus.write(1, TORQUE, 256)
    assert len(line.instructions) == before


@pytest.mark.parametrize("ask", ["ping", "read", "write"])
def test_a_silent_servo_is_named(line, ask):
    line.silent.add(2)
    with DynamixelBus(line.port, margin=0.01) as bus:
        calls = {
            "ping": lambda: bus.ping(2),
            "read": lambda: bus.read(2, POSITION),
            "write": lambda: bus.write(2, GOAL, 2048),
        }
        with pytest.raises(BusTimeoutError, match="servo 2 does not answer") as caught:
            calls[ask]()
    assert caught.value.servo_id == 2
    assert caught.value.port == line.port


def test_a_damaged_answer_is_told_as_such(bus, line):
    line.damaged.add(2)
    with pytest.raises(PacketError, match="servo 2"):
        bus.read(2, POSITION)


@pytest.mark.parametrize("fast", [False, True])
def test_a_sync_read_gets_everyone(bus, line, fast):
    line.servos[2]["Present Position"] = -131073
    replies = bus.sync_read(read_group(1, 2, 4, fast=fast))
    assert {i: POSITION.decode(reply.data) for i, reply in replies.items()} == {
        1: 2048,
        2: -131073,
        4: 2048,
    }
    wanted = Instruction.FAST_SYNC_READ if fast else Instruction.SYNC_READ
    assert line.instructions == [wanted]


@pytest.mark.parametrize("dead", [1, 2, 4])
@pytest.mark.parametrize("fast", [False, True])
def test_one_dead_servo_blinds_the_others_for_one_read_at_most(line, dead, fast):
    line.silent.add(dead)
    group = read_group(1, 2, 4, fast=fast)
    with DynamixelBus(line.port, margin=0.03) as bus:
        for _ in range(3):  # a fast read that leaves it open, a plain one, and again a fast one
            replies = bus.sync_read(group)
    assert {i: reply.loss for i, reply in replies.items()} == {
        i: Loss.SILENT if i == dead else None for i in (1, 2, 4)
    }
    assert group.fast is fast


def test_an_alert_comes_with_the_data(bus, line):
    line.servos[2]["Hardware Error Status"] = 0x20
    replies = bus.sync_read(read_group(1, 2, fast=False))
    assert [replies[i].error for i in (1, 2)] == [0, 0x80]
    assert replies[2].loss is None


def test_noise_and_echo_do_no_harm(bus, line):
    line.noise = b"\xff\xff\xfd\x00\x01\xff\x00"
    assert bus.sync_read(read_group(1, 2, fast=False))[2].loss is None
    line.noise, line.echoes = b"", True
    assert bus.sync_read(read_group(1, 2, fast=True))[2].loss is None
    bus.write(1, GOAL, 100)
    assert line.servos[1]["Goal Position"] == 100


def test_an_answer_that_came_too_late_is_not_taken_for_the_next(bus, line):
    group = read_group(1, fast=False)
    bus.sync_read(group)
    bus._link.send(group.request)  # nobody waits for its answer
    deadline = time.monotonic() + 5.0
    while line.asked[1] < 2 and time.monotonic() < deadline:
        time.sleep(0.001)
    line.servos[1]["Present Position"] = 77
    assert POSITION.decode(bus.sync_read(group)[1].data) == 77


def test_a_sync_write_reaches_everyone(bus, line):
    bus.sync_write(GroupWrite([(1, GOAL), (4, GOAL)]), [11, 22])
    bus.ping(1)  # answered after the write was taken
    assert line.written("Goal Position") == [(1, 11), (4, 22)]


def test_a_reboot_clears_a_latched_error(bus, line):
    line.servos[1]["Hardware Error Status"] = 0x20
    bus.reboot(1)
    assert line.servos[1]["Hardware Error Status"] == 0


def test_a_factory_reset_keeps_id_and_rate_unless_told(bus, line):
    bus.factory_reset(1)
    assert line.instructions == [Instruction.FACTORY_RESET]
    with pytest.raises(ValueError, match="keep_baud"):
        bus.factory_reset(1, keep_id=False)


def test_a_port_in_use_and_a_missing_port_are_refused(bus):
    with pytest.raises(PortError, match="another program uses it"):
        DynamixelBus(bus.port)
    with pytest.raises(PortError, match="no such port"):
        DynamixelBus("/dev/no_such_port")


def test_a_rate_that_servos_do_not_have_is_refused_and_the_port_set_free(line):
    with pytest.raises(PortError, match="no servo speaks at 12345 baud; choose one of 9600"):
        DynamixelBus(line.port, 12_345)
    with pytest.raises(PortError, match="no servo speaks at 0 baud"):
        DynamixelBus("unix:nobody", 0)
    with DynamixelBus(line.port, 4_500_000) as bus:  # not in the SDK's list
        assert bus.baud == 4_500_000
    with pytest.raises(ValueError, match="margin"):
        DynamixelBus(line.port, margin=0.0)


def test_a_port_that_hangs_up_is_told(bus, line):
    line.vanish()
    with pytest.raises(PortError, match="connection is lost"):
        bus.sync_read(read_group(1, fast=False))
    with pytest.raises(PortError, match="connection is lost"):
        bus.ping(1)


def test_a_closed_bus_touches_no_other_file(bus, tmp_path):
    bus.close()
    bus.close()
    path = tmp_path / "other"
    fds = [os.open(path, os.O_RDWR | os.O_CREAT) for _ in range(8)]  # they get the freed numbers
    try:
        with pytest.raises(PortError, match="connection is lost"):
            bus.sync_write(GroupWrite([(1, GOAL)]), [0])
        with pytest.raises(PortError):
            bus.ping(1)
    finally:
        for fd in fds:
            os.close(fd)
    assert path.read_bytes() == b""


def test_scan_gives_id_model_firmware_and_rate(line):
    found = scan(line.port, (1_000_000,))
    assert [(s.servo_id, s.model, s.firmware, s.baud) for s in found] == [
        (1, "XM430-W350", 46, 1_000_000),
        (2, "XM430-W350", 46, 1_000_000),
        (3, "XM430-W350", 46, 1_000_000),
        (4, "XL430-W250", 46, 1_000_000),
    ]


def test_scan_names_a_model_that_it_does_not_know(line):
    line.servos[1]["Model Number"] = 4711
    assert scan(line.port, (1_000_000,))[0].model == "unknown (4711)"
