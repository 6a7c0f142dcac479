"""The loop on servos, through serial bytes."""

import numpy as np
import pytest

from splinearm.backends import centred
from splinearm.config import load_cell
from splinearm.control.clock import WallClock
from splinearm.control.follow import Loop, Outcome
from splinearm.control.guard import Guard
from splinearm.control.stop import StopRequest
from splinearm.drivers.dynamixel import DynamixelBus
from splinearm.drivers.servo_arm import ServoArm
from splinearm.errors import StaleFeedbackError
from splinearm.sim.virtual_bus import VirtualBus
from splinearm.trajectories.plan import plan_joint_move

pytestmark = pytest.mark.bus

MARGIN = 0.05
BUSY = 50
"""Cycles that a busy computer may miss in tests that are not about that."""


@pytest.fixture(params=["planar_2r", "wx250s"])
def cell(request):
    return load_cell(request.param)


@pytest.fixture
def bus(cell):
    with VirtualBus(cell.arm, centred(cell.chain), cell.poses["home"]) as made:
        yield made


@pytest.fixture
def driver(cell, bus):
    chain = centred(cell.chain)
    line = DynamixelBus(bus.port, chain.baud, margin=MARGIN)
    with ServoArm(chain, cell.arm.joint_names, cell.arm.limits, line) as made:
        yield made


def loop_on(driver, cell, observe=lambda _: None, bridge=BUSY):
    guard = Guard(cell.arm.limits)
    return Loop(driver=driver, clock=WallClock(), guard=guard, observe=observe, bridge=bridge)


def move_by(cell, driver, angle):
    return plan_joint_move(cell.arm.limits.scaled(0.3), driver.goal, driver.goal + angle)


def test_servos_follow_a_motion_and_hold_its_end(cell, bus, driver):
    goal = driver.goal + 0.15
    assert loop_on(driver, cell).follow(move_by(cell, driver, 0.15)) is Outcome.FINISHED
    np.testing.assert_allclose(driver.goal, goal, atol=1e-9)
    np.testing.assert_allclose(bus.q, goal, atol=0.08)
    assert all(servo.torque_on for servo in bus.servos.values() if servo.servo_id < 9)


def test_a_servo_that_dies_stops_the_arm_and_is_named_and_the_arm_goes_on_after_it_is_back(
    cell, bus, driver
):
    def cut(cycle):
        if cycle.index >= 15:
            bus.servos[2].mute = True

    start = driver.goal
    with pytest.raises(StaleFeedbackError, match="servo 2"):
        loop_on(driver, cell, cut, bridge=10).follow(move_by(cell, driver, 0.3))
    assert bus.servos[2].torque_on
    assert bus.servos[1].torque_on
    assert (driver.goal - start > 0.0).all()
    assert (driver.goal - start < 0.3).all()
    bus.servos[2].mute = False
    assert loop_on(driver, cell).follow(move_by(cell, driver, -0.05)) is Outcome.FINISHED


def test_a_stop_leaves_the_servos_holding_on_the_path(cell, bus, driver):
    stop = StopRequest()

    def ask(cycle):
        if cycle.index >= 20:
            stop.request()

    start, written = driver.goal, []

    def observe(cycle):
        ask(cycle)
        written.append(cycle.setpoint.q)

    assert (
        loop_on(driver, cell, observe).follow(move_by(cell, driver, 0.3), stop) is Outcome.STOPPED
    )
    share = (np.array(written) - start) / 0.3
    np.testing.assert_allclose(share, share[:, :1] * np.ones(cell.arm.n), atol=1e-9)
    assert 0.0 < share[-1, 0] < 1.0
    assert bus.servos[1].torque_on


def approach(cell, driver, q):
    return plan_joint_move(cell.arm.limits.scaled(0.3), driver.goal, q)


@pytest.mark.parametrize("cell", ["planar_2r"], indirect=True)
def test_an_overload_stops_the_arm_on_its_path_and_after_it_is_recovered_the_motion_goes_on(
    cell, bus, driver
):
    def overload(cycle):
        if cycle.index >= 20 and bus.servos[2].torque_on:
            with bus.lock:
                bus.servos[2].fail("overload")

    motion = move_by(cell, driver, 0.3)
    written = []

    def observe(cycle):
        written.append(cycle.setpoint.q)
        overload(cycle)

    ending = loop_on(driver, cell, observe).carry_out(motion)
    assert ending.outcome is Outcome.FAILED
    assert "servo 2" in str(ending.fault)
    assert not bus.servos[2].torque_on
    assert bus.servos[1].torque_on
    share = (np.array(written) - motion.q_start) / 0.3
    np.testing.assert_allclose(share, share[:, :1] * np.ones(cell.arm.n), atol=1e-9)
    driver.recover()
    assert bus.servos[2].torque_on
    rest = ending.stopped.remaining()
    loop_on(driver, cell).follow(approach(cell, driver, rest.q_start))
    assert loop_on(driver, cell).follow(rest) is Outcome.FINISHED
    np.testing.assert_allclose(driver.goal, motion.q_goal, atol=1e-6)
