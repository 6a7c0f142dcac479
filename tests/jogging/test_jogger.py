"""Arms that are jogged: in MuJoCo, on virtual servos, and when something is wrong."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from splinearm.backends import centred, open_arm
from splinearm.config import load_cell
from splinearm.control.stop import StopRequest
from splinearm.errors import ConfigError, MotionError, StaleFeedbackError
from splinearm.guiding import TOOL_SPEED
from splinearm.jogging import Jogger
from splinearm.sim.line_fault import LineFault
from splinearm.sim.virtual_bus import VirtualBus
from splinearm.units import DEG


@pytest.fixture(scope="module")
def cell():
    return load_cell("wx250s")


def _jog(cell, script, *, cycles=400, busy=None, **options):
    """Jog a simulated arm as quickly as the computer can; the script gets jogger and cycle."""
    stop, states = StopRequest(), []

    def observe(state):
        states.append(state)
        if len(states) > cycles:
            stop.request()
        else:
            script(jogger, len(states))

    with open_arm(cell, "mujoco") as opened:
        station = opened
        if busy is not None:
            station = replace(opened, clock=Busy(opened.clock, *busy))
        jogger = Jogger(station, cell, stop=stop, observe=observe, **options)
        jogger.run()
        return jogger, states, station.driver.read()


def test_an_arm_goes_as_wished_and_brakes_when_no_wish_comes_any_more(cell):
    def script(jogger, cycle):
        if cycle <= 100:
            jogger.tool([0.0, 0.1, 0.0, 0.0, 0.0, 0.0], lasts=0.05)

    jogger, states, state = _jog(cell, script, cycles=200)
    start, end = (cell.arm.fk(each.setpoint.q) for each in (states[0], states[-1]))
    way = end[:3, 3] - start[:3, 3]
    np.testing.assert_allclose(way, [0.0, 0.105, 0.0], atol=2e-3)
    np.testing.assert_allclose(end[:3, :3], start[:3, :3], atol=1e-6)
    last = max(k for k, each in enumerate(states) if each.moving)
    assert last <= 100 + 5 + round(jogger.stop_time * 100.0) + 1
    np.testing.assert_allclose(state.q, states[-1].setpoint.q, atol=1.0 * DEG)


def test_a_step_is_gone_whole_unless_it_is_braked(cell):
    def script(jogger, cycle):
        if cycle == 1:
            jogger.step_tool([0.0, 0.0, 0.01, 0.0, 0.0, 0.0], 0.123)
        elif cycle == 100:
            jogger.step_joints(np.eye(6)[0] * 10.0 * DEG, 0.5)
        elif cycle == 200:
            jogger.step_joints(np.eye(6)[0] * 10.0 * DEG, 1.0)
        elif cycle == 220:
            jogger.brake()

    _, states, _ = _jog(cell, script)
    places = [states[k].setpoint.q for k in (0, 98, 198, -1)]
    up = cell.arm.fk(places[1])[:3, 3] - cell.arm.fk(places[0])[:3, 3]
    np.testing.assert_allclose(up, [0.0, 0.0, 0.01], atol=1e-8)
    np.testing.assert_allclose(places[2] - places[1], np.eye(6)[0] * 10.0 * DEG, atol=1e-9)
    assert 1.0 * DEG < places[3][0] - places[2][0] < 3.0 * DEG


def test_wishes_beyond_what_is_allowed_are_slowed_and_said(cell):
    said = set()

    def script(jogger, cycle):
        if cycle < 300:
            jogger.joints([3.0, 0.0, 0.0, 0.0, 0.0, 0.0])
        if jogger.state.hindrance is not None:
            said.add(jogger.state.hindrance.broken.value)

    _, states, _ = _jog(cell, script)
    speeds = [np.linalg.norm(cell.arm.jacobian(s.setpoint.q)[:3] @ s.setpoint.qd) for s in states]
    assert 0.2 * TOOL_SPEED < max(speeds) <= TOOL_SPEED
    assert said & {"tool", "velocity"}


def test_wrong_wishes_are_refused(cell):
    with open_arm(cell, "mujoco") as station:
        with pytest.raises(ValueError, match="rate"):
            Jogger(station, cell, rate=0.0)
        jogger = Jogger(station, cell)
        with pytest.raises(RuntimeError, match="with-block"):
            jogger.state  # noqa: B018 - the access is the test
        for wrong in (
            lambda: jogger.joints([1.0]),
            lambda: jogger.tool([np.nan] * 6),
            lambda: jogger.tool([0.0] * 6, "world"),
            lambda: jogger.joints([0.0] * 6, lasts=0.0),
            lambda: jogger.step_joints([0.0] * 6, 0.0),
        ):
            with pytest.raises(ValueError, match="want"):
                wrong()
        with pytest.raises(ConfigError, match="no gripper"):
            jogger.grip(50.0)


def test_who_observes_may_fail_and_the_arm_still_brakes(cell):
    def script(jogger, cycle):
        jogger.joints([0.5, 0.0, 0.0, 0.0, 0.0, 0.0])
        if cycle == 50:
            raise KeyError("mine")

    with pytest.raises(MotionError, match="who observes"):
        _jog(cell, script)


def test_an_arm_outside_its_limits_is_not_jogged(cell):
    with open_arm(cell, "mujoco") as station:
        station.driver._inputs[:, 0] = cell.arm.limits.q_max + 0.1
        with pytest.raises(ConfigError, match="beyond the limit"):
            Jogger(station, cell)


@pytest.fixture
def bus(cell):
    home = cell.poses["home"]
    with VirtualBus(cell.arm, centred(cell.chain), home, transport="socket") as made:
        yield made


@pytest.mark.bus
def test_any_thread_may_jog_virtual_servos_on_a_noisy_line_and_the_gripper(bus, cell):
    bus.faults = (LineFault.parse("lost p=0.01"),)
    with open_arm(cell, bus.port) as station:
        start = station.driver.goal
        with Jogger(station, cell) as jogger:
            for _ in range(10):
                threading.Thread(
                    target=jogger.joints, args=([0.4, 0.0, 0.0, 0.0, 0.0, 0.0],)
                ).start()
                time.sleep(0.04)
            assert jogger.state.moving
            bus.faults = ()
            jogger.grip(60.0)
            while jogger.state.moving or not station.gripper.ready:
                time.sleep(0.02)
            with pytest.raises(ValueError, match="percent"):
                jogger.grip(101.0)
        # the block is left only when the arm rests, and holds
        goal = station.driver.goal
        assert goal[0] - start[0] > 5.0 * DEG
        assert jogger.ends
        assert jogger.fault is None
        assert station.gripper.look().goal == pytest.approx(60.0, abs=0.5)
    np.testing.assert_allclose(bus.q, goal, atol=2.0 * DEG)
    assert all(servo.torque_on for servo in bus.all_servos)


@pytest.mark.bus
def test_a_dead_servo_brakes_the_others_and_is_named(bus, cell):
    said = []
    with open_arm(cell, bus.port) as station:
        jogger = Jogger(station, cell, announce=said.append)
        with pytest.raises(MotionError, match="servo 4"), jogger:  # noqa: PT012
            jogger.joints([0.3, 0.0, 0.0, 0.0, 0.0, 0.0], lasts=10.0)
            time.sleep(0.3)
            bus.faults = (LineFault.parse("dead id=4"),)
            while not jogger.ends:
                time.sleep(0.02)
        assert any("brakes and holds" in line for line in said)
        goal = station.driver.goal
        bus.faults = ()
    np.testing.assert_allclose(bus.q[0], goal[0], atol=2.0 * DEG)


class Busy:
    """The clock of a computer that pauses once, at a cycle, for a time."""

    def __init__(self, clock, at, pause) -> None:
        self.clock, self.left, self.pause = clock, at, pause

    def now(self):
        return self.clock.now()

    def wait_until(self, t):
        self.left -= 1
        if self.left == 0:
            self.clock.wait_until(t + self.pause)
            return self.pause
        return self.clock.wait_until(t)


@pytest.mark.parametrize(("pause", "what"), [(0.05, "brakes"), (0.5, "stands")])
def test_a_busy_computer_lets_the_arm_brake_or_stay_where_it_came_to_rest(cell, pause, what):
    said = []

    def script(jogger, cycle):
        if cycle == 1:
            jogger.joints([0.5, 0.0, 0.0, 0.0, 0.0, 0.0], lasts=10.0)
        elif cycle == 110:
            jogger.joints([-0.5, 0.0, 0.0, 0.0, 0.0, 0.0], lasts=10.0)

    _, states, _ = _jog(cell, script, cycles=150, busy=(50, pause), announce=said.append)
    assert said == [f"this computer was busy for {pause * 1e3:.0f} ms: the arm {what}"]
    q = np.array([state.setpoint.q[0] for state in states])
    assert q[48] - q[47] == pytest.approx(0.5 * 0.01)
    assert bool(q[49] == q[48]) == (what == "stands")
    assert not states[100].moving
    assert q[-1] < q[100] - 1.0 * DEG  # and it goes on as is wished then


@pytest.mark.bus
def test_servos_that_stopped_meanwhile_are_held_where_they_are(bus, cell):
    with open_arm(cell, bus.port) as station:
        busy = replace(station, clock=Busy(station.clock, 40, 0.6))
        with pytest.raises(StaleFeedbackError, match="busy"), Jogger(busy, cell) as jogger:  # noqa: PT012
            jogger.joints([0.5, 0.0, 0.0, 0.0, 0.0, 0.0], lasts=10.0)
            while not jogger.ends:
                time.sleep(0.02)
    assert all(servo.torque_on for servo in bus.all_servos if servo.servo_id < 9)
