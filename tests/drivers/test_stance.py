from dataclasses import replace

import numpy as np
import pytest

from splinearm.drivers.servo_arm import ServoArm
from splinearm.errors import ServoError

pytestmark = pytest.mark.bus

TICK = 2 * np.pi / 4096


def test_every_goal_is_where_the_servo_stands_before_its_torque_comes_on(open_arm, line):
    for servo_id, ticks in ((1, 2500), (2, 1800), (3, 1790), (4, 2222)):
        line.servos[servo_id]["Present Position"] = ticks
    with open_arm():
        order = [entry for entry in line.writes if entry[1] in ("Goal Position", "Torque Enable")]
    goals = [entry for entry in order if entry[1] == "Goal Position"]
    assert order[: len(goals)] == goals
    assert dict(goal[::2] for goal in goals) == {1: 2500, 2: 1800, 3: 1800, 4: 2222}
    assert all(servo["Torque Enable"] for servo in line.servos.values())


def test_an_arm_that_already_holds_keeps_its_goals_and_does_not_sink(open_arm, line):
    for servo in line.servos.values():
        servo["Goal Position"], servo["Present Position"] = 2048, 2040
        servo["Torque Enable"], servo.stuck = 1, True
    with open_arm():
        assert all(servo["Goal Position"] == 2048 for servo in line.servos.values())
        assert line.written("Goal Position") == []
    line.servos[1]["Present Position"] = 1900
    with open_arm():
        pass
    assert (1, 1900) in line.written("Goal Position")


def test_a_servo_turned_by_hand_beyond_its_turn_does_not_jump(open_arm, line):
    line.servos[1]["Present Position"] = 2100 + 3 * 4096
    with open_arm():
        assert (1, 2100) in line.written("Goal Position")


def test_a_shadow_that_would_fight_its_leader_is_refused(open_arm, line):
    line.servos[3]["Present Position"] = 2048 + 60
    with pytest.raises(ServoError, match="60 ticks from its leader 'shoulder'"), open_arm():
        pass
    assert line.written("Torque Enable") == []


def test_a_shadow_without_secondary_id_gets_goals_of_its_own(open_arm, make_chain, line, setpoint):
    chain = make_chain()
    alone = replace(chain.servo("shadow"), settings={"Drive Mode": 1}, zero_ticks=1000)
    line.servos[3]["Secondary(Shadow) ID"] = 255
    line.servos[3]["Present Position"] = 1000
    servos = tuple(alone if servo.name == "shadow" else servo for servo in chain.servos)
    with open_arm(replace(chain, servos=servos)) as arm:
        arm.write(setpoint(0.0, 100 * TICK, 0.0))
        arm.read()  # answered after what was written
        assert line.servos[2]["Goal Position"] == 2148
        assert line.servos[3]["Goal Position"] == 1100


def test_limits_that_the_servo_does_not_allow_are_refused(open_arm, line):
    line.servos[1]["Max Position Limit"] = 2500
    with pytest.raises(ServoError, match="takes goals from 0 to 2500 ticks"), open_arm():
        pass


def test_a_joint_that_rests_where_its_servo_takes_no_goal_is_refused(
    open_arm, line, make_limits, caplog
):
    line.servos[1]["Min Position Limit"] = 1948
    limits = make_limits(-0.1, 0.1)
    line.servos[1]["Present Position"] = 1900
    with pytest.raises(ServoError, match="move the joint back by hand"), open_arm(limits=limits):
        pass
    line.servos[1]["Present Position"] = 1940
    with open_arm(limits=limits):
        assert (1, 1948) in line.written("Goal Position")
    assert "held at the limit" in caplog.text


def test_a_servo_that_lost_its_turns_is_where_it_was(open_arm, make_chain, line, setpoint):
    line.servos[1]["Operating Mode"] = 4
    line.servos[1]["Present Position"] = 2148 - 2 * 4096
    with open_arm(make_chain(settings={"Operating Mode": 4})) as arm:
        assert arm.read().q[0] == pytest.approx(100 * TICK)
        arm.write(setpoint(200 * TICK, 0.0, 0.0))
        arm.read()  # answered after what was written
        assert line.servos[1]["Goal Position"] == 2248 - 2 * 4096


def test_a_goal_that_is_not_taken_leaves_the_torque_off(open_arm, line):
    line.servos[3]["Secondary(Shadow) ID"] = 2
    servo = line.servos[4]
    servo.write = lambda address, data: (0, servo.model.table.at(address).name, 0)
    with pytest.raises(ServoError, match="Goal Position is 0 after 2048 was written"), open_arm():
        pass
    assert line.written("Torque Enable") == []


def test_hold_after_release_begins_where_the_arm_was_moved_by_hand(open_arm, line, setpoint):
    with open_arm() as arm:
        arm.release()
        line.servos[1]["Present Position"] = 2600
        line.writes.clear()
        arm.hold()
        order = [e for e in line.writes if e[1] in ("Goal Position", "Torque Enable")]
        assert order[0] == (1, "Goal Position", 2600)
        assert [e[1] for e in order[:4]] == ["Goal Position"] * 4
        arm.write(setpoint(552 * TICK, 0.0, 0.0))
    assert line.servos[1]["Present Position"] == 2600


def test_a_goal_that_was_lost_on_the_way_is_written_again(bus_of, setpoint):
    bus, arm = bus_of()
    lost, sync_write = [], bus.sync_write

    def forgetful(group, values):
        if not lost and group.blocks[0].fields[0].name == "Goal Position":
            lost.append(values)
        else:
            sync_write(group, values)

    bus.sync_write = forgetful
    with arm:
        assert lost
        for servo in bus.servos.values():
            assert servo.torque_on
            assert servo.memory["Goal Position"] == servo.position


@pytest.fixture
def bus_of(make_chain, make_limits, make_direct, in_their_time):
    def make():
        bus = make_direct(make_chain())
        in_their_time(bus)
        for shaft in bus.shafts.values():
            shaft.angle = 0.3
        limits = make_limits()
        return bus, ServoArm(make_chain(), limits.names, limits, bus)

    return make
