"""What a servo does that was not heard for long, and how an arm is taken up again."""

import numpy as np
import pytest

from splinearm.control.comeback import take_up
from splinearm.control.ending import Outcome
from splinearm.errors import (
    BusTimeoutError,
    FollowingError,
    HealthError,
    MotionError,
    PortError,
    ServoError,
)
from splinearm.sim.event import EventKind
from splinearm.units import DEG

pytestmark = pytest.mark.sim

SLOW = 20.0 * DEG
"""Speed that no joint has that does not jump, rad/s."""


def fastest(scene, number: int, since: float) -> float:
    motion = scene.servo(number).trace.motion().after(since)
    return float(np.abs(motion.speed).max(initial=0.0))


def trips(scene, number: int) -> int:
    return len(scene.servo(number).events.of(EventKind.WATCHDOG_TRIP))


def test_a_servo_that_stopped_alone_does_not_jump_to_its_goal_when_the_arm_holds(scene):
    here = scene()
    here.enter()
    ending = here.follow(here.motion(), lambda: here.line("dead", servo_id=2, lasting=0.3))
    assert ending.outcome is Outcome.FAILED
    assert trips(here, 2) == 1
    silent_until = here.virtual.rig.now - 0.1
    here.wait(0.5)
    assert fastest(here, 2, silent_until) < SLOW
    assert here.go_on(ending).outcome is Outcome.FINISHED


def test_a_servo_that_stopped_alone_while_the_plan_bridged_its_silence_is_noticed(scene):
    here = scene(rate=50.0, watchdog=0.06)
    here.enter()
    ending = here.follow(here.motion(), lambda: here.line("dead", servo_id=2, lasting=0.07))
    assert trips(here, 2) == 1
    assert isinstance(ending.fault.__cause__, ServoError)
    assert "servo 2 (joint2): it heard nothing for so long" in str(ending.fault)
    assert here.go_on(ending).outcome is Outcome.FINISHED


def test_a_servo_that_comes_back_after_the_arm_holds_is_noticed_before_it_may_jump(scene):
    here = scene()
    here.enter()
    ending = here.follow(here.motion(), lambda: here.line("dead", servo_id=2))
    here.calm()
    with pytest.raises(ServoError, match="its watchdog has stopped it"):
        here.go_on(ending)
    heard_again = here.virtual.rig.now
    here.arm.hold()
    here.wait(0.3)
    assert fastest(here, 2, heard_again) < SLOW
    assert here.go_on(ending).outcome is Outcome.FINISHED


def test_a_hardware_error_is_told_although_another_servo_is_dead(scene):
    here = scene()
    here.enter()

    def strike():
        here.servo(1).unplugged = True
        here.servo(2).fail("overload")

    ending = here.follow(here.motion(), strike)
    assert "servo 2 (joint2): it reports overload" in str(ending.fault)


@pytest.mark.parametrize("baud", [115_200, 57_600])
def test_on_a_slow_bus_the_watchdog_waits_for_some_cycles(scene, baud):
    here = scene("wx250s", baud=baud)
    here.enter()
    assert here.rate < 100.0
    assert here.follow(here.motion()).outcome is Outcome.FINISHED
    assert not any(trips(here, number) for number in here.joints)


STRIKES = {
    "overload": lambda scene: scene.servo(2).fail("overload"),
    "reboot": lambda scene: scene.servo(2).reboot(),
    "cable": lambda scene: setattr(scene.servo(2), "unplugged", True),
    "silence": lambda scene: setattr(scene.virtual, "silent", True),
    "port": lambda scene: setattr(scene.plug, "name", None),
    "pause": lambda scene: setattr(scene.clock, "pause", 0.3),
}


@pytest.mark.parametrize("what", STRIKES)
def test_an_arm_is_taken_up_again_by_what_stopped_it(scene, what):
    here = scene()
    here.enter()
    motion = here.motion()
    ending = here.follow(motion, lambda: STRIKES[what](here))
    name = here.plug.name
    if what in ("cable", "silence", "port"):
        with pytest.raises((BusTimeoutError, PortError)):
            take_up(here.arm, ending.fault)
    here.servo(2).unplugged = here.virtual.silent = False
    here.plug.name = name or here.arm._bus.port
    here.wait(0.5)
    take_up(here.arm, ending.fault)
    assert here.go_on(ending).outcome is Outcome.FINISHED
    here.wait(0.5)
    np.testing.assert_allclose(here.virtual.q, motion.q_goal, atol=0.5 * DEG)


def test_there_is_nothing_to_take_up_after_other_faults(scene):
    here = scene()
    here.enter()
    sent = []
    here.plug.server._hear = lambda frame, t: sent.append(frame)
    follows_badly = FollowingError("elbow", 1.0, 0.5, 0.1, 2.0)
    too_hot = MotionError("it is too hot")
    too_hot.__cause__ = HealthError(2, "elbow", "temperature", 80.0, 75.0, unit="degC", remedy="")
    for fault in (None, follows_badly, too_hot):
        take_up(here.arm, fault)
    assert not sent
