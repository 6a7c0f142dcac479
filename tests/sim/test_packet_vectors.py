"""The packets that the maker prints hold on the virtual servos, byte for byte."""

import json
from collections.abc import Callable
from math import tau
from pathlib import Path

import pytest

from splinearm.drivers.model import servo_model
from splinearm.sim.ear import Ear
from splinearm.sim.line import Line
from splinearm.sim.virtual_servo import BOOT_TIME, VirtualServo

FILE = Path(__file__).parents[1] / "data" / "dynamixel_packets.json"
PRINTED = json.loads(FILE.read_text(encoding="utf-8"))["vectors"]
VECTORS = {vector["name"]: vector for vector in PRINTED if vector["protocol"] == 2}
VECTORS_1 = {vector["name"]: vector for vector in PRINTED if vector["protocol"] == 1}
CLEARS_ERRORS = "clear errors (Y series)"
"""No servo of that series is simulated."""


def servo(servo_id: int = 1, model: str = "XM430-W210", firmware: int = 53, **settings: int):
    named = {name.replace("_", " "): value for name, value in settings.items()}
    return VirtualServo(
        servo_model(model), settings={"ID": servo_id, **named}, zero_ticks=0, firmware=firmware
    )


def at(position: int, *args, **options) -> VirtualServo:
    """Give a servo at a position."""
    made = servo(*args, **options)
    made.shaft.angle = position / 4096 * tau
    return made


def registered() -> Line:
    made = servo()
    made.reg_write(104, (200).to_bytes(4, "little"))
    return Line([made])


def torque_on() -> Line:
    made = servo()
    made.write(64, b"\x01")
    return Line([made])


def backed_up() -> Line:
    made = servo()
    made.backup(b"\x01CTRL")
    return Line([made])


def tripped() -> Line:
    made = servo()
    made.write(64, b"\x01")
    made.write(98, b"\x01")
    made.watch(0.1)
    return Line([made])


def overloaded() -> Line:
    made = servo()
    made.hardware_error(0x20)
    return Line([made])


def warm() -> Line:
    first, second = servo(1), servo(2)
    first.voltage, second.temperature = 11.9, 36.0
    return Line([first, second])


def three_of_fast_bulk() -> Line:
    """Give servos that read a position, a PWM and a temperature."""
    driven = servo(7, Operating_Mode=16)
    driven.write(64, b"\x01")
    driven.write(100, (0x1A5).to_bytes(2, "little"))
    driven.tick(0.001)
    warm = servo(4)
    warm.temperature = 31.0
    return Line([at(166, 3), driven, warm])


def pointing() -> Line:
    """Give servos whose Indirect Data 1 to 8 are goal velocity and goal position."""
    made = []
    for servo_id in (1, 2):
        one = servo(servo_id)
        for k in range(8):
            one.memory[f"Indirect Address {k + 1}"] = (104 + k) if k < 4 else (112 + k)
        made.append(one)
    return Line(made)


def one(**settings: int) -> Callable[[], Line]:
    return lambda: Line([servo(**settings)])


SET_UPS: dict[str, Callable[[], Line]] = {
    "ping id 1": one(firmware=38),
    "ping broadcast": lambda: Line([servo(1, firmware=38), servo(2, firmware=38)]),
    "read present position id 1": lambda: Line([at(166)]),
    "action id 1": registered,
    "control table restore id 1": backed_up,
    "sync read present position ids 1 2": lambda: Line([at(166, 1), at(2079, 2)]),
    "sync write goal position ids 1 2": lambda: Line([servo(1), servo(2)]),
    "fast sync read present position ids 3 7 4": lambda: Line(
        [at(166, 3), at(2079, 7), at(1023, 4)]
    ),
    "bulk read id 1 voltage, id 2 temperature": warm,
    "bulk write id 1 max voltage, id 2 temperature limit": lambda: Line([servo(1), servo(2)]),
    "fast bulk read ids 3 7 4": three_of_fast_bulk,
    "read two bytes at 0, id 1 (CRC page)": one(),
    "stuffed write: extended goal position -131073": one(Operating_Mode=4),
    "stuffed sync write: goal velocity -1 then goal position low byte FD": pointing,
    "stuffed status: present position -131073": lambda: Line([at(-131073, Operating_Mode=4)]),
    "status error: EEPROM write with torque on": torque_on,
    "status error: goal write while Bus Watchdog tripped": tripped,
    "status alert bit after a hardware error": overloaded,
}
"""The line on which a packet is sent; where none is named, one servo as it comes."""

AFTERWARDS: dict[str, Callable[[Line], bool]] = {
    "write goal position id 1": lambda line: line.servos[0].value("Goal Position") == 512,
    "action id 1": lambda line: line.servos[0].value("Goal Velocity") == 200,
    "sync write goal position ids 1 2": lambda line: (
        [s.value("Goal Position") for s in line.servos] == [150, 170]
    ),
    "bulk write id 1 max voltage, id 2 temperature limit": lambda line: (
        line.servos[0].value("Max Voltage Limit") == 160
        and line.servos[1].value("Temperature Limit") == 80
    ),
    "stuffed write: extended goal position -131073": lambda line: (
        line.servos[0].value("Goal Position") == -131073
    ),
    "stuffed sync write: goal velocity -1 then goal position low byte FD": lambda line: (
        [s.value("Goal Velocity") for s in line.servos] == [-1, -1]
        and [s.value("Goal Position") for s in line.servos] == [0x7FD, 0x6FD]
    ),
    "reboot id 1": lambda line: not line.servos[0].listens(57_600),
    "indirect set-up: Indirect Address 2..5 = 116..119": lambda line: (
        [line.servos[0].value(f"Indirect Address {k}") for k in (2, 3, 4, 5)]
        == [116, 117, 118, 119]
    ),
}
"""What the packet must have done, beyond its answer."""


def said(line: Line, request: str, baud: int) -> list[str]:
    """Give the bytes of the packets that answer the bytes of one."""
    (heard,) = Ear().feed(bytes.fromhex(request))
    replies = line.answer(heard.packet, baud, heard.protocol)
    return [reply.data.hex(" ").upper() for reply in replies]


@pytest.mark.parametrize("name", [name for name in VECTORS if name != CLEARS_ERRORS])
def test_a_printed_packet_is_answered_as_printed(name):
    vector = VECTORS[name]
    line = SET_UPS.get(name, one())()
    for each in line.servos:
        each.memory["Min Position Limit"], each.memory["Max Position Limit"] = 0, 4095
        each.watch(each.now + BOOT_TIME)  # they have long been switched on
    answers = said(line, vector["tx"], 57_600)
    if name == "read two bytes at 0, id 1 (CRC page)":  # printed without an answer
        assert len(answers) == 1
    else:
        assert answers == vector["rx"]
    assert AFTERWARDS.get(name, lambda _: True)(line)


def test_the_set_ups_are_for_packets_that_are_printed():
    assert set(SET_UPS) | set(AFTERWARDS) <= set(VECTORS)
    assert len(VECTORS) + len(VECTORS_1) == 42


# Protocol 1.0


def ax(servo_id: int = 1, **settings: int) -> VirtualServo:
    return servo(servo_id, "AX-12A", firmware=24, **settings)


def hot_ax() -> Line:
    made = ax()
    made.temperature = 32.0
    return Line([made])


def registered_ax() -> Line:
    made = ax()
    made.reg_write(30, (500).to_bytes(2, "little"))
    return Line([made])


def speaking_1(servo_id: int = 1) -> Line:
    return Line([servo(servo_id, Protocol_Type=1)])


def bulk_pair() -> Line:
    """Give servos that hold the 0x8000 that the manual reads, where it reads it."""
    first, second = servo(1, Protocol_Type=1), servo(2, Protocol_Type=1)
    first.memory["Temperature Limit"] = 0x80
    second.memory["PWM Limit"] = 0x8000
    return Line([first, second])


SET_UPS_1: dict[str, Callable[[], Line]] = {
    "read present temperature id 1": hot_ax,
    "write id broadcast": lambda: Line([ax(7)]),
    "action broadcast": registered_ax,
    "factory reset id 0": lambda: Line([ax(0)]),
    "reboot id 1": speaking_1,
    "sync write goal position+speed ids 0 1": lambda: Line([ax(0), ax(1)]),
    "bulk read ids 1 2": bulk_pair,
}

AFTERWARDS_1: dict[str, Callable[[Line], bool]] = {
    "write id broadcast": lambda line: line.servos[0].servo_id == 1,
    "reg write goal position id 1": lambda line: line.servos[0].value("Registered") == 1,
    "action broadcast": lambda line: line.servos[0].value("Goal Position") == 500,
    "factory reset id 0": lambda line: line.servos[0].servo_id == 1,
    "reboot id 1": lambda line: not line.servos[0].listens(57_600),
    "sync write goal position+speed ids 0 1": lambda line: (
        [(s.value("Goal Position"), s.value("Moving Speed")) for s in line.servos]
        == [(0x010, 0x150), (0x220, 0x360)]
    ),
}

ERROR_PRINTED = "status error overload+overheat"


@pytest.mark.parametrize("name", [name for name in VECTORS_1 if name != ERROR_PRINTED])
def test_a_printed_packet_of_protocol_1_is_answered_as_printed(name):
    vector = VECTORS_1[name]
    line = SET_UPS_1.get(name, lambda: Line([ax()]))()
    for each in line.servos:
        each.watch(each.now + BOOT_TIME)
    answers = said(line, vector["tx"], line.servos[0].baud)
    if name == "checksum example":  # printed without an answer
        assert len(answers) == 1
    else:
        assert answers == vector["rx"]
    assert AFTERWARDS_1.get(name, lambda _: True)(line)


def test_the_printed_error_byte_is_that_of_an_overloaded_hot_servo():
    line = Line([ax()])
    line.servos[0].hardware_error(0x24)
    (ping,) = (v for v in VECTORS_1.values() if v["name"] == "ping id 1")
    assert said(line, ping["tx"], 1_000_000) == VECTORS_1[ERROR_PRINTED]["rx"]


def test_the_set_ups_of_protocol_1_are_for_packets_that_are_printed():
    assert set(SET_UPS_1) | set(AFTERWARDS_1) <= set(VECTORS_1)
