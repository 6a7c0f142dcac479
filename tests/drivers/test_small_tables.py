"""Arms of AX-12A and XL-320, and of servos that speak different protocols on one wire."""

import logging
from dataclasses import replace

import numpy as np
import pytest

from splinearm.drivers.ability import torque_span, voltage_register
from splinearm.drivers.chain import ServoChain, ServoRole, ServoSpec
from splinearm.drivers.dynamixel import scan
from splinearm.drivers.model import servo_model, servo_models
from splinearm.drivers.packets import Instruction
from splinearm.errors import ServoError
from splinearm.joints import JointSetpoint
from splinearm.sim.event import EventKind
from splinearm.sim.virtual_bus import VirtualBus
from splinearm.units import DEG

pytestmark = pytest.mark.bus

CENTRES = {"AX-12A": 512, "XL320": 512}
MIXES = [
    ("AX-12A", "AX-12A"),
    ("XL320", "XL320"),
    ("XM430-W350", "AX-12A"),
    ("AX-12A", "XL320"),
    ("XM430-W350 in 1.0", "XM430-W350"),
    ("XM430-W350 in 1.0", "AX-12A"),
]


def chain_of(*models: str) -> ServoChain:
    def spec(k: int, words: str) -> ServoSpec:
        model, _, old = words.partition(" in ")
        return ServoSpec(
            name=f"s{k}",
            servo_id=k + 1,
            model=model,
            role=ServoRole.LEADER,
            joint=f"j{k}",
            zero_ticks=CENTRES.get(model, 2048),
            settings={"Return Delay Time": 0} | ({"Protocol Type": 1} if old else {}),
        )

    return ServoChain(servos=tuple(spec(k, words) for k, words in enumerate(models)))


@pytest.fixture
def make_arm(stepped_arm, pendulum):
    """Make arms of two rods that such servos move."""

    def make(*models: str, q_start=(0.3, -0.5)):
        arm = pendulum(len(models), 0.03, 0.1)
        far = np.full(len(models), 2.5)
        arm = replace(arm, limits=replace(arm.limits, q_min=-far, q_max=far))
        return stepped_arm(arm, chain_of(*models), list(q_start))

    return make


def follow(one, q_goal, cycles: int = 100) -> float:
    """Lead the joints to a goal; give by how much they were off at the worst."""
    start, worst = one.driver.goal, 0.0
    for k in range(1, cycles + 1):
        u = k / cycles
        way = start + (np.array(q_goal) - start) * (u * u * (3.0 - 2.0 * u))
        still = np.zeros(len(way))
        one.cycle(JointSetpoint(t=k * one.period, q=way, qd=still, qdd=still))
        worst = max(worst, np.abs(one.virtual.q - way).max())
    return worst


@pytest.mark.parametrize("models", MIXES, ids=" and ".join)
def test_an_arm_of_old_and_new_servos_holds_without_a_jump_and_follows_a_motion(make_arm, models):
    one = make_arm(*models)
    before = one.virtual.q
    with one.driver:
        one.pass_time(0.5)
        np.testing.assert_allclose(one.virtual.q, before, atol=4.0 * DEG)
        assert all(servo.torque_on for servo in one.virtual.all_servos)
        assert follow(one, [0.9, 0.4]) <= 6.0 * DEG
        state = one.driver.read()
        np.testing.assert_allclose(state.q, one.virtual.q, atol=0.5 * DEG)
        one.driver.hold()
    one.t += 0.3
    one.virtual.advance()
    np.testing.assert_allclose(one.virtual.q, [0.9, 0.4], atol=5.0 * DEG)
    assert all(servo.torque_on for servo in one.virtual.all_servos)


@pytest.mark.parametrize("model", ["AX-12A", "XL320"])
def test_a_goal_that_switches_the_torque_on_is_where_the_servo_stands(make_arm, model):
    one = make_arm(model, model)
    with one.virtual.lock:
        for servo in one.virtual.all_servos:
            servo.choices = replace(servo.choices, torque_on_by_goal=True)
            servo.memory["Goal Position"] = 512  # of before: not where it stands
    before = one.virtual.q
    with one.driver:
        one.pass_time(0.5)
        np.testing.assert_allclose(one.virtual.q, before, atol=4.0 * DEG)
        assert not any(servo.events.of(EventKind.GOAL_JUMP) for servo in one.virtual.all_servos)


def test_in_a_cycle_each_protocol_is_asked_once(make_arm):
    one = make_arm("XM430-W350", "AX-12A")
    with one.driver:
        steps = one.driver._line.exchange.instructions
    assert Instruction.READ in steps
    assert steps.count(Instruction.SYNC_WRITE) == 2


def test_what_cannot_be_promised_is_said_once_at_the_start(make_arm, caplog):
    caplog.set_level(logging.WARNING)
    with make_arm("AX-12A", "AX-12A").driver as arm:
        arm.read()
    told = [r.getMessage() for r in caplog.records]
    assert [text for text in told if "no watchdog" in text] == [
        "s0, s1: AX-12A has no watchdog: if this program dies, it goes on to its last goal"
    ]
    caplog.clear()
    with make_arm("XM430-W350 in 1.0", "XM430-W350").driver as arm:
        arm.read()
    assert not caplog.records


class Time:
    """Stands for the module ``time``, in the time of a stepped arm."""

    def __init__(self, one) -> None:
        self.one = one

    def monotonic(self) -> float:
        return self.one.t

    def sleep(self, duration: float) -> None:
        self.one.t += duration
        self.one.virtual.advance()


@pytest.mark.parametrize("model", ["AX-12A", "XL320"])
def test_an_overload_is_named_and_recovered_without_a_jump(make_arm, model, monkeypatch):
    one = make_arm("XM430-W350", model)
    for module in ("recover", "torque"):
        monkeypatch.setattr(f"splinearm.drivers.{module}.time", Time(one))
    for servo in one.virtual.all_servos:
        servo.choices = replace(servo.choices, boot_time=0.02)
    with one.driver as arm:
        follow(one, [0.3, 0.2], 30)
        victim = one.virtual.servos[2]
        with one.virtual.lock:
            victim.fail("overload")
        with pytest.raises(ServoError, match=r"s1\): it reports overload"):
            arm.read()
        one.pass_time(0.05)
        assert not victim.torque_on
        assert [str(fault.causes[0]) for fault in arm.recover()] == ["overload"]
        assert victim.torque_on
        assert victim.memory["Torque Limit"] == victim.memory["Max Torque"]
        assert abs(one.virtual.q[1] - arm.goal[1]) <= 4.0 * DEG
        arm.read()
        follow(one, [0.4, 0.0], 30)


def test_an_ax_that_lost_its_power_is_noticed_and_gets_its_torque_again(make_arm):
    one = make_arm("AX-12A", "AX-12A")
    with one.driver as arm:
        with one.virtual.lock:
            one.virtual.servos[2].power_cycle()
        one.pass_time(0.6)
        assert arm.recover() == ()
        assert one.virtual.servos[2].torque_on
        follow(one, [0.4, 0.0], 20)


def test_health_is_read_where_small_tables_have_it(make_arm):
    one = make_arm("AX-12A", "XL320")
    with one.driver as arm:
        line = arm._line
        for _k in range(2 * len(one.chain.servos)):
            line.health.look(line.health._due + 1.0, np.zeros(2))
        readings = arm.health
    for number, volts in ((1, 12.0), (2, 7.4)):
        assert readings[number].temperature == pytest.approx(25.0, abs=5.0)
        assert readings[number].voltage == pytest.approx(volts, abs=1.5)


@pytest.mark.parametrize("model", servo_models(), ids=lambda model: model.name)
def test_every_model_says_its_supply_its_temperature_and_whether_it_has_torque(model):
    supply = voltage_register(model)
    assert supply.end == model.table["Present Temperature"].address
    address, length = torque_span(model)
    assert address == model.table["Torque Enable"].address
    assert length == 1 or model.table["Torque Limit"].end == address + length


def test_a_servo_in_wheel_mode_is_refused(make_arm):
    one = make_arm("AX-12A", "AX-12A")
    with one.virtual.lock:
        one.virtual.servos[2].memory["CCW Angle Limit"] = 0
    with pytest.raises(ServoError, match="takes goals from 0 to 0 ticks"):
        one.driver.__enter__()


def test_a_scan_finds_both_protocols_at_all_rates(pendulum):
    models = ("AX-12A", "XM430-W350", "XM430-W350 in 1.0", "XM430-W350", "AX-12A", "XM430-W350")
    chain = chain_of(*models)
    with VirtualBus(pendulum(6, 0.01), chain, np.full(6, 0.1)) as bus:
        with bus.lock:
            memory = bus.servos[4].memory
            memory["Baud Rate"] = servo_model("XM430-W350").baud_code(57_600)
        # a busy computer may let an answer come too late to count: then it is asked again
        scans = (scan(bus.port) for _ in range(3))
        found = next((found for found in scans if len(found) == len(models)), ())
    assert sorted((one.servo_id, one.model, one.protocol, one.baud) for one in found) == [
        (k + 1, model.split()[0], protocol, 57_600 if k == 3 else 1_000_000)
        for k, (model, protocol) in enumerate(zip(models, (1, 2, 1, 2, 1, 2), strict=True))
    ]
