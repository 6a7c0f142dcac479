import logging
import time

import numpy as np
import pytest

from splinearm.drivers.chain import ServoChain, ServoRole, ServoSpec
from splinearm.drivers.crew import Crew
from splinearm.drivers.dialect import protocols_of
from splinearm.drivers.dynamixel import DynamixelBus
from splinearm.drivers.exchange import Exchange
from splinearm.drivers.packets import Instruction
from splinearm.drivers.scaling import JointScale
from splinearm.errors import BusTimeoutError, PacketError, ServoError
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.dh import DHConvention, DHLink
from splinearm.sim.habit import LineHabits
from splinearm.sim.line_fault import LineFault
from splinearm.sim.virtual_bus import VirtualBus

pytestmark = pytest.mark.bus

TICK = 2 * np.pi / 4096
MARGIN = 0.15
SHORT = 0.02
JOINTS = ("waist", "shoulder", "elbow")
XM, XL, PH, MX = "XM430-W350", "XL430-W250", "PH42-020-S300", "MX-28-2"
EXTRAS = {"velocity": "Goal Velocity", "current": "Goal Current"}
ONE_EACH = [Instruction.SYNC_WRITE, Instruction.FAST_SYNC_READ]
ZEROS = {"XL320": 512, "AX-12A": 512, PH: 0}


def exchange(bus, chain: ServoChain, joints=JOINTS, **options) -> Exchange:
    crew = Crew.of(chain, joints)
    bus.speak(protocols_of(chain))
    roll = {servo.servo_id: bus.ping(servo.servo_id) for servo in crew.everyone}
    return Exchange(bus, crew, roll, JointScale.of(crew.targets), **options)


@pytest.fixture
def bus(line):
    with DynamixelBus(line.port, margin=SHORT) as opened:
        yield opened


@pytest.fixture
def start():
    """Start virtual servos of some models, and an exchange with them."""
    opened = []

    def make(*models: str, protocol: float = 2.0, margin: float = MARGIN, **options):
        names = tuple(f"j{k}" for k in range(len(models)))
        chain = ServoChain(
            servos=tuple(
                ServoSpec(
                    name=name,
                    servo_id=k + 1,
                    model=model,
                    role=ServoRole.LEADER,
                    joint=name,
                    zero_ticks=ZEROS.get(model, 2048),
                )
                for k, (name, model) in enumerate(zip(names, models, strict=True))
            ),
            protocol=protocol,
        )
        virtual = VirtualBus(_arm(names), chain, transport="socket", wire_time=False)
        opened.append(virtual.__enter__())
        opened.append(DynamixelBus(virtual.port, margin=margin))
        return virtual, exchange(opened[-1], chain, names, **options)

    yield make
    for each in reversed(opened):
        each.__exit__(None, None, None)


def _arm(names: tuple[str, ...]) -> Arm:
    n = len(names)
    limits = JointLimits(
        names=names,
        kinds=(JointKind.REVOLUTE,) * n,
        q_min=np.full(n, -2.0),
        q_max=np.full(n, 2.0),
        qd_max=np.full(n, 4.0),
        qdd_max=np.full(n, 20.0),
    )
    rows = [DHLink(name, 0.1, 0.0, 0.0, 0.0) for name in names]
    return Arm.from_dh("arm", rows, DHConvention.STANDARD, limits)


def goals(virtual: VirtualBus, one: Exchange, *names: str) -> list[list[int]]:
    """Give what servos hold, after all that was sent has reached them."""
    one.sample()  # answered after what was sent before
    with virtual.lock:
        return [[servo.memory.get(name) for name in names] for servo in virtual.all_servos]


def test_a_cycle_is_one_write_and_one_fast_read(bus, line, make_chain):
    one = exchange(bus, make_chain())
    one.lay_out()
    for servo_id, ticks in ((1, 2148), (2, 1948), (4, 2048)):
        line.servos[servo_id]["Present Position"] = ticks
    line.servos[1]["Present Current"] = -100
    line.servos[4]["Present Load"] = 250
    line.servos[4]["Present Velocity"] = 10
    line.instructions.clear()
    one.write(np.array([2048, 2050, 2052]))
    before = time.monotonic()
    state = one.read()
    assert before <= state.t <= time.monotonic()
    assert line.instructions == ONE_EACH == list(one.instructions)
    assert [line.servos[i]["Goal Position"] for i in (1, 2, 4)] == [2048, 2050, 2052]
    assert state.q == pytest.approx([100 * TICK, -100 * TICK, 0.0])
    assert state.qd == pytest.approx([0.0, 0.0, 10 * 0.229 * 2 * np.pi / 60])
    assert state.current[:2] == pytest.approx([-0.269, 0.0])
    assert np.isnan(state.current).tolist() == [False, False, True]
    assert np.isnan(one.load).tolist() == [True, True, False]
    assert one.load[2] == pytest.approx(0.25)


def test_servos_that_do_not_answer_fast_reads_are_asked_plainly(bus, line, make_chain, caplog):
    line.knows_fast = False
    one = exchange(bus, make_chain())
    one.lay_out()
    assert one.instructions[-1] == Instruction.SYNC_READ
    assert "nobody answers fast reads" in caplog.text
    one.read()
    assert one.stats[1].timeouts == 0  # what was tried at start is no fault of a servo


def test_firmware_that_is_too_old_for_fast_reads_is_not_asked_for_them(bus, line, make_chain):
    line.servos[1]["Firmware Version"] = 44
    one = exchange(bus, make_chain())
    one.lay_out()
    assert Instruction.FAST_SYNC_READ not in line.instructions
    assert one.instructions[-1] == Instruction.SYNC_READ


def test_a_lost_servo_is_named_and_the_others_are_still_seen(bus, line, make_chain):
    one = exchange(bus, make_chain())
    one.read()
    line.silent.add(2)
    line.servos[1]["Present Position"] = 2148
    with pytest.raises(BusTimeoutError, match=r"servo 2 \(shoulder\) .*Present Position"):
        one.read()
    begun = time.monotonic()
    with pytest.raises(BusTimeoutError):
        one.read()
    seen = one.last_seen
    assert seen.q[0] == pytest.approx(100 * TICK)
    assert (seen.t >= begun).tolist() == [True, False, True]
    assert one.stats[2].timeouts == 2
    assert (one.stats[1].timeouts, one.stats[1].reads) == (0, 3)
    line.silent.clear()
    assert one.read().q[0] == pytest.approx(100 * TICK)


def test_the_dead_servo_is_named_not_those_that_waited_for_it(bus, line, make_chain):
    one = exchange(bus, make_chain())
    for dead in (1, 4, 2):  # after the first it is asked last, and 4 comes before 1
        line.silent = {dead}
        for _ in range(3):  # the first may leave open who of two is lost
            trouble = one.sample()
        assert list(trouble) == [dead]
        line.silent = set()
        one.sample()
        assert one.sample() == {}


def test_a_damaged_answer_is_counted_as_such(bus, line, make_chain):
    one = exchange(bus, make_chain())
    line.damaged.add(2)
    with pytest.raises(PacketError, match=r"servo 2 \(shoulder\)"):
        one.read()
    assert {i: s.crc_errors for i, s in one.stats.items()} == {1: 0, 2: 1, 4: 0}


def test_an_error_that_latches_on_the_way_is_named_and_the_state_is_kept(bus, line, make_chain):
    one = exchange(bus, make_chain())
    line.servos[2]["Hardware Error Status"] = 0x20
    line.servos[2]["Present Position"] = 2148
    with pytest.raises(ServoError, match="overload") as caught:
        one.read()
    assert caught.value.servo_id == 2
    assert one.last_seen.q[1] == pytest.approx(100 * TICK)


def test_instructions_that_had_to_be_sent_again_are_counted(bus, line, make_chain):
    one = exchange(bus, make_chain())
    line.drops = 2
    bus.ping(4)
    assert {i: s.retries for i, s in one.stats.items()} == {1: 0, 2: 0, 4: 2}


def test_goals_with_velocity_and_current_go_out_in_one_write(start):
    virtual, one = start(XM, XL, **EXTRAS)
    assert len(one.instructions) == 4
    one.lay_out()
    assert list(one.instructions) == ONE_EACH
    one.write(np.array([2000, 2100]), np.array([0.2, -0.2]), np.array([0.3, 9.9]))
    held = goals(virtual, one, "Goal Position", "Goal Velocity", "Goal Current")
    assert held == [[2000, 8, 112], [2100, -8, 0]]  # the XL430 has no such register


def test_a_servo_that_obeys_its_leader_gathers_its_registers_like_it(bus, line, make_chain):
    one = exchange(bus, make_chain(), **EXTRAS)
    one.lay_out()
    assert list(one.instructions) == ONE_EACH
    for servo_id in (2, 3):  # the shadow, too, has them; its own goal is not sent
        held = [line.servos[servo_id][f"Indirect Address {k}"] for k in range(1, 11)]
        assert held == [116, 117, 118, 119, 104, 105, 106, 107, 102, 103]


def test_what_is_not_given_is_left_as_it_is(start):
    virtual, one = start(XM, XL, **EXTRAS)
    one.lay_out()
    one.write(np.array([2000, 2100]), np.array([0.2, 0.2]), np.array([0.3, 0.0]))
    one.write(np.array([2001, 2101]))
    one.write(np.array([2002, 2102]), np.array([0.1, 0.1]))
    one.write(np.array([2003, 2103]), current=np.array([0.5, 0.0]))
    held = goals(virtual, one, "Goal Position", "Goal Velocity", "Goal Current")
    assert held == [[2003, 4, 186], [2103, 4, 0]]


def test_values_for_other_registers_or_servos_than_there_are_are_refused(start):
    _, one = start(XM, XL)
    with pytest.raises(ValueError, match="no register was named"):
        one.write(np.array([1, 2]), np.zeros(2))
    with pytest.raises(ValueError, match="want 2 values, got 3"):
        one.write(np.array([1, 2, 3]))
    with pytest.raises(ValueError, match="values"):
        one.write(np.array([1, 2**40]))


@pytest.mark.parametrize("options", [{}, EXTRAS])
def test_models_with_other_tables_are_still_one_write_and_one_read(start, options):
    virtual, one = start(XM, PH, XL, **options)
    before = one.read()
    one.lay_out()
    assert list(one.instructions) == ONE_EACH
    assert one.read().q == pytest.approx(before.q)
    extras = [np.full(3, 0.2)] * len(options)
    one.write(np.array([2000, 777, 2100]), *extras)
    assert goals(virtual, one, "Goal Position") == [[2000], [777], [2100]]


def test_with_torque_on_registers_that_cannot_be_gathered_stay_apart(start, caplog):
    virtual, one = start(XM, PH)
    servo = virtual.servos[2]
    servo.memory["Torque Enable"] = 1  # the pro keeps its indirect addresses in EEPROM
    with virtual.lock:
        servo.torque_on = True
    one.lay_out()
    assert "registers stay apart" in caplog.text
    assert list(one.instructions) == [Instruction.BULK_WRITE, Instruction.FAST_BULK_READ]
    one.write(np.array([2000, 777]))
    assert goals(virtual, one, "Goal Position") == [[2000], [777]]
    with virtual.lock:
        servo.memory["Torque Enable"] = 0
        servo.torque_on = False
    one.lay_out([2])
    assert list(one.instructions) == ONE_EACH


def test_a_layout_that_is_right_already_is_used_with_torque_on(start):
    virtual, one = start(XM, PH)
    one.lay_out()
    with virtual.lock:
        virtual.servos[2].memory["Torque Enable"] = 1
        virtual.servos[2].torque_on = True
    one.lay_out()
    assert list(one.instructions) == ONE_EACH


def test_a_servo_that_started_anew_is_told_and_not_misread(start):
    virtual, one = start(XM, PH)
    one.lay_out()
    before = one.last_seen.q[0]
    with virtual.lock:
        memory = virtual.servos[1].memory
        memory.reset(r for r in memory.table.registers if r.name.startswith("Indirect"))
    with pytest.raises(ServoError, match="started anew") as caught:
        one.read()
    assert caught.value.servo_id == 1
    assert one.last_seen.q[0] == before
    one.lay_out([1])
    assert one.read().q[0] == pytest.approx(before)


def test_servos_without_indirect_data_go_by_bulk_reads_and_writes(start):
    virtual, one = start(XM, "XL320")
    one.lay_out()
    assert list(one.instructions) == [Instruction.BULK_WRITE, Instruction.BULK_READ]
    assert one.read().q == pytest.approx([0.0, 0.0], abs=2 * TICK)
    one.write(np.array([2000, 600]))
    assert goals(virtual, one, "Goal Position") == [[2000], [600]]


def test_both_protocols_share_a_wire(start, caplog):
    virtual, one = start(XM, "AX-12A", "AX-12A", XL)
    caplog.set_level(logging.INFO)
    assert one.sample() == {}
    one.lay_out()
    assert list(one.instructions) == [
        Instruction.SYNC_WRITE,
        Instruction.SYNC_WRITE,
        Instruction.FAST_SYNC_READ,
        Instruction.READ,
        Instruction.READ,
    ]
    assert one.read().q == pytest.approx(np.zeros(4), abs=0.01)
    one.write(np.array([2000, 500, 530, 2100]))
    assert goals(virtual, one, "Goal Position") == [[2000], [500], [530], [2100]]


def test_servos_that_know_it_are_read_at_once_in_protocol_1(start):
    virtual, one = start(XM, MX, protocol=1.0)
    one.lay_out()
    assert list(one.instructions) == [Instruction.SYNC_WRITE, Instruction.BULK_READ]
    assert one.read().q == pytest.approx([0.0, 0.0], abs=2 * TICK)
    one.write(np.array([2000, 2100]))
    assert goals(virtual, one, "Goal Position") == [[2000], [2100]]


FAULTS = [
    "lost id=2 p=0.3",
    "corrupt p=0.3",
    "garbled p=0.01",
    "truncated p=0.2",
    "doubled p=0.3",
    "late p=0.1 by=0.002",
    "noise p=0.3",
    "echo p=0.5",
]


@pytest.mark.parametrize("models", [(XM, XL, XM), (XM, MX, XM), (XM, PH, XM)], ids=str)
@pytest.mark.parametrize("fault", FAULTS)
def test_whatever_the_wire_does_nothing_false_is_believed(start, fault, models):
    virtual, one = start(*models, margin=0.01)
    one.lay_out()
    assert any(one.sample() == {} for _ in range(50))
    true = one.last_seen.q
    virtual.faults = (LineFault.parse(fault),)
    for _ in range(40):
        one.sample()
        assert np.abs(one.last_seen.q - true).max() < 3 * TICK
    virtual.faults = ()
    assert any(one.sample() == {} for _ in range(50))


@pytest.mark.parametrize("ends", [False, True], ids=["others answer", "read ends there"])
@pytest.mark.parametrize("dead", [1, 2, 3])
@pytest.mark.parametrize(
    ("models", "protocol"),
    [((XM, XL, XM), 2.0), ((XM, MX, XM), 2.0), ((XM, MX, XM), 1.0), ((XM, "AX-12A", XL), 2.0)],
    ids=["fast", "plain", "protocol 1", "both protocols"],
)
def test_within_3_cycles_a_dead_servo_is_named_and_the_others_are_served(
    start, models, protocol, dead, ends
):
    virtual, one = start(*models, protocol=protocol, margin=0.1)
    virtual.habits = LineHabits(sync_read_ends=ends, bulk_read_1_ends=ends)
    one.lay_out()
    virtual.faults = (LineFault.parse(f"dead id={dead}"),)
    trouble = [list(one.sample()) for _ in range(8)]
    assert trouble[2:] == [[dead]] * 6
    virtual.faults = ()
    assert any(one.sample() == {} for _ in range(50))
