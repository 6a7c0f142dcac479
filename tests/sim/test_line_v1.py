"""Protocol 1.0 on the line, without a port and without time."""

import pytest

from splinearm.drivers.model import servo_model
from splinearm.drivers.packets import Instruction, Packet, read_params
from splinearm.drivers.packets_v1 import Decoder
from splinearm.sim.habit import LineHabits
from splinearm.sim.line import Line
from splinearm.sim.line_fault import FaultKind, LineFault, LineFaults
from splinearm.sim.virtual_servo import VirtualServo

BAUD = 1_000_000
ALL = 0xFE
AX_LED, AX_GOAL, AX_PRESENT, X_LED, X_GOAL = 25, 30, 36, 65, 116
RANGE, ANGLE, INSTRUCTION, CHECKSUM, OVERLOAD = 0x08, 0x02, 0x40, 0x10, 0x20


def servo_of(servo_id: int, model: str = "AX-12A", **settings: int) -> VirtualServo:
    named = {name.replace("_", " "): value for name, value in settings.items()}
    named["Baud Rate"] = servo_model(model).baud_code(BAUD)
    if model != "AX-12A":
        named["Protocol Type"] = named.get("Protocol Type", 1)
    return VirtualServo(servo_model(model), settings={"ID": servo_id, **named})


def ask(line: Line, servo_id: int, instruction: int, params: bytes = b"", **more) -> list[Packet]:
    """Send a packet and give the status packets that come back."""
    replies = line.answer(Packet(servo_id, instruction, params), BAUD, 1, **more)
    return Decoder(status=True).feed(b"".join(reply.data for reply in replies))


@pytest.fixture
def line() -> Line:
    """Give an AX-12A, an XM430 that speaks 1.0, and one that speaks 2.0."""
    return Line(
        [servo_of(1), servo_of(2, "XM430-W350"), servo_of(3, "XM430-W350", Protocol_Type=2)]
    )


def test_a_ping_is_answered_without_parameters(line):
    assert ask(line, 1, Instruction.PING) == [Packet(1, Instruction.STATUS)]
    assert ask(line, 2, Instruction.PING) == [Packet(2, Instruction.STATUS)]


def test_servos_hear_their_own_protocol_only(line):
    assert ask(line, 3, Instruction.PING) == []
    ping_2 = [line.answer(Packet(k, Instruction.PING), BAUD, 2) for k in (1, 2, 3)]
    assert [len(replies) for replies in ping_2] == [0, 0, 1]


def test_a_ping_to_all_is_of_use_with_one_servo_only(line):
    assert ask(Line([servo_of(7)]), ALL, Instruction.PING) == [Packet(7, Instruction.STATUS)]
    assert ask(line, ALL, Instruction.PING) != [Packet(1, Instruction.STATUS)]


def test_read_and_write(line):
    assert ask(line, 1, Instruction.WRITE, bytes((AX_GOAL, 0x10, 0x02)))[0].error == 0
    assert ask(line, 1, Instruction.READ, bytes((AX_GOAL, 2)))[0].params == b"\x10\x02"
    assert ask(line, 2, Instruction.WRITE, bytes((X_LED, 1)))[0].error == 0
    assert ask(line, 2, Instruction.READ, bytes((X_LED, 1)))[0].params == b"\x01"


@pytest.mark.parametrize(
    ("servo_id", "instruction", "params", "error"),
    [
        (1, Instruction.WRITE, bytes((AX_PRESENT, 0, 0)), RANGE),
        (1, Instruction.WRITE, bytes((AX_GOAL,)), RANGE),
        (1, Instruction.READ, b"\x00", RANGE),
        (2, Instruction.READ, b"\x00\xff", RANGE),
        (1, Instruction.REG_WRITE, b"", RANGE),
        (1, Instruction.ACTION, b"", INSTRUCTION),
        (1, Instruction.REBOOT, b"", INSTRUCTION),
        (1, 0x44, b"", INSTRUCTION),
        (2, Instruction.WRITE, bytes((X_GOAL, 0, 0x10, 0, 0)), ANGLE),
    ],
)
def test_what_is_refused_is_told_by_a_bit(line, servo_id, instruction, params, error):
    assert [p.error for p in ask(line, servo_id, instruction, params)] == [error]


def test_a_latched_fault_is_told_in_every_answer(line):
    line.servos[0].hardware_error(OVERLOAD)
    assert ask(line, 1, Instruction.PING)[0].error == OVERLOAD
    assert ask(line, 1, 0x44)[0].error == OVERLOAD | INSTRUCTION


def test_reg_write_waits_for_an_action(line):
    ask(line, 1, Instruction.REG_WRITE, bytes((AX_LED, 1)))
    assert line.servos[0].value("LED") == 0
    assert ask(line, ALL, Instruction.ACTION) == []
    assert line.servos[0].value("LED") == 1


def test_an_x_servo_knows_reboot(line):
    assert ask(line, 2, Instruction.REBOOT)[0].error == 0
    assert ask(line, 2, Instruction.PING) == []


@pytest.mark.parametrize(
    ("level", "pinged", "read", "wrote"), [(0, 1, 0, 0), (1, 1, 1, 0), (2, 1, 1, 1)]
)
def test_the_status_return_level_holds(level, pinged, read, wrote):
    line = Line([servo_of(1, Status_Return_Level=level)])
    assert len(ask(line, 1, Instruction.PING)) == pinged
    assert len(ask(line, 1, Instruction.READ, bytes((AX_LED, 1)))) == read
    assert len(ask(line, 1, Instruction.WRITE, bytes((AX_LED, 1)))) == wrote
    assert line.servos[0].value("LED") == 1


def test_a_sync_write_gives_each_its_own():
    line = Line([servo_of(k) for k in (1, 2, 3)])
    assert ask(line, ALL, Instruction.SYNC_WRITE, bytes((AX_LED, 1, 1, 1, 3, 1))) == []
    assert [servo.value("LED") for servo in line.servos] == [1, 0, 1]


@pytest.mark.parametrize(
    "params", [b"", bytes((AX_LED,)), bytes((AX_LED, 1, 1)), bytes((AX_LED, 0))]
)
def test_a_sync_write_that_makes_no_sense_is_ignored(params):
    line = Line([servo_of(1)])
    assert ask(line, ALL, Instruction.SYNC_WRITE, params) == []
    assert line.servos[0].value("LED") == 0


def bulk(*entries: tuple[int, int, int]) -> bytes:
    return b"\x00" + b"".join(bytes((length, servo_id, at)) for servo_id, at, length in entries)


@pytest.fixture
def xs() -> Line:
    return Line([servo_of(k, "XM430-W350") for k in (1, 2, 3)])


def test_a_bulk_read_is_answered_in_the_order_asked(xs):
    xs.servos[1].write(X_LED, b"\x01")
    got = ask(xs, ALL, Instruction.BULK_READ, bulk((3, 132, 4), (2, X_LED, 1)))
    assert [(p.servo_id, p.params) for p in got] == [(3, (2048).to_bytes(4, "little")), (2, b"\1")]


def test_a_bulk_read_ends_at_a_servo_that_is_missing_unless_switched(xs):
    xs.servos[1].unplugged = True
    params = bulk(*((k, X_LED, 1) for k in (1, 2, 3)))
    assert [p.servo_id for p in ask(xs, ALL, Instruction.BULK_READ, params)] == [1]
    xs.habits = LineHabits(bulk_read_1_ends=False)
    assert [p.servo_id for p in ask(xs, ALL, Instruction.BULK_READ, params)] == [1, 3]


def test_an_ax_knows_no_bulk_read_and_bulk_reads_without_sense_are_ignored(xs):
    assert ask(Line([servo_of(1)]), ALL, Instruction.BULK_READ, bulk((1, AX_LED, 1))) == []
    for params in (b"", b"\x00", b"\x01\x01\x01\x41", b"\x00\x01\x01"):
        assert ask(xs, ALL, Instruction.BULK_READ, params) == []


def test_a_factory_reset_takes_the_id_as_well():
    line = Line([servo_of(9)])
    assert ask(line, 9, Instruction.FACTORY_RESET) == [Packet(9, Instruction.STATUS)]
    assert line.servos[0].servo_id == 1


def test_a_damaged_packet_is_answered_if_so_switched(line):
    assert ask(line, 1, Instruction.PING, damaged=True) == []
    line.habits = LineHabits(answers_bad_crc=True)
    assert [p.error for p in ask(line, 1, Instruction.PING, damaged=True)] == [CHECKSUM]


def test_an_ax_takes_the_time_that_was_measured():
    line = Line([servo_of(1, Return_Delay_Time=0)])

    def delay(instruction: int, params: bytes = b"") -> float:
        (reply,) = line.answer(Packet(1, instruction, params), BAUD, 1)
        return reply.delay

    assert delay(Instruction.PING) == pytest.approx(18e-6)
    assert delay(Instruction.READ, bytes((AX_GOAL, 2))) == pytest.approx(22e-6)
    assert delay(Instruction.WRITE, bytes((AX_GOAL, 0, 1))) == pytest.approx(36e-6)
    line.habits = LineHabits(known_turn_around=False, turn_around=50e-6)
    assert delay(Instruction.PING) == pytest.approx(50e-6)


def test_a_fault_of_the_line_strikes_protocol_1_too(line):
    line.faults = LineFaults([LineFault(kind=FaultKind.LOST, times=1)], clock=lambda: 0.0)
    assert ask(line, 1, Instruction.WRITE, bytes((AX_LED, 1))) == []
    assert line.servos[0].value("LED") == 1
    assert len(ask(line, 1, Instruction.PING)) == 1


def test_a_packet_of_protocol_2_is_nothing_to_servos_of_protocol_1(line):
    assert line.answer(Packet(1, Instruction.READ, read_params(AX_LED, 1)), BAUD, 2) == []
