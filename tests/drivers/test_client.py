"""Single instructions, in both protocols, on virtual servos behind a socket."""

import os
import threading
import tty

import numpy as np
import pytest

from splinearm.drivers.bus import PingReply
from splinearm.drivers.chain import ServoChain, ServoRole, ServoSpec
from splinearm.drivers.client import ServoClient
from splinearm.drivers.cyclic import GroupRead, GroupWrite
from splinearm.drivers.dialect import protocol_of, protocols_of
from splinearm.drivers.dynamixel import DynamixelBus, scan
from splinearm.drivers.groups import BulkRead
from splinearm.drivers.link import SerialLink
from splinearm.drivers.model import servo_model
from splinearm.drivers.packets import encode_status
from splinearm.errors import BusTimeoutError, PacketError, PortError, ServoError
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.dh import DHConvention, DHLink
from splinearm.sim.virtual_bus import VirtualBus

pytestmark = pytest.mark.bus

AX, XM = servo_model("AX-12A").table, servo_model("XM430-W350").table


def spec(servo_id: int, model: str, role=ServoRole.GRIPPER, **changes) -> ServoSpec:
    facts = {"name": f"s{servo_id}", "zero_ticks": 512 if model == "AX-12A" else 2048}
    return ServoSpec(servo_id=servo_id, model=model, role=role, **(facts | changes))


@pytest.fixture
def chain():
    return ServoChain(
        servos=(
            spec(1, "XM430-W350", ServoRole.LEADER, joint="waist"),
            spec(5, "AX-12A"),
            spec(9, "AX-12A"),
        )
    )


@pytest.fixture
def virtual(chain):
    limits = JointLimits(
        names=("waist",),
        kinds=(JointKind.REVOLUTE,),
        q_min=np.array([-2.0]),
        q_max=np.array([2.0]),
        qd_max=np.array([4.0]),
        qdd_max=np.array([20.0]),
    )
    rows = [DHLink("waist", 0.1, 0.0, 0.0, 0.0)]
    arm = Arm.from_dh("arm", rows, DHConvention.STANDARD, limits)
    with VirtualBus(arm, chain, transport="socket", wire_time=False) as bus:
        yield bus


@pytest.fixture
def bus(virtual, chain):
    with DynamixelBus(virtual.port, margin=0.1, protocols=protocols_of(chain)) as opened:
        yield opened


def test_servos_of_both_protocols_say_what_they_are(bus):
    assert bus.ping(1)[:2] == (1, 1020)
    found = bus.ping(5)
    assert (found.servo_id, found.model_number, found.protocol) == (5, 12, 1)


def test_registers_of_both_protocols_are_read_and_written(bus, virtual):
    bus.write(5, AX["Goal Position"], 300)
    bus.write(1, XM["Goal Position"], 1000)
    assert (bus.read(5, AX["Goal Position"]), bus.read(1, XM["Goal Position"])) == (300, 1000)
    assert virtual.servos[5].memory["Goal Position"] == 300


def test_groups_of_both_protocols_are_read_and_written_each_in_its_own(bus, virtual):
    targets = [(1, XM["Goal Position"]), (5, AX["Goal Position"]), (9, AX["Goal Position"])]
    bus.sync_write(GroupWrite(targets), [1000, 300, 400])
    reads = [BulkRead(i, register.address, register.size) for i, register in targets]
    replies = bus.sync_read(GroupRead(reads, fast=False))
    held = {i: register.decode(replies[i].data) for i, register in targets}
    assert held == {1: 1000, 5: 300, 9: 400}
    with pytest.raises(ValueError, match="values"):
        bus.sync_write(GroupWrite(targets), [1, 2])


def test_a_refusal_in_protocol_1_is_told_as_one_of_2(bus):
    with pytest.raises(ServoError, match=r"Goal Position = 1500 refused: .*range") as caught:
        bus.write(5, AX["Goal Position"], 1500)
    assert caught.value.servo_id == 5


def test_a_scan_finds_both_protocols(virtual):
    found = scan(virtual.port, (1_000_000, 57_600))
    assert [(s.servo_id, s.model, s.protocol) for s in found] == [
        (1, "XM430-W350", 2),
        (5, "AX-12A", 1),
        (9, "AX-12A", 1),
    ]


def test_turns_are_cleared_and_servos_rebooted(bus, virtual):
    bus.clear_turns(1)
    bus.write(1, XM["Torque Enable"], 1)
    bus.reboot(1)
    assert virtual.servos[1].memory["Torque Enable"] == 0


def test_a_factory_reset_says_what_it_cannot_keep(bus):
    with pytest.raises(ValueError, match="keep_id"):
        bus.factory_reset(5)
    with pytest.raises(ValueError, match="keep_baud"):
        bus.factory_reset(1, keep_id=False)


def test_a_ping_is_repeated_as_often_as_wanted(virtual):
    with DynamixelBus(virtual.port, margin=0.005) as bus:
        with pytest.raises(BusTimeoutError):
            bus.ping(77, tries=1)
        assert bus.retries[77] == 0
        with pytest.raises(BusTimeoutError):
            bus.ping(77)
        assert bus.retries[77] == 2


def test_a_protocol_that_is_none_is_refused(bus):
    with pytest.raises(ValueError, match="want 1 or 2"):
        bus.speak({1: 3})


def test_a_bus_that_vanishes_comes_back_under_another_name(bus, virtual):
    virtual.unplug()
    with pytest.raises(PortError, match="connection is lost"):
        bus.ping(1)
    with pytest.raises(PortError, match="nobody serves it"):
        bus.reopen()
    bus.reopen(virtual.plug_in())
    assert bus.port == virtual.port
    assert bus.ping(5).protocol == 1
    assert bus.ping(1) == PingReply(1, 1020, bus.ping(1).firmware)


def test_the_protocol_of_a_servo_is_told_by_its_settings_its_chain_or_its_model():
    assert protocol_of(spec(1, "XM430-W350"), 2.0) == 2
    assert protocol_of(spec(1, "XM430-W350"), 1.0) == 1
    assert protocol_of(spec(1, "XM430-W350", settings={"Protocol Type": 1}), 2.0) == 1
    assert protocol_of(spec(1, "AX-12A"), 2.0) == 1
    assert protocol_of(spec(1, "XL330-M077"), 1.0) == 2


class Answering:
    """A servo at the other end of a line, which answers as it is told, one instruction a time."""

    def __init__(self, *answers):
        self.heard = 0
        self._near, self._far = os.openpty()
        tty.setraw(self._far)
        os.set_blocking(self._far, False)
        self._answers = answers
        self._thread = threading.Thread(target=self._serve)
        self.client = ServoClient(SerialLink("/dev/ttyX", self._far, 1_000_000, 0.05))

    def _serve(self):
        for answer in self._answers:
            os.read(self._near, 1000)
            self.heard += 1
            os.write(self._near, answer)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._thread.join()
        os.close(self._near)
        os.close(self._far)


LATE = encode_status(1, params=bytes((1, 2, 3, 4)))
"""What is left of a reading of four bytes that was given up too soon."""
TAKEN = encode_status(1)


def test_a_late_reading_is_no_acknowledgement():
    with Answering(LATE, TAKEN) as servo:
        servo.client.write(1, XM["Goal Position"], 7)
    assert servo.heard == 2, "it was written again"


def test_an_acknowledgement_is_no_reading():
    with Answering(TAKEN + LATE) as servo:
        assert servo.client.read(1, XM["Goal Position"]) == 0x04030201
    with (
        Answering(TAKEN, TAKEN, TAKEN) as servo,
        pytest.raises(PacketError, match=r"one with 0 where a status with 4 bytes of servo 1"),
    ):
        servo.client.read(1, XM["Goal Position"])


def test_a_refusal_answers_whatever_was_asked():
    with (
        Answering(encode_status(1, error=4)) as servo,
        pytest.raises(ServoError, match="range"),
    ):
        servo.client.read(1, XM["Goal Position"])
