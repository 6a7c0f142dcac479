"""Arms in the hand: what is read is kept, and in the end the arm holds, whatever happens."""

import threading

import numpy as np
import pytest

from splinearm.backends import open_arm
from splinearm.control.stop import StopRequest
from splinearm.errors import ConfigError, MotionError, StaleFeedbackError
from splinearm.sim.line_fault import LineFault
from splinearm.sim.virtual_bus import VirtualBus
from splinearm.teaching.leading import Limp, is_carried, lead, record

pytestmark = pytest.mark.bus


@pytest.fixture(scope="module")
def bus(planar):
    home = planar.poses["home"]
    with VirtualBus(planar.arm, planar.chain, home, transport="socket") as made:
        yield made


@pytest.fixture
def station(bus, planar):
    with open_arm(planar, bus.port, feedforward="full") as opened:
        yield opened


@pytest.fixture
def soon():
    """A request that comes after a while."""
    stop = StopRequest()
    timer = threading.Timer(0.3, stop.request)
    timer.start()
    yield stop
    timer.join()


@pytest.mark.parametrize("carried", [True, False])
def test_what_is_read_is_kept_and_the_arm_holds(bus, station, planar, soon, carried):
    assert is_carried(station, planar)
    found = record(station, planar, carried=carried, supported=True, stop=soon)
    assert found.names == planar.arm.joint_names
    assert len(found.t) + found.lost >= 15
    np.testing.assert_allclose(found.q[-1], planar.poses["home"], atol=0.05)
    assert all(servo.torque_on for servo in bus.all_servos)


def test_nobody_loses_torque_who_is_not_supported(bus, station, planar):
    with pytest.raises(ConfigError, match="support it"):
        record(station, planar, carried=False)
    assert all(servo.torque_on for servo in bus.all_servos)


def test_an_arm_that_does_not_answer_any_more_ends_it(bus, station, planar):
    seen = []

    def fall_silent(state):
        seen.append(state)
        bus.silent = len(seen) == 5 or bus.silent

    try:
        with pytest.raises(StaleFeedbackError):
            lead(station, planar, fall_silent, limp=Limp(wished=lambda: False))
    finally:
        bus.silent = False
    assert None in seen


def test_a_servo_that_cannot_be_held_at_once_is_told_and_tried_again(bus, station, planar):
    said, seen, stop = [], [], StopRequest()

    def silence(state):
        seen.append(state)
        if len(seen) == 5:
            bus.faults = (LineFault.parse("dead id=2"),)
            stop.request()

    def hear(words):
        said.append(words)
        bus.faults = ()

    lead(station, planar, silence, limp=Limp(wished=lambda: True, announce=hear), stop=stop)
    assert "NOT HELD: keep supporting it; servo 2" in said[0]
    assert said[1:] == ["the arm is held"]
    assert all(servo.torque_on for servo in bus.all_servos)


def test_an_arm_that_cannot_be_held_is_told_by_the_error(bus, station, planar, monkeypatch):
    monkeypatch.setattr("splinearm.teaching.leading._PATIENCE", 0.0)

    seen = []

    def silence(state):
        seen.append(state)
        if len(seen) == 5:
            bus.faults = (LineFault.parse("dead id=2"),)
            raise KeyError  # whatever it is

    try:
        with pytest.raises(MotionError, match="NOT HELD: keep supporting it"):
            lead(station, planar, silence, limp=Limp(wished=lambda: True))
    finally:
        bus.faults = ()


def test_an_arm_of_no_servos_cannot_be_led(planar):
    with (
        open_arm(planar, "mujoco") as simulated,
        pytest.raises(ConfigError, match="only an arm of servos"),
    ):
        lead(simulated, planar, lambda state: None)
