"""Grippers on virtual servos: opened, closed on something, losing it, and coming back."""

from dataclasses import replace
from math import inf

import pytest

from splinearm.drivers.chain import ServoChain, ServoRole
from splinearm.drivers.grip import Grip
from splinearm.drivers.gripper import Gripper, gripper_on
from splinearm.drivers.packets import Instruction
from splinearm.drivers.registers import Area
from splinearm.drivers.servo_arm import ServoArm
from splinearm.errors import BusTimeoutError, HealthError, ServoError

OPEN, CLOSED = 2900, 1900
GRIP = Grip(open_ticks=OPEN, closed_ticks=CLOSED)
CURRENT = {"Operating Mode": 5}
KINDS = {
    "current": ("XM430-W350", CURRENT, GRIP),
    "small current": ("XL330-M288", CURRENT, GRIP),
    "pwm": ("XL430-W250", {}, GRIP),
    "current measured, pwm limited": ("XM430-W350", {}, GRIP),
    "torque limit": ("XL320", {}, Grip(open_ticks=360, closed_ticks=660)),
    "the other way round": ("XL430-W250", {}, Grip(open_ticks=CLOSED, closed_ticks=OPEN)),
}


@pytest.fixture
def at(make_chain, make_spec, make_direct, in_their_time):
    """Make a gripper beside an arm of three joints, and its bus."""

    def make(model="XL430-W250", settings=None, grip=GRIP) -> tuple[Gripper, object]:
        gripper = make_spec(
            "gripper",
            9,
            model=model,
            role=ServoRole.GRIPPER,
            joint=None,
            zero_ticks=None,
            settings=settings or {},
            grip=grip,
        )
        bus = make_direct(ServoChain(servos=(*make_chain().servos, gripper)))
        in_their_time(bus)
        return Gripper(bus, gripper), bus

    return make


def put(bus, percent: float | None, grip: Grip = GRIP) -> None:
    """Put something between the fingers, or take it away."""
    model = bus.servos[9].model
    closed, opened = grip.travel
    ticks = closed + (opened - closed) * (0.0 if percent is None else percent) / 100.0
    angle = (ticks - model.centre) / model.pulses_per_rad
    limits = (angle, inf) if opened > closed else (-inf, angle)
    bus.plants["gripper"].between = (-inf, inf) if percent is None else limits
    bus.rig.wake()


def look_for(gripper: Gripper, bus, duration: float) -> None:
    """Look at it twenty times a second."""
    for _ in range(round(duration / 0.05)):
        gripper.look()
        bus.sleep(0.05)


def written_eeprom(bus, servo_id: int) -> list[str]:
    table = bus.servos[servo_id].model.table
    writes = [p for p in bus.sent if p.instruction == Instruction.WRITE and p.servo_id == servo_id]
    registers = [table.at(p.params[0] | p.params[1] << 8) for p in writes]
    return [r.name for r in registers if r.area is Area.EEPROM]


@pytest.mark.parametrize("kind", KINDS)
def test_it_opens_closes_holds_something_and_says_when_it_has_lost_it(at, kind):
    grip = KINDS[kind][2]
    gripper, bus = at(*KINDS[kind])
    opened = gripper.open()
    assert opened.percent == pytest.approx(100.0, abs=2.0)
    assert opened.arrived
    assert not opened.holding
    assert not gripper.holds
    put(bus, 40.0, grip)
    held = gripper.close()
    assert held.holding
    assert gripper.holds
    assert held.percent == pytest.approx(40.0, abs=1.0)
    servo = bus.servos[9]
    assert servo.load == pytest.approx(GRIP.force, rel=0.05)
    assert gripper.watch(bus.now + 1.0) is None
    put(bus, None)
    bus.sleep(1.0)
    told = [gripper.watch(bus.now + 0.3 * k) for k in range(4)]
    assert [line for line in told if line] == [
        "gripper has lost what it held: it stands at 0 %, holds nothing"
    ]
    assert not gripper.holds
    assert written_eeprom(bus, 9) == []


def test_it_closes_as_hard_as_it_is_told(at):
    gripper, bus = at("XM430-W350", CURRENT)
    put(bus, 50.0)
    for force in (0.15, 0.4):
        assert gripper.close(force).holding
        assert bus.servos[9].load == pytest.approx(force, rel=0.03)
    assert gripper.close(current=0.5).holding
    assert bus.servos[9].motor_current == pytest.approx(-0.5, abs=0.02)
    with pytest.raises(ValueError, match="got both"):
        gripper.close(0.3, current=0.5)


def test_numbers_that_cannot_be_are_refused_where_they_enter(at):
    gripper, bus = at()
    with pytest.raises(ValueError, match=r"percent: want 0 \(closed\) to 100 \(open\), got 101"):
        gripper.move(101.0)
    with pytest.raises(ValueError, match="force: want above 0 and at most 1, got 0"):
        gripper.move(50.0, 0.0)
    with pytest.raises(ValueError, match="XL430-W250 measures none; give a force"):
        gripper.close(current=0.5)
    limited, _ = at("XM430-W350", CURRENT | {"Current Limit": 300})
    with pytest.raises(ValueError, match=r"Current Limit of 300 allows, got 0\.9"):
        limited.close(0.9)
    assert bus.servos[9].memory["Goal Position"] == bus.servos[9].position


def test_the_torque_comes_on_without_a_jump_and_nothing_is_asked_before_the_first_use(at):
    gripper, bus = at()
    bus.shafts["gripper"].angle = 0.3
    assert not gripper.ready
    assert not bus.sent
    gripper.take()
    place = bus.servos[9].position
    bus.sleep(0.5)
    assert gripper.ready
    assert abs(bus.servos[9].position - place) <= 1


def test_one_that_holds_something_is_left_as_it_is_by_the_next_program(at):
    gripper, bus = at("XM430-W350", CURRENT)
    put(bus, 40.0)
    gripper.close(0.35)
    goal, limit = (bus.servos[9].memory[name] for name in ("Goal Position", "Goal Current"))
    bus.servos[9].memory["Bus Watchdog"] = 0xFF  # another program's had tripped
    later = Gripper(bus, gripper._servo)
    later.take()
    assert later.holds
    memory = bus.servos[9].memory
    assert (memory["Goal Position"], memory["Goal Current"]) == (goal, limit)
    assert memory["Bus Watchdog"] == 0
    assert bus.servos[9].load == pytest.approx(0.35, rel=0.03)


def test_a_gripper_that_holds_goes_on_when_the_bus_falls_silent_and_the_arm_has_stopped(
    at, make_chain, make_limits, setpoint
):
    gripper, bus = at()
    limits = make_limits()
    with ServoArm(make_chain(), limits.names, limits, bus) as arm:
        put(bus, 40.0)
        gripper.close()
        for _ in range(20):
            arm.read()
            arm.write(setpoint(*arm.goal))
            gripper.watch(bus.now)
            bus.sleep(0.01)
        bus.sleep(1.0)  # the program is gone
        assert all(bus.servos[i].tripped for i in (1, 2, 3, 4))
        assert not bus.servos[9].tripped
        assert bus.servos[9].load == pytest.approx(GRIP.force, rel=0.05)
    assert gripper.look().holding


def test_looking_after_it_costs_one_transaction_in_ten_cycles(
    at, make_chain, make_limits, setpoint
):
    gripper, bus = at()
    limits = make_limits()
    with ServoArm(make_chain(), limits.names, limits, bus) as arm:
        gripper.open()
        bus.sent.clear()
        for _ in range(100):
            before = len(bus.sent)
            arm.read()
            arm.write(setpoint(*arm.goal))
            beside = len(bus.sent)
            gripper.watch(bus.now)
            assert len(bus.sent) - beside <= 2
            bus.sleep(0.01 - 1e-3 * (len(bus.sent) - before))
    mine = [p for p in bus.sent if p.instruction in (Instruction.SYNC_READ, Instruction.READ)]
    assert sum(p.params[4:] == b"\x09" for p in mine) <= 10


def test_a_motion_is_stopped_where_it_is_and_pressing_goes_on(at):
    gripper, bus = at()
    gripper.send(100.0)
    bus.sleep(0.4)
    gripper.hold()
    place = gripper.look().percent
    bus.sleep(0.5)
    assert gripper.look().percent == pytest.approx(place, abs=5.0)
    assert place < 80.0
    put(bus, 30.0)
    gripper.close()
    gripper.hold()
    assert gripper.look().holding


def test_a_servo_that_has_stopped_itself_is_told_of_and_comes_back(at):
    gripper, bus = at()
    put(bus, 30.0)
    gripper.close(0.85)
    with pytest.raises(ServoError, match="overload") as caught:
        look_for(gripper, bus, 5.0)
    assert caught.value.alert
    assert not bus.servos[9].torque_on
    put(bus, None)
    [fault] = gripper.recover()
    assert "at the gripper: overload" in str(fault)
    assert bus.servos[9].torque_on
    assert gripper.close().arrived


def test_a_servo_that_lost_its_power_is_noticed(at):
    gripper, bus = at()
    gripper.open()
    bus.servos[9].power_cycle()
    bus.sleep(1.0)
    with pytest.raises(ServoError, match="lost its torque"):
        look_for(gripper, bus, 3.0)


def test_a_hot_one_is_told_of_as_a_joint_is(at, caplog):
    gripper, bus = at()
    gripper.open()
    bus.servos[9].temperature = 68.0
    with pytest.raises(HealthError, match="temperature"):
        look_for(gripper, bus, 3.0)
    assert gripper.health.temperature >= 67.0


def test_a_silent_one_is_named_after_three_times(at):
    gripper, bus = at()
    gripper.take()
    bus.servos[9].unplugged = True
    assert gripper.watch(bus.now + 1.0) is None
    assert gripper.watch(bus.now + 1.0) is None
    with pytest.raises(BusTimeoutError, match=r"servo 9 \(gripper\)"):
        gripper.watch(bus.now + 1.0)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"grip": Grip(open_ticks=2900)}, "where it is closed is not known; calibrate it"),
        ({"settings": {"Max Position Limit": 2500}}, "takes goals from 0 to 2500"),
    ],
)
def test_one_that_is_not_ready_says_what_helps(at, changes, words):
    gripper, bus = at(**changes)
    with pytest.raises(ServoError, match=words):
        gripper.open()
    assert not bus.servos[9].torque_on


def test_a_servo_in_another_mode_is_refused_and_not_changed(at):
    gripper, bus = at()
    bus.servos[9].memory["Operating Mode"] = 16
    with pytest.raises(ServoError, match="Operating Mode is 16, wanted 3"):
        gripper.open()
    assert written_eeprom(bus, 9) == []


@pytest.mark.parametrize("turns", [-2, 1])
def test_one_that_counts_turns_finds_the_turn_in_which_its_travel_lies(at, turns):
    ends = Grip(open_ticks=OPEN + turns * 4096, closed_ticks=CLOSED + turns * 4096)
    gripper, bus = at("XM430-W350", CURRENT, grip=ends)
    assert gripper.open().percent == pytest.approx(100.0, abs=2.0)
    assert bus.servos[9].position == pytest.approx(OPEN, abs=25)


def test_it_goes_as_fast_as_its_file_says_else_the_whole_travel_in_a_second(at):
    gripper, bus = at()
    gripper.close()
    gripper.send(100.0)
    bus.sleep(0.5)
    assert 25.0 < gripper.look().percent < 50.0
    slow, other = at(settings={"Profile Velocity": 20})
    slow.close()
    slow.send(100.0)
    other.sleep(0.5)
    assert slow.look().percent < 20.0


def test_a_chain_without_one_has_none(at, make_chain):
    _gripper, bus = at()
    assert gripper_on(make_chain(), bus) is None
    with pytest.raises(ValueError, match="want a gripper, got a leader"):
        Gripper(bus, make_chain().servos[0])
    with pytest.raises(ValueError, match="want no grip for a leader"):
        replace(make_chain().servos[0], grip=GRIP)
