"""Arms in the hand: what is read is kept, and in the end the arm holds, whatever happens."""

import threading

import numpy as np
import pytest

from splinearm.backends import open_arm
from splinearm.control.stop import StopRequest
from splinearm.errors import ConfigError, StaleFeedbackError
from splinearm.sim.virtual_bus import VirtualBus
from splinearm.teaching.leading import is_carried, lead, record

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
            lead(station, planar, fall_silent, limp=lambda: False)
    finally:
        bus.silent = False
    assert None in seen


def test_an_arm_of_no_servos_cannot_be_led(planar):
    with (
        open_arm(planar, "mujoco") as simulated,
        pytest.raises(ConfigError, match="only an arm of servos"),
    ):
        lead(simulated, planar, lambda state: None)
