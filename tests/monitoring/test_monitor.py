"""Servos watched on a virtual bus: what they say, and what becomes of those that do not."""

import json
import time
from dataclasses import replace

import numpy as np
import pytest

from splinearm.backends import centred
from splinearm.config import load_cell
from splinearm.drivers.dynamixel import DynamixelBus
from splinearm.drivers.packets import Instruction
from splinearm.errors import ConfigError, SilentBusError
from splinearm.monitoring import Level, Monitor, watching
from splinearm.monitoring.document import document
from splinearm.monitoring.outlet import line_of
from splinearm.monitoring.watching import Watching
from splinearm.sim.line_fault import LineFault
from splinearm.sim.virtual_bus import VirtualBus

pytestmark = pytest.mark.bus

Q = np.array([0.4, -0.3])


def cell_of(*models, arm="planar_2r", **changes):
    cell = load_cell(arm)
    chain = centred(cell.chain)
    if models:
        servos = tuple(
            replace(s, model=m, settings={}, zero_ticks=512 if m in ("AX-12A", "XL320") else 2048)
            for s, m in zip(chain.servos, models, strict=True)
        )
        chain = replace(chain, servos=servos)
    return replace(cell, chain=replace(chain, **changes))


@pytest.fixture
def arm():
    """A virtual arm of two servos, and its cell."""
    cell = cell_of()
    with VirtualBus(cell.arm, cell.chain, Q, transport="socket") as bus:
        yield cell, bus


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """What changes slowly is asked sooner, so that tests need not wait for it."""
    monkeypatch.setattr("splinearm.monitoring.monitor._SLOW_ROUND", 0.2)


def until(monitor, holds, timeout=5.0):
    """Take samples until something holds of one; give it."""
    due = time.monotonic() + timeout
    for sample in monitor.samples(200.0):
        if holds(sample):
            return sample
        assert time.monotonic() < due, sample.servos
    raise AssertionError


def test_a_sample_says_what_the_servos_say(arm):
    cell, bus = arm
    with bus.lock:
        bus.servos[2].memory["Torque Enable"] = 1
    with Monitor(bus.port, cell) as monitor:
        sample = monitor.sample()
        one, other = sample.servos
        assert [s.position for s in sample.servos] == pytest.approx(Q, abs=1e-3)
        assert (one.torque, other.torque) == (False, True)
        assert (one.joint, one.servo_id, one.model) == ("joint1", 1, cell.chain.servos[0].model)
        assert one.temperature == pytest.approx(bus.servos[1].temperature, abs=1.0)
        assert one.voltage == pytest.approx(bus.servos[1].voltage, abs=0.1)
        assert (one.answers, one.errors, one.moving) == (True, (), False)
        assert sample.level is Level.WELL
        assert (sample.arm, sample.baud) == ("planar_2r", cell.chain.baud)


def test_a_monitor_asks_and_writes_nothing(arm):
    cell, bus = arm
    heard = []
    obey = bus._server._obey

    def listen(what, baud):
        heard.append(what.packet.instruction)
        return obey(what, baud)

    bus._server._obey = listen
    before = [bytes(servo.memory._bytes) for servo in bus.all_servos]
    with Monitor(bus.port, cell) as monitor:
        for _, _ in zip(monitor.samples(400.0), range(60), strict=False):
            pass
        with pytest.raises(ValueError, match="rate: want"):
            next(monitor.samples(0.0))
        with pytest.raises(RuntimeError, match="asks only"):
            monitor._bus.write(1, cell.chain.servos[0].servo_model.table["LED"], 1)
    asking = {Instruction.PING, Instruction.READ, Instruction.SYNC_READ, Instruction.FAST_SYNC_READ}
    assert set(heard) <= asking
    # one read a cycle, and now and then two of what changes slowly
    assert sum(instruction is Instruction.FAST_SYNC_READ for instruction in heard) <= 70
    settings = [r for r in bus.all_servos[0].memory.table.registers if r.writable]
    after = [bytes(servo.memory._bytes) for servo in bus.all_servos]
    for old, new in zip(before, after, strict=True):
        assert all(old[r.address : r.end] == new[r.address : r.end] for r in settings)


def test_a_servo_that_goes_silent_is_told_and_comes_back_by_itself(arm):
    cell, bus = arm
    with Monitor(bus.port, cell) as monitor:
        monitor.sample()
        bus.faults = (LineFault.parse("dead id=2"),)
        sample = until(monitor, lambda s: not s.servos[1].answers)
        silent = sample.servos[1]
        assert (silent.verdict.level, silent.verdict.code) == (Level.STOP, "L04")
        assert "cable" in silent.verdict.remedy
        assert np.isnan(silent.position)
        assert silent.lost > 0
        assert sample.servos[0].answers
        assert sample.servos[0].position == pytest.approx(Q[0], abs=1e-3)
        bus.faults = ()
        back = until(monitor, lambda s: s.servos[1].answers).servos[1]
        assert back.position == pytest.approx(Q[1], abs=1e-3)
        assert back.verdict.level is Level.WELL


def test_a_servo_that_is_not_there_at_first_is_awaited(arm):
    cell, bus = arm
    bus.servos[1].unplugged = True
    with Monitor(bus.port, cell) as monitor:
        assert [s.answers for s in monitor.sample().servos] == [False, True]
        bus.servos[1].unplugged = False
        until(monitor, lambda s: s.servos[0].answers)


def test_a_port_that_is_pulled_out_is_awaited(tmp_path):
    cell, link = cell_of(), tmp_path / "port"
    with VirtualBus(cell.arm, cell.chain, Q, link=link) as bus, Monitor(str(link), cell) as monitor:
        monitor.sample()
        bus.unplug()
        sample = until(monitor, lambda s: s.trouble)
        assert sample.level is Level.STOP
        assert not any(servo.answers for servo in sample.servos)
        bus.plug_in()
        sample = until(monitor, lambda s: not s.trouble and all(x.answers for x in s.servos))
        assert sample.servos[0].position == pytest.approx(Q[0], abs=1e-3)


def test_findings_are_the_doctors(arm):
    cell, bus = arm
    with bus.lock:
        bus.servos[1].fail("overload")
        bus.servos[2].heat.ambient = bus.servos[2].temperature = 70.0
    with Monitor(bus.port, cell, told="mine.toml") as monitor:
        ill, hot = monitor.sample().servos
        assert ill.errors == ("overload",)
        assert (ill.verdict.level, ill.verdict.code) == (Level.STOP, "S10")
        assert f"splinearm recover mine.toml --port {bus.port}" in ill.verdict.remedy
        assert (hot.verdict.level, hot.verdict.code) == (Level.WARN, "S13")
        assert hot.verdict.fields == {"temperature": Level.WARN}
        with bus.lock:
            bus.servos[2].heat.ambient = bus.servos[2].temperature = 78.0
            bus.servos[1].voltage = 9.0
        sample = until(monitor, lambda s: s.servos[1].verdict.level is Level.STOP)
        assert sample.servos[1].verdict.fields == {"temperature": Level.STOP}
        until(monitor, lambda s: s.servos[0].verdict.fields.get("voltage") is Level.STOP)


def test_what_was_set_while_the_torque_was_off_is_read_anew_once_it_is_on(arm):
    cell, bus = arm
    with Monitor(bus.port, cell) as monitor:
        assert monitor.sample().level is Level.WELL
        with bus.lock:
            bus.servos[1].memory["PWM Limit"] = 0
            bus.servos[1].memory["Torque Enable"] = 1
        sample = until(monitor, lambda s: s.servos[0].torque)
        assert sample.servos[0].verdict.code == "S12"


def test_samples_that_nobody_takes_are_counted(arm, monkeypatch):
    cell, bus = arm
    monkeypatch.setattr(watching, "_KEPT", 3)
    with Monitor(bus.port, cell) as monitor, Watching(monitor, 200.0) as watched:
        time.sleep(0.1)
        taken = watched.take()
    assert len(taken) == 3
    assert watched.dropped > 3
    numbers = [sample.number for sample in taken]
    assert numbers == list(range(numbers[0], numbers[0] + 3))


def test_noise_on_the_line_is_counted_and_told(arm):
    cell, bus = arm
    with Monitor(bus.port, cell) as monitor:
        monitor.sample()
        bus.faults = (LineFault.parse("corrupt id=1 p=0.3"),)
        sample = until(monitor, lambda s: s.servos[0].verdict.code == "L07")
        assert sample.servos[0].damaged >= 5
        assert sample.servos[1].damaged == 0


def test_an_effort_counts_as_its_mean_over_half_a_second(arm):
    cell, bus = arm
    table = cell.chain.servos[0].servo_model.table
    with DynamixelBus(bus.port, cell.chain.baud) as line:
        line.write(1, table["Goal Position"], line.read(1, table["Present Position"]))
        line.write(1, table["Torque Enable"], 1)
    with Monitor(bus.port, cell) as monitor:
        monitor.sample()
        bus.push([3.8, 0.0])
        began = time.monotonic()
        sample = until(monitor, lambda s: s.servos[0].verdict.level is not Level.WELL)
        assert time.monotonic() - began > 0.2
        servo = sample.servos[0]
        assert set(servo.verdict.fields) == {"current"}
        assert "blocks the joint" in servo.verdict.remedy
        assert servo.mean_current < abs(servo.current)


def test_without_an_arm_whoever_answers_is_watched(arm):
    cell, bus = arm
    with Monitor(bus.port, baud=cell.chain.baud) as monitor:
        sample = monitor.sample()
        assert [(s.name, s.model, s.joint) for s in sample.servos] == [
            (f"servo_{k}", cell.chain.servos[k - 1].model, None) for k in (1, 2)
        ]
        assert [s.position for s in sample.servos] == pytest.approx(Q, abs=1e-3)
        assert sample.level is Level.WELL


def test_a_port_without_servos_and_an_arm_without_any_are_refused(arm):
    cell, bus = arm
    with pytest.raises(ConfigError, match="no servos"):
        Monitor(bus.port, replace(cell, chain=None))
    bus.silent = True
    with pytest.raises(SilentBusError):
        Monitor(bus.port, baud=1_000_000)


@pytest.mark.parametrize(
    ("models", "protocol"),
    [
        (("AX-12A", "XL320"), 2.0),
        (("XM430-W350", "AX-12A"), 2.0),
        (("XM430-W350", "XM430-W350"), 1.0),
        (("XL430-W250", "PH42-020-S300"), 2.0),
    ],
)
def test_models_and_protocols_may_be_mixed(models, protocol):
    cell = cell_of(*models, protocol=protocol)
    zeros = [
        0 if m == "PH42-020-S300" else s.zero_ticks
        for s, m in zip(cell.chain.servos, models, strict=True)
    ]
    servos = tuple(replace(s, zero_ticks=z) for s, z in zip(cell.chain.servos, zeros, strict=True))
    cell = replace(cell, chain=replace(cell.chain, servos=servos))
    with (
        VirtualBus(cell.arm, cell.chain, Q, transport="socket") as bus,
        Monitor(bus.port, cell) as monitor,
    ):
        monitor.sample()
        sample = monitor.sample()
        assert [s.model for s in sample.servos] == list(models)
        assert [s.position for s in sample.servos] == pytest.approx(Q, abs=6e-3)
        assert all(s.answers and s.temperature > 20.0 and s.torque is False for s in sample.servos)
        assert sample.level is Level.WELL


def test_a_servo_of_another_model_is_read_as_what_it_is(arm):
    cell, bus = arm
    other = cell_of("XL430-W250", cell.chain.servos[1].model)
    with Monitor(bus.port, other) as monitor:
        servo = monitor.sample().servos[0]
        assert servo.model == cell.chain.servos[0].model
        assert servo.verdict.code == "S01"
        assert servo.position == pytest.approx(Q[0], abs=1e-3)


def test_a_servo_that_is_not_known_here_is_told(arm):
    cell, bus = arm
    with bus.lock:
        bus.servos[1].memory["Model Number"] = 9999
    with Monitor(bus.port, cell) as monitor:
        one, other = monitor.sample().servos
        assert (one.answers, one.verdict.code, one.model) == (False, "S01", "")
        assert one.verdict.what == "a servo of another model"
        assert other.verdict.level is Level.WELL


@pytest.mark.slow
def test_whatever_happens_on_the_line_the_watching_goes_on(tmp_path):
    cell, link = cell_of(arm="wx250s"), tmp_path / "port"
    rng = np.random.default_rng(5)
    kinds = ("lost", "corrupt", "garbled", "truncated", "doubled", "late", "noise", "dead")
    home = cell.poses["home"]
    with (
        VirtualBus(cell.arm, cell.chain, home, transport="socket", link=link) as bus,
        Monitor(str(link), cell) as monitor,
    ):
        began, due, plugged = time.monotonic(), 0.0, True
        for sample in monitor.samples(200.0):
            json.loads(line_of(document(sample)))
            for servo in sample.servos:
                assert servo.answers or np.isnan(servo.position)
                if servo.answers and servo.joint is not None:
                    place = home[cell.arm.joint_names.index(servo.joint)]
                    assert servo.position == pytest.approx(place, abs=5e-3)
            now = time.monotonic() - began
            if now > 40.0:
                break
            if now > due:
                due = now + rng.uniform(0.1, 0.8)
                texts = [
                    f"{rng.choice(kinds)} id={rng.integers(1, 10)} p={rng.uniform(0.01, 0.6):.2f}"
                    for _ in range(rng.integers(0, 3))
                ]
                bus.faults = tuple(LineFault.parse(text) for text in texts)
                if rng.random() < 0.2:
                    (bus.unplug if plugged else bus.plug_in)()
                    plugged = not plugged
        if not plugged:
            bus.plug_in()
        bus.faults = ()
        sample = until(monitor, lambda s: all(servo.answers for servo in s.servos), 10.0)
        assert all(servo.reads > 100 for servo in sample.servos)


def test_a_joint_whose_zero_is_not_known_is_told(arm):
    cell, bus = arm
    servos = (replace(cell.chain.servos[0], zero_ticks=None), cell.chain.servos[1])
    with Monitor(bus.port, replace(cell, chain=replace(cell.chain, servos=servos))) as monitor:
        verdict = monitor.sample().servos[0].verdict
        assert (verdict.code, verdict.level) == ("S21", Level.WARN)
        assert "splinearm calibrate" in verdict.remedy
