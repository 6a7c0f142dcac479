"""What a servo does when the bus falls silent."""

from dataclasses import replace

import pytest

from splinearm.sim.choice import TripStop
from splinearm.sim.rule import Refusal


def armed(make_bench, **settings):
    bench = make_bench(Operating_Mode=1, **settings)
    bench.set("Torque Enable", 1)
    bench.set("Goal Velocity", 100)
    bench.set("Bus Watchdog", 3)
    return bench


def test_a_silent_bus_stops_the_servo_after_its_time(make_bench):
    bench = armed(make_bench)
    bench.run(0.059)
    assert bench.get("Bus Watchdog") == 3
    bench.run(0.003)
    assert bench.get("Bus Watchdog") == 255
    bench.run(0.5)
    assert bench.get("Present Velocity") == 0
    assert bench.get("Torque Enable") == 1  # it stops; it does not let go


def test_any_packet_on_the_bus_feeds_the_watchdog(make_bench):
    bench = armed(make_bench)
    for _ in range(20):
        bench.run(0.05)
        bench.servo.heard()
    assert bench.get("Bus Watchdog") == 3


def test_tripped_it_takes_no_goal_until_zero_is_written(make_bench):
    bench = armed(make_bench)
    bench.run(0.2)
    for goal in ("Goal Velocity", "Goal Position", "Goal PWM", "Goal Current"):
        assert bench.set(goal, 0) == Refusal.DATA_RANGE
    assert bench.set("Bus Watchdog", 5) == Refusal.DATA_RANGE
    assert bench.set("LED", 1) == 0
    assert bench.set("Bus Watchdog", 0) == 0
    bench.run(0.5)
    assert bench.get("Present Velocity") == 0  # until a new goal comes
    assert bench.set("Goal Velocity", 50) == 0
    bench.run(1.0)
    assert bench.get("Present Velocity") == pytest.approx(50, abs=2)


def test_in_position_mode_a_trip_holds_where_the_servo_is(bench):
    bench.set("Profile Velocity", 40)
    bench.set("Torque Enable", 1)
    bench.set("Goal Position", 4000)
    bench.set("Bus Watchdog", 1)
    bench.run(0.5)
    stopped = bench.get("Present Position")
    assert bench.get("Bus Watchdog") == 255
    bench.run(0.5)
    assert bench.get("Present Position") == pytest.approx(stopped, abs=3)
    assert stopped < 2300


def tripped_on_its_way(make_bench, how, **settings):
    bench = make_bench(**settings)
    bench.servo.choices = replace(bench.servo.choices, on_trip=how)
    bench.set("Profile Velocity", 60)
    bench.set("Torque Enable", 1)
    bench.set("Goal Position", 3800)
    bench.set("Bus Watchdog", 10)
    bench.run(0.21)
    assert bench.get("Bus Watchdog") == 255
    return bench


def test_told_to_brake_it_is_at_rest_within_a_unit_and_stays_there(make_bench):
    bench = tripped_on_its_way(make_bench, TripStop.BRAKE)
    assert abs(bench.servo.shaft.speed) > 0.1
    bench.run(0.02)
    stopped = bench.servo.position
    assert abs(bench.servo.shaft.speed) < 0.05
    bench.run(0.5)
    assert bench.servo.position == pytest.approx(stopped, abs=2)


def test_told_to_hold_it_comes_back_to_where_it_tripped(make_bench):
    bench = tripped_on_its_way(make_bench, TripStop.HOLD)
    goal = bench.servo.law.position
    bench.run(0.5)
    assert bench.servo.position == pytest.approx(goal, abs=3)


def test_some_go_on_to_their_goal_although_they_tripped(make_bench):
    bench = tripped_on_its_way(make_bench, TripStop.GO_ON)
    bench.run(2.0)
    assert bench.servo.position == pytest.approx(3800, abs=4)
    assert bench.set("Goal Position", 2000) == Refusal.DATA_RANGE


def test_some_move_by_their_homing_offset_first(make_bench):
    bench = tripped_on_its_way(make_bench, TripStop.BY_HOMING_OFFSET, Homing_Offset=300)
    goal = bench.servo.law.position
    assert goal == pytest.approx(bench.servo.position - 300, abs=20)
    bench.run(0.6)
    assert bench.servo.position == pytest.approx(goal, abs=4)


@pytest.mark.parametrize("mode", [0, 1, 16])
def test_in_every_mode_a_trip_brakes(make_bench, mode):
    bench = make_bench(Operating_Mode=mode)
    bench.set("Torque Enable", 1)
    goal = {0: "Goal Current", 1: "Goal Velocity", 16: "Goal PWM"}[mode]
    bench.set(goal, 100)
    bench.set("Bus Watchdog", 10)
    bench.run(0.195)
    assert bench.servo.shaft.speed > 0.2
    bench.run(0.06)
    assert abs(bench.servo.shaft.speed) < 0.05


def test_with_the_torque_off_the_watchdog_does_not_watch(bench):
    bench.set("Bus Watchdog", 1)
    bench.run(0.5)
    assert bench.get("Bus Watchdog") == 1
