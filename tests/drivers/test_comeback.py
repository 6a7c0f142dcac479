"""Fault, stop along the path, mended, taken up again, gone on: in one program."""

import time

import numpy as np
import pytest

from splinearm.backends import centred
from splinearm.config import load_cell
from splinearm.control.clock import WallClock
from splinearm.control.follow import Loop, Outcome
from splinearm.control.guard import Guard, Tolerances
from splinearm.drivers.dynamixel import DynamixelBus
from splinearm.drivers.servo_arm import ServoArm
from splinearm.errors import BusTimeoutError, MotionError, PortError, ServoError
from splinearm.sim.virtual_bus import VirtualBus
from splinearm.trajectories.plan import plan_joint_move
from splinearm.units import DEG

pytestmark = pytest.mark.bus

MARGIN = 0.03
PATIENT = 30
"""Cycles that may be missed: the computer that runs the tests may be busy."""
STILL = 0.5 * DEG
AT = 15
"""Cycle in which things go wrong."""


@pytest.fixture
def cell():
    return load_cell("planar_2r")


@pytest.fixture
def bus(cell):
    chain = centred(cell.chain)
    with VirtualBus(cell.arm, chain, cell.poses["home"], transport="socket") as made:
        yield made


@pytest.fixture
def arm(cell, bus):
    chain = centred(cell.chain)
    line = DynamixelBus(bus.port, chain.baud, margin=MARGIN)
    with ServoArm(chain, cell.arm.joint_names, cell.arm.limits, line) as made:
        yield made


class Course:
    """A motion, what goes wrong on its way, and the rest of it."""

    def __init__(self, cell, arm) -> None:
        self.cell, self.arm = cell, arm
        self.start = arm.goal
        self.goal = arm.goal + 0.6
        self.limits = cell.arm.limits.scaled(0.3)

    def follow(self, motion, observe=lambda _: None) -> Outcome:
        # a joint without torque may fall: what is looked at here is that the driver says so
        guard = Guard(self.cell.arm.limits, Tolerances(path=1.0))
        loop = Loop(
            driver=self.arm, clock=WallClock(), guard=guard, observe=observe, bridge=PATIENT
        )
        return loop.follow(motion)

    def until(self, wrong) -> MotionError:
        """Go until something is wrong; give the fault."""

        due = [wrong]  # the very cycle may be skipped on a busy computer

        def observe(cycle):
            if due and cycle.index >= AT:
                due.pop()()

        with pytest.raises(MotionError) as caught:
            self.follow(plan_joint_move(self.limits, self.start, self.goal), observe)
        return caught.value

    def go_on(self, fault: MotionError) -> None:
        """Go back to the path, then along the rest of it."""
        left = fault.stopped
        assert 0.0 < left.t < left.trajectory.duration
        back = plan_joint_move(self.limits, self.arm.goal, left.q)
        assert self.follow(back) is Outcome.FINISHED
        assert self.follow(left.remaining()) is Outcome.FINISHED
        np.testing.assert_allclose(self.arm.goal, self.goal, atol=1e-9)


def torques(bus) -> list[bool]:
    return [bool(servo.torque_on) for servo in bus.all_servos]


@pytest.mark.parametrize(
    "cause", ["overload", pytest.param("electrical shock", marks=pytest.mark.slow)]
)
def test_a_servo_that_stops_itself_is_recovered_and_the_motion_goes_on(cell, bus, arm, cause):
    course = Course(cell, arm)

    def fail():
        with bus.lock:
            bus.servos[2].fail(cause)

    fault = course.until(fail)
    assert isinstance(fault.__cause__, ServoError)
    assert f"servo 2 (joint2): it reports {cause}" in str(fault)
    assert torques(bus) == [True, False]
    before = bus.q
    [found] = arm.recover()
    assert found.causes == (cause,)
    assert torques(bus) == [True, True]
    np.testing.assert_allclose(bus.q, before, atol=STILL)
    course.go_on(fault)


def test_a_port_that_comes_back_under_another_name_is_taken_up_again(cell, bus, arm):
    course = Course(cell, arm)
    fault = course.until(bus.unplug)
    assert isinstance(fault.__cause__, PortError)
    with pytest.raises(PortError):
        arm.reconnect()
    time.sleep(0.3)
    assert all(servo.tripped for servo in bus.all_servos)
    rest = bus.q
    arm.reconnect(bus.plug_in())
    time.sleep(0.1)
    np.testing.assert_allclose(bus.q, rest, atol=STILL)
    assert torques(bus) == [True, True]
    course.go_on(fault)


def test_a_servo_that_was_without_power_is_taken_up_again(cell, bus, arm):
    course = Course(cell, arm)

    def pull():
        bus.servos[2].unplugged = True

    fault = course.until(pull)
    assert "servo 2 (joint2)" in str(fault)
    with pytest.raises(BusTimeoutError, match=r"servo 2 \(joint2\)"):
        arm.reconnect()
    with bus.lock:
        bus.servos[2].power_cycle()
        bus.servos[2].unplugged = False
    time.sleep(0.4)
    assert torques(bus) == [True, False]
    arm.reconnect()
    assert torques(bus) == [True, True]
    course.go_on(fault)


def test_an_arm_whose_supply_dipped_is_recovered(cell, bus, arm):
    course = Course(cell, arm)

    def dip():
        with bus.lock:
            for servo in bus.all_servos:
                servo.power_cycle()

    fault = course.until(dip)
    assert torques(bus) == [False, False]
    assert "torque" in str(fault) or "does not answer" in str(fault)
    time.sleep(0.4)
    assert arm.recover() == ()
    assert torques(bus) == [True, True]
    course.go_on(fault)


def test_a_dead_servo_does_not_keep_the_others_from_their_goals(cell, bus, arm):
    course = Course(cell, arm)
    seen: list[float] = []

    def pull():
        bus.servos[2].unplugged = True

    def observe(cycle):
        if bus.servos[2].unplugged:
            seen.append(float(arm.last_seen.t[0]))
        elif cycle.index >= AT:
            pull()

    with pytest.raises(MotionError, match="servo 2"):
        course.follow(plan_joint_move(course.limits, course.start, course.goal), observe)
    assert len(seen) > 3
    assert np.mean(np.diff(seen) > 0.0) > 0.9  # joint 1 is heard in every cycle
    assert bus.servos[1].torque_on


def test_a_pause_of_the_computer_stops_the_servos_and_they_take_goals_again(cell, bus, arm):
    course = Course(cell, arm)
    fault = course.until(lambda: time.sleep(0.7))
    assert "busy" in str(fault)
    assert arm.watchdog_trips >= 2
    assert not any(servo.tripped for servo in bus.all_servos)
    course.go_on(fault)
