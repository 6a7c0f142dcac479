"""``splinearm guide``, and hands on virtual servos."""

import threading
import time

import numpy as np
import pytest

from splinearm.backends import open_arm
from splinearm.cli.main import main
from splinearm.config import load_cell
from splinearm.control.stop import StopRequest
from splinearm.errors import ConfigError
from splinearm.guiding import TOOL_SPEED, guide, tool_haste
from splinearm.sim.virtual_bus import VirtualBus
from splinearm.units import DEG

pytestmark = [pytest.mark.bus, pytest.mark.kernel]


@pytest.fixture(scope="module")
def cell():
    return load_cell("wx250s")


@pytest.fixture
def bus(cell):
    with VirtualBus(cell.arm, cell.chain, cell.poses["home"], transport="socket") as made:
        yield made


def test_an_arm_goes_where_a_hand_leads_it_and_holds_there(bus, cell):
    stop, seen = StopRequest(), []

    def hand() -> None:
        time.sleep(0.5)
        bus.push([1.2, 0.0, 0.0, 0.0, 0.0, 0.0])
        time.sleep(0.7)
        bus.push(None)
        time.sleep(0.3)
        stop.request()

    with open_arm(cell, bus.port) as station:
        start = station.driver.goal
        threading.Thread(target=hand).start()
        goal = guide(station, cell, stop=stop, observe=lambda state: seen.append(state.q))
        assert goal[0] - start[0] > 5.0 * DEG
        assert np.abs(goal[1:] - start[1:]).max() <= 5.0 * DEG
        np.testing.assert_allclose(bus.q, goal, atol=5.0 * DEG)
    assert len(seen) > 20
    assert all(servo.torque_on for servo in bus.all_servos if servo.servo_id < 9)


def test_the_haste_is_the_speed_of_the_tool(cell):
    q, qd, step = cell.poses["home"], np.full(6, 0.3), 1e-6
    way = cell.arm.fk(q + step * qd)[:3, 3] - cell.arm.fk(q - step * qd)[:3, 3]
    wanted = np.linalg.norm(way) / (2.0 * step) / TOOL_SPEED
    assert wanted < tool_haste(cell)(q, qd) == pytest.approx(wanted, rel=4e-3)


def test_an_arm_whose_weight_is_not_carried_is_refused(bus, cell):
    with (
        open_arm(cell, bus.port, feedforward="off") as station,
        pytest.raises(ConfigError, match="carried"),
    ):
        guide(station, cell)


def test_the_command_leads_until_it_is_stopped(bus, capsys, monkeypatch):
    monkeypatch.setattr(StopRequest, "requested", property(lambda self: True))
    assert main(["guide", "wx250s", "--port", bus.port]) == 0
    said = capsys.readouterr().out
    assert "lead it by hand" in said
    assert "the arm holds at" in said


def test_an_arm_without_a_port_says_what_to_give(capsys):
    assert main(["guide", "planar_2r"]) == 2
    assert "--on virtual" in capsys.readouterr().err
