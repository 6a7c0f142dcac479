"""Which servos obey a packet and who answers, without a port and without time."""

import pytest

from splinearm.drivers.model import servo_model
from splinearm.drivers.packets import (
    BulkRead,
    BulkWrite,
    Decoder,
    Instruction,
    Packet,
    bulk_read_params,
    bulk_write_params,
    parse_fast_reply,
    read_params,
    sync_read_params,
    sync_write_params,
    write_params,
)
from splinearm.sim.habit import LineHabits
from splinearm.sim.line import Line
from splinearm.sim.line_fault import LineFault, LineFaults
from splinearm.sim.virtual_servo import VirtualServo

BAUD = 57_600
ALL = 0xFE
LED, GOAL, PRESENT = 65, 116, 132


def servo_of(servo_id: int, model: str = "XM430-W350", **settings: int) -> VirtualServo:
    named = {name.replace("_", " "): value for name, value in settings.items()}
    return VirtualServo(servo_model(model), settings={"ID": servo_id, **named})


def ask(line: Line, servo_id: int, instruction: int, params: bytes = b"") -> list[Packet]:
    """Send a packet and give the status packets that come back."""
    replies = line.answer(Packet(servo_id, instruction, params), BAUD)
    return Decoder().feed(b"".join(reply.data for reply in replies))


@pytest.fixture
def line() -> Line:
    return Line([servo_of(1), servo_of(2, "XL430-W250"), servo_of(3)])


def test_a_ping_tells_model_and_firmware(line):
    assert ask(line, 2, Instruction.PING) == [
        Packet(2, Instruction.STATUS, (1060).to_bytes(2, "little") + b"\x35")
    ]


def test_a_ping_to_all_is_answered_in_the_order_of_ids():
    line = Line([servo_of(9), servo_of(2), servo_of(5)])
    assert [p.servo_id for p in ask(line, ALL, Instruction.PING)] == [2, 5, 9]


def test_nobody_answers_for_an_id_that_is_not_there(line):
    assert ask(line, 7, Instruction.PING) == []


def test_an_unknown_instruction_is_an_instruction_error(line):
    (status,) = ask(line, 1, 0x44)
    assert status.error_number == 2


@pytest.mark.parametrize("instruction", [Instruction.READ, Instruction.WRITE])
def test_parameters_that_are_too_few_are_a_length_error(line, instruction):
    (status,) = ask(line, 1, instruction, b"\x40")
    assert status.error_number == 5


def test_a_write_to_all_is_obeyed_and_not_answered(line):
    assert ask(line, ALL, Instruction.WRITE, write_params(LED, b"\x01")) == []
    assert [servo.value("LED") for servo in line.servos] == [1, 1, 1]


def test_a_read_of_all_is_not_answered(line):
    assert ask(line, ALL, Instruction.READ, read_params(LED, 1)) == []


@pytest.mark.parametrize(
    ("level", "pinged", "read", "written"), [(0, 1, 0, 0), (1, 1, 1, 0), (2, 1, 1, 1)]
)
def test_the_status_return_level_says_what_is_answered(level, pinged, read, written):
    line = Line([servo_of(1, Status_Return_Level=level)])
    assert len(ask(line, 1, Instruction.PING)) == pinged
    assert len(ask(line, 1, Instruction.READ, read_params(LED, 1))) == read
    assert len(ask(line, 1, Instruction.WRITE, write_params(LED, b"\x01"))) == written
    assert len(ask(line, ALL, Instruction.SYNC_READ, sync_read_params(LED, 1, [1]))) == read
    assert line.servos[0].value("LED") == 1


def test_an_answer_waits_for_the_return_delay_time():
    line = Line([servo_of(1, Return_Delay_Time=100)])
    (reply,) = line.answer(Packet(1, Instruction.PING), BAUD)
    assert reply.delay == pytest.approx(200e-6)


def test_at_another_baud_rate_nobody_hears(line):
    assert line.answer(Packet(1, Instruction.PING), 1_000_000) == []
    line.answer(Packet(ALL, Instruction.WRITE, write_params(LED, b"\x01")), 1_000_000)
    assert line.servos[0].value("LED") == 0


def test_a_servo_answers_a_change_of_its_id_under_the_old_one(line):
    (status,) = ask(line, 1, Instruction.WRITE, write_params(7, b"\x0b"))
    assert status.servo_id == 1
    assert ask(line, 11, Instruction.PING)[0].servo_id == 11


# groups


def test_a_sync_write_gives_each_its_own(line):
    params = sync_write_params(LED, 1, {1: b"\x01", 3: b"\x01"})
    assert ask(line, ALL, Instruction.SYNC_WRITE, params) == []
    assert [servo.value("LED") for servo in line.servos] == [1, 0, 1]


def test_a_sync_read_is_answered_in_the_order_asked(line):
    packets = ask(line, ALL, Instruction.SYNC_READ, sync_read_params(PRESENT, 4, [3, 1, 2]))
    assert [p.servo_id for p in packets] == [3, 1, 2]
    assert {p.params for p in packets} == {(2048).to_bytes(4, "little")}


def test_in_a_sync_read_the_others_answer_if_one_is_missing(line):
    line.servos[1].unplugged = True
    packets = ask(line, ALL, Instruction.SYNC_READ, sync_read_params(PRESENT, 4, [1, 2, 3]))
    assert [p.servo_id for p in packets] == [1, 3]


def test_a_bulk_write_and_a_bulk_read_go_where_each_says(line):
    writes = [BulkWrite(1, LED, b"\x01"), BulkWrite(2, GOAL, (99).to_bytes(4, "little"))]
    assert ask(line, ALL, Instruction.BULK_WRITE, bulk_write_params(writes)) == []
    reads = bulk_read_params([BulkRead(2, GOAL, 4), BulkRead(1, LED, 1)])
    packets = ask(line, ALL, Instruction.BULK_READ, reads)
    assert [(p.servo_id, p.params) for p in packets] == [
        (2, (99).to_bytes(4, "little")),
        (1, b"\x01"),
    ]


def fast(line: Line, ids: list[int], length: int = 4) -> tuple[bytes, list]:
    """Give the answer to a fast sync read and what a client may trust of it."""
    packet = Packet(ALL, Instruction.FAST_SYNC_READ, sync_read_params(PRESENT, length, ids))
    frame = b"".join(reply.data for reply in line.answer(packet, BAUD))
    blocks = parse_fast_reply(frame, [(servo_id, length) for servo_id in ids])
    return frame, [(block.servo_id, block.error) for block in blocks]


def test_a_fast_sync_read_is_one_packet_of_all(line):
    frame, blocks = fast(line, [3, 1, 2])
    assert blocks == [(3, 0), (1, 0), (2, 0)]
    (packet,) = Decoder().feed(frame)
    assert packet.servo_id == ALL


def test_a_fast_sync_read_tells_errors_and_alerts_of_each(line):
    line.servos[1].hardware_error(0x01)
    _, blocks = fast(line, [1, 2, 3])
    assert blocks == [(1, 0), (2, 0x80), (3, 0)]


def test_what_a_fast_sync_read_cannot_read_keeps_its_place(line):
    packet = Packet(ALL, Instruction.FAST_SYNC_READ, sync_read_params(66, 2, [1, 2]))
    frame = b"".join(reply.data for reply in line.answer(packet, BAUD))
    blocks = parse_fast_reply(frame, [(1, 2), (2, 2)])
    assert [(b.error, b.data) for b in blocks] == [(7, b"\0\0"), (7, b"\0\0")]


@pytest.mark.parametrize(("missing", "trusted"), [(1, []), (2, [(1, 0)]), (3, [(1, 0), (2, 0)])])
def test_a_fast_sync_read_ends_before_the_first_that_is_missing(line, missing, trusted):
    line.servos[missing - 1].unplugged = True
    frame, blocks = fast(line, [1, 2, 3])
    assert blocks == trusted
    assert len(frame) == (8 + 8 * len(trusted) if trusted else 0)


def test_a_fast_bulk_read_is_one_packet_of_all(line):
    reads = bulk_read_params([BulkRead(2, PRESENT, 4), BulkRead(1, LED, 1)])
    replies = line.answer(Packet(ALL, Instruction.FAST_BULK_READ, reads), BAUD)
    frame = b"".join(reply.data for reply in replies)
    blocks = parse_fast_reply(frame, [(2, 4), (1, 1)])
    assert [b.data for b in blocks] == [(2048).to_bytes(4, "little"), b"\0"]


def test_firmware_that_knows_no_fast_reads_is_missing_in_them():
    old = VirtualServo(servo_model("XM430-W350"), settings={"ID": 2}, firmware=44)
    _, blocks = fast(Line([servo_of(1), old]), [1, 2])
    assert blocks == [(1, 0)]


def test_a_group_instruction_that_makes_no_sense_is_ignored(line):
    assert ask(line, ALL, Instruction.SYNC_WRITE, b"\x41\x00\x04\x00\x01") == []
    assert ask(line, ALL, Instruction.BULK_READ, b"\x01") == []


# shadows


@pytest.fixture
def pair() -> Line:
    shadow = VirtualServo(servo_model("XM430-W350"), settings={"ID": 2, "Secondary(Shadow) ID": 1})
    return Line([servo_of(1), shadow])


def test_a_shadow_obeys_its_leaders_id_in_silence(pair):
    assert len(ask(pair, 1, Instruction.WRITE, write_params(LED, b"\x01"))) == 1
    assert [servo.value("LED") for servo in pair.servos] == [1, 1]


def test_a_shadow_obeys_sync_writes_to_its_leader(pair):
    params = sync_write_params(GOAL, 4, {1: (1234).to_bytes(4, "little")})
    ask(pair, ALL, Instruction.SYNC_WRITE, params)
    assert [servo.value("Goal Position") for servo in pair.servos] == [1234, 1234]


def test_a_shadows_eeprom_is_not_that_of_its_leader(pair):
    ask(pair, 1, Instruction.WRITE, write_params(10, b"\x04"))
    assert [servo.value("Drive Mode") for servo in pair.servos] == [4, 0]
    ask(pair, 1, Instruction.FACTORY_RESET, b"\x01")
    assert pair.servos[1].secondary_id == 1


def test_a_shadow_answers_to_its_own_id_and_not_to_reads_of_its_leader(pair):
    assert [p.servo_id for p in ask(pair, 2, Instruction.PING)] == [2]
    assert [p.servo_id for p in ask(pair, 1, Instruction.PING)] == [1]
    assert len(ask(pair, 1, Instruction.READ, read_params(LED, 1))) == 1


# faults


def test_a_mute_servo_obeys_and_an_unplugged_one_does_not(line):
    mute, unplugged, _ = line.servos
    mute.mute, unplugged.unplugged = True, True
    for servo_id in (1, 2):
        assert ask(line, servo_id, Instruction.WRITE, write_params(LED, b"\x01")) == []
    assert [servo.value("LED") for servo in (mute, unplugged)] == [1, 0]


def test_corrupt_replies_are_as_many_as_asked_for(line):
    line.servos[0].corrupt_replies = 2
    assert [len(ask(line, 1, Instruction.PING)) for _ in range(4)] == [0, 0, 1, 1]


def test_a_corrupt_piece_of_a_fast_read_is_told_from_the_good_ones(line):
    line.servos[1].corrupt_replies = 1
    assert 2 not in [servo_id for servo_id, _ in fast(line, [1, 2, 3])[1]]
    assert fast(line, [1, 2, 3])[1] == [(1, 0), (2, 0), (3, 0)]


def test_a_silent_line_hears_nothing(line):
    line.silent = True
    assert ask(line, 1, Instruction.WRITE, write_params(LED, b"\x01")) == []
    assert line.servos[0].value("LED") == 0


def test_two_servos_of_one_id_pull_the_line_low_together():
    same = Line([servo_of(1), servo_of(1)])
    assert len(ask(same, 1, Instruction.PING)) == 1
    different = Line([servo_of(1), servo_of(1, "XL430-W250")])
    assert ask(different, 1, Instruction.PING) == []


def test_a_status_packet_on_the_bus_moves_nobody(line):
    assert line.answer(Packet(1, Instruction.STATUS), BAUD) == []


def test_every_packet_feeds_every_watchdog(line):
    line.servos[2].write(98, b"\x01")
    line.servos[2].write(64, b"\x01")
    for k in range(100):
        for servo in line.servos:
            servo.watch(0.01 * k)
        ask(line, 1, Instruction.PING)
    assert not line.servos[2].tripped
    line.servos[2].watch(2.0)
    assert line.servos[2].tripped


# faults and habits


def set_faults(line: Line, *words: str) -> None:
    line.faults = LineFaults([LineFault.parse(text) for text in words], clock=lambda: 0.0)


def test_a_lost_reply_is_that_of_a_servo_that_obeyed(line):
    set_faults(line, "lost id=1 n=1")
    assert ask(line, 1, Instruction.WRITE, write_params(LED, b"\x01")) == []
    assert line.servos[0].value("LED") == 1
    assert len(ask(line, 1, Instruction.PING)) == 1


def test_a_dead_servo_neither_hears_nor_answers(line):
    set_faults(line, "dead id=1")
    assert ask(line, 1, Instruction.WRITE, write_params(LED, b"\x01")) == []
    assert line.servos[0].value("LED") == 0
    assert len(ask(line, 2, Instruction.PING)) == 1
    set_faults(line, "dead")
    assert ask(line, ALL, Instruction.PING) == []


@pytest.mark.parametrize("what", ["lost", "dead", "truncated"])
@pytest.mark.parametrize("missing", [1, 2, 3])
def test_a_fast_read_ends_where_a_servo_is_lost(line, what, missing):
    set_faults(line, f"{what} id={missing}")
    assert [servo_id for servo_id, _ in fast(line, [1, 2, 3])[1]] == list(range(1, missing))


@pytest.mark.parametrize("what", ["corrupt", "garbled", "truncated"])
def test_a_damaged_reply_is_no_packet(line, what):
    set_faults(line, f"{what} id=1")
    assert ask(line, 1, Instruction.PING) == []


def test_a_doubled_reply_comes_twice_and_noise_before_it_is_skipped(line):
    set_faults(line, "doubled id=1", "noise id=1 size=9")
    first, second = ask(line, 1, Instruction.PING)
    assert first == second


def test_a_late_reply_is_late(line):
    set_faults(line, "late id=1 by=0.02")
    ((_, delay),) = line.answer(Packet(1, Instruction.PING), BAUD)
    assert delay == pytest.approx(0.02 + 250 * 2e-6)


def test_a_sync_read_ends_at_a_missing_servo_if_so_switched(line):
    line.habits = LineHabits(sync_read_ends=True)
    line.servos[1].unplugged = True
    packets = ask(line, ALL, Instruction.SYNC_READ, sync_read_params(PRESENT, 4, [1, 2, 3]))
    assert [p.servo_id for p in packets] == [1]


def test_servos_stick_after_a_fast_read_without_its_first_servo_if_so_switched(line):
    line.habits = LineHabits(stuck_time=0.1)
    line.servos[0].unplugged = True
    assert fast(line, [1, 2])[1] == []
    assert ask(line, 2, Instruction.PING) == []
    assert len(ask(line, 3, Instruction.PING)) == 1
    for servo in line.servos:
        servo.watch(servo.now + 0.2)
    assert len(ask(line, 2, Instruction.PING)) == 1
    assert fast(line, [2, 1])[1] == [(2, 0)]
    assert len(ask(line, 2, Instruction.PING)) == 1
    assert ask(line, ALL, Instruction.FAST_SYNC_READ, b"\x01") == []


def test_a_damaged_packet_is_answered_with_its_error_if_so_switched(line):
    damaged = Packet(1, 0)
    assert line.answer(damaged, BAUD, damaged=True) == []
    line.habits = LineHabits(answers_bad_crc=True)
    (reply,) = line.answer(damaged, BAUD, damaged=True)
    assert [p.error for p in Decoder().feed(reply.data)] == [3]


def test_a_wrong_baud_rate_is_answered_by_silence_or_noise(line):
    ping = Packet(1, Instruction.PING)
    assert line.answer(ping, 9600) == []
    line.habits = LineHabits(noise_at_wrong_baud=True)
    (reply,) = line.answer(ping, 9600)
    assert Decoder().feed(reply.data) == []
    assert line.answer(Packet(9, Instruction.PING), 9600) == []


def test_servos_answer_no_sooner_than_they_can(line):
    line.habits = LineHabits(turn_around=30e-6)
    line.servos[0].memory["Return Delay Time"] = 0
    delays = [line.answer(Packet(k, Instruction.PING), BAUD)[0].delay for k in (1, 2)]
    assert delays == [pytest.approx(30e-6), pytest.approx(500e-6)]
