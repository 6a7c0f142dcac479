"""A healthy arm is left in peace: nothing is found, nothing is written, nothing moves."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from splinearm.backends import centred
from splinearm.config import load_cell, shipped_arms
from splinearm.doctor.look import Effort, diagnose
from splinearm.doctor.stethoscope import Stethoscope
from splinearm.drivers.cyclic import GroupWrite
from splinearm.drivers.packets import Instruction
from splinearm.sim.line_fault import LineFault
from splinearm.sim.virtual_bus import VirtualBus

pytestmark = pytest.mark.bus

# how quick the loop is depends on what else this computer does: C08 has its own tests
LOOK = Effort(pings=30, cycles=0)
ASKING = {
    Instruction.PING,
    Instruction.READ,
    Instruction.SYNC_READ,
    Instruction.FAST_SYNC_READ,
    Instruction.BULK_READ,
    Instruction.FAST_BULK_READ,
}


def well(cell):
    return replace(cell, chain=centred(cell.chain))


@pytest.mark.parametrize(
    ("arm", "transport"), [*((arm, "socket") for arm in shipped_arms()), ("wx250s", "pty")]
)
def test_a_shipped_arm_gives_no_finding(arm, transport, virtual):
    with virtual(arm, transport) as (cell, bus):
        diagnosis = diagnose(bus.port, well(cell), arm=arm, effort=LOOK)
        count = len(bus.all_servos)
    assert [str(finding) for finding in diagnosis.findings] == []
    assert diagnosis.is_well
    assert len(diagnosis.charts) == count
    assert diagnosis.pace.predicted > 100.0


@pytest.mark.parametrize(
    ("model", "protocol", "zero"),
    [("AX-12A", 1.0, 512), ("XL320", 2.0, 512), ("XM430-W350", 1.0, 2048)],
)
def test_old_servos_and_protocols_give_no_finding_either(model, protocol, zero):
    cell = load_cell("planar_2r")
    servos = tuple(
        replace(servo, model=model, settings={}, zero_ticks=zero) for servo in cell.chain.servos
    )
    chain = replace(cell.chain, servos=servos, protocol=protocol)
    with VirtualBus(cell.arm, chain, [0.1, 0.2], transport="socket") as bus:
        for known in (replace(cell, chain=chain), None):
            diagnosis = diagnose(bus.port, known, effort=LOOK)
            assert [str(finding) for finding in diagnosis.findings] == []
            assert {chart.model.name for chart in diagnosis.charts.values()} == {model}


def test_servos_without_an_arm_file_are_looked_at_by_themselves(virtual):
    with virtual("planar_2r") as (_, bus):
        with bus.lock:
            bus.servos[1].fail("overload")
        diagnosis = diagnose(bus.port, effort=LOOK)
    assert {finding.code for finding in diagnosis.findings} == {"S10", "S11"}
    assert "splinearm recover ARM --port" in diagnosis.findings[0].remedy
    assert diagnosis.pace is None


def test_without_an_arm_file_two_rates_on_a_line_are_told(virtual):
    with virtual("planar_2r", "pty") as (_, bus):
        bus.faults = (LineFault.parse("echo"),)
        with bus.lock:
            bus.servos[2].memory["Baud Rate"] = 4
        diagnosis = diagnose(bus.port, effort=LOOK)
    assert [finding.code for finding in diagnosis.findings] == ["L02", "L11"]
    assert "2000000 baud, others at 1000000" in diagnosis.findings[0].cause


def test_nothing_is_written_and_nothing_moves(virtual, monkeypatch):
    with virtual("wx250s") as (cell, bus):
        with bus.lock:
            bus.servos[4].fail("overload")
            bus.servos[7].memory["Drive Mode"] = 0
            before = {i: bytes(servo.memory._bytes) for i, servo in bus.servos.items()}
            for servo in bus.all_servos:
                servo.events.clear()
        q, obey, heard = bus.q, bus._server._obey, []

        def listening(packet, baud):
            heard.append(packet.packet.instruction)
            return obey(packet, baud)

        monkeypatch.setattr(bus._server, "_obey", listening)
        assert not diagnose(bus.port, well(cell), effort=Effort(pings=60, cycles=20)).is_well
        with bus.lock:
            assert [list(servo.events) for servo in bus.all_servos] == [[]] * len(bus.all_servos)
            for servo_id, servo in bus.servos.items():
                writable = [r for r in servo.memory.table.registers if r.writable]
                now = bytes(servo.memory._bytes)
                assert all(
                    before[servo_id][r.address : r.end] == now[r.address : r.end] for r in writable
                )
        np.testing.assert_allclose(bus.q, q, atol=1e-9)
    assert len(heard) > 100
    assert set(heard) <= ASKING


def test_what_would_change_a_servo_is_refused(virtual):
    with virtual("planar_2r") as (cell, bus), Stethoscope(bus.port, cell.chain.baud) as line:
        register = cell.chain.servos[0].servo_model.table["Goal Position"]
        for act in (
            lambda: line.write(1, register, 0),
            lambda: line.sync_write(GroupWrite([(1, register)]), [0]),
            lambda: line.reboot(1),
            lambda: line.clear_turns(1),
            lambda: line.factory_reset(1),
            lambda: line.listen(1, Instruction.REBOOT),
        ):
            with pytest.raises(RuntimeError, match="writes nothing"):
                act()


def test_a_port_that_vanishes_meanwhile_is_told(virtual):
    with virtual("wx250s", "pty") as (cell, bus):

        def pull():
            time.sleep(0.3)
            bus.unplug()

        puller = threading.Thread(target=pull)
        puller.start()
        diagnosis = diagnose(bus.port, well(cell), effort=Effort(pings=3000, cycles=2000))
        puller.join()
    assert {f.code for f in diagnosis.findings} <= {"P08", "P01"}
    assert diagnosis.findings


def test_two_programs_do_not_disturb_each_other(virtual):
    with virtual("planar_2r", "pty") as (cell, bus), Stethoscope(bus.port, cell.chain.baud):
        diagnosis = diagnose(bus.port, cell)
    assert [finding.code for finding in diagnosis.findings] == ["P04"]
    assert diagnosis.roll is None


def test_a_diagnosis_is_a_document(virtual):
    with virtual("planar_2r") as (cell, bus):
        with bus.lock:
            bus.servos[2].memory["Drive Mode"] = 1
        document = diagnose(bus.port, cell, arm="planar_2r", effort=LOOK).document()
    assert document["schema"] == "splinearm-doctor/1"
    assert (document["arm"], document["well"]) == ("planar_2r", False)
    (finding,) = document["findings"]
    assert (finding["code"], finding["severity"]) == ("S14", "error")
    assert [servo["id"] for servo in document["servos"]] == [1, 2]
    assert document["servos"][0]["voltage_v"] == 12.0
    assert document["rate_hz"]["predicted"] == pytest.approx(1316, abs=1)
