"""What a servo writes down of itself."""

from splinearm.sim.event import ASKED, EventKind, EventLog


def test_it_gives_events_of_a_kind_in_order():
    log = EventLog()
    log.add(0.1, EventKind.TORQUE_ON, ASKED)
    log.add(0.2, EventKind.TORQUE_OFF, "overload")
    log.add(0.3, EventKind.TORQUE_OFF, ASKED)
    assert [event.time for event in log] == [0.1, 0.2, 0.3]
    assert [event.cause for event in log.of(EventKind.TORQUE_OFF)] == ["overload", ASKED]
    assert [event.time for event in log.torque_lost()] == [0.2]
    log.clear()
    assert len(log) == 0


def test_a_goal_far_away_without_a_profile_is_a_jump(bench):
    bench.set("Torque Enable", 1)
    bench.set("Goal Position", 2060)
    assert bench.servo.events.of(EventKind.GOAL_JUMP) == []
    bench.run(0.1)
    bench.set("Goal Position", 2600)
    (jump,) = bench.servo.events.of(EventKind.GOAL_JUMP)
    assert jump.cause == "540 ticks"


def test_with_a_profile_a_far_goal_is_none(bench):
    bench.set("Profile Velocity", 50)
    bench.set("Torque Enable", 1)
    bench.set("Goal Position", 3000)
    assert bench.servo.events.of(EventKind.GOAL_JUMP) == []


def test_a_goal_from_before_is_a_jump_when_the_torque_comes_on(bench):
    bench.set("Goal Position", 2600)
    bench.set("Torque Enable", 1)
    assert len(bench.servo.events.of(EventKind.GOAL_JUMP)) == 1


def test_reboots_and_trips_are_written_down(bench):
    bench.set("Torque Enable", 1)
    bench.set("Bus Watchdog", 1)
    bench.run(0.05)
    bench.servo.reboot()
    assert bench.servo.events.of(EventKind.WATCHDOG_TRIP)[0].cause == "brake"
    assert bench.servo.events.of(EventKind.REBOOT)[0].cause == "reboot"
