"""The supply that servos share, and what happens to all of them when it fails."""

import numpy as np
import pytest

from splinearm.sim.event import EventKind
from splinearm.sim.motor import motor_of
from splinearm.sim.plant import FreePlant
from splinearm.sim.rig import Rig
from splinearm.sim.virtual_bus import VirtualBus


@pytest.fixture
def pair(make_bench):
    benches = [make_bench(Operating_Mode=16, ID=k) for k in (1, 2)]
    return Rig([bench.servo for bench in benches], [bench.plant for bench in benches]), benches


def push(rig, benches, pwm: int, t: float) -> None:
    for bench in benches:
        bench.servo.stuck = True
        bench.set("Torque Enable", 1)
        bench.set("Goal PWM", pwm)
    rig.wake()
    rig.advance_to(t)


def test_the_voltage_sags_by_all_currents(pair):
    rig, benches = pair
    (supply,) = rig.supplies
    supply.resistance = 0.5
    push(rig, benches, 885, 0.05)
    servo = benches[0].servo
    drawn = sum(bench.servo.supply_current for bench in benches)
    assert servo.voltage == pytest.approx(12.0 - 0.5 * drawn, abs=0.01)
    assert benches[1].get("Present Input Voltage") == round(10 * servo.voltage) < 110
    stalled = motor_of(servo.model).stall_current * servo.voltage / 12.0
    assert servo.motor_current == pytest.approx(stalled, rel=0.01)


def test_without_a_resistance_voltages_are_left_as_they_are(pair):
    rig, benches = pair
    benches[0].servo.voltage = 11.0
    push(rig, benches, 885, 0.05)
    assert [bench.servo.voltage for bench in benches] == [11.0, 12.0]


def test_a_sag_too_deep_is_a_brown_out(pair):
    rig, benches = pair
    (supply,) = rig.supplies
    supply.resistance, supply.fails_below = 2.0, 8.0
    push(rig, benches, 885, 0.05)
    for bench in benches:
        assert bench.servo.events.of(EventKind.REBOOT)
        assert not bench.servo.torque_on


def test_a_brown_out_reboots_all_and_takes_their_turns(pair):
    rig, benches = pair
    for bench in benches:
        bench.set("Operating Mode", 4)
        bench.servo.shaft.angle = 4 * np.pi
    rig.brown_out(off_for=0.5)
    for bench in benches:
        assert bench.get("Present Position") == 2048
        assert not bench.servo.listens(57_600)
    rig.advance_to(0.89)
    assert not benches[0].servo.listens(57_600)
    rig.advance_to(0.92)
    assert benches[0].servo.listens(57_600)


@pytest.mark.sim
def test_on_a_bus_a_servo_leads_to_the_supply_of_all(make_arm, make_chain):
    bus = VirtualBus(make_arm(2), make_chain(2), [0.3, -0.3], clock=lambda: 0.0)
    with bus.lock:
        for servo in bus.servos.values():
            assert servo.write(64, b"\x01") == 0
        bus.servos[1].supply.brown_out()
    assert [len(servo.events.torque_lost()) for servo in bus.servos.values()] == [1, 1]


def test_servos_of_other_voltages_have_other_supplies(make_bench):
    benches = [make_bench(model) for model in ("XM430-W350", "XL330-M288", "XL430-W250")]
    rig = Rig([bench.servo for bench in benches], [bench.plant for bench in benches])
    assert [supply.open_voltage for supply in rig.supplies] == [12.0, 5.0]
    assert benches[0].servo.supply is benches[2].servo.supply is rig.supplies[0]
    assert isinstance(benches[0].plant, FreePlant)
