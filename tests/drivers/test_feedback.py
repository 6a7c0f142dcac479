import time

import numpy as np
import pytest

from splinearm.errors import BusTimeoutError, PacketError, ServoError

pytestmark = pytest.mark.bus

SHORT = 0.02  # margin where an answer is not to come, s
TICK = 2 * np.pi / 4096


def test_state_is_in_si_and_in_the_order_of_the_joints(open_arm, line):
    for servo_id, ticks in ((1, 2148), (2, 1948), (3, 1948), (4, 2048)):
        line.servos[servo_id]["Present Position"] = ticks
    line.servos[1]["Present Current"] = -100
    line.servos[4]["Present Velocity"] = 10
    with open_arm() as arm:
        before = time.monotonic()
        state = arm.read()
        assert before <= state.t <= time.monotonic()
    assert state.q == pytest.approx([100 * TICK, -100 * TICK, 0.0])
    assert state.qd == pytest.approx([0.0, 0.0, 10 * 0.229 * 2 * np.pi / 60])
    assert state.current[:2] == pytest.approx([-0.269, 0.0])
    assert np.isnan(state.current[2])


def test_a_lost_servo_is_named_and_the_others_are_still_seen(open_arm, line):
    with open_arm(margin=SHORT) as arm:
        arm.read()
        line.silent.add(2)
        line.servos[1]["Present Position"] = 2148
        with pytest.raises(BusTimeoutError, match=r"servo 2 \(shoulder\) .*Present Position"):
            arm.read()
        begun = time.monotonic()
        with pytest.raises(BusTimeoutError):
            arm.read()
        seen = arm.last_seen
        assert seen.q[0] == pytest.approx(100 * TICK)
        assert (seen.t >= begun).tolist() == [True, False, True]
        assert arm.stats[2].timeouts == 2
        assert (arm.stats[1].timeouts, arm.stats[1].reads) == (0, arm.stats[2].reads)
        line.silent.clear()
        assert arm.read().q[0] == pytest.approx(100 * TICK)


def test_a_damaged_answer_is_counted_as_such(open_arm, line):
    line.knows_fast = False
    with open_arm(margin=SHORT) as arm:
        with pytest.raises(BusTimeoutError):
            arm.read()  # a fast read that nobody answers
        line.damaged.add(4)
        with pytest.raises(PacketError, match=r"servo 4 \(elbow\)"):
            arm.read()
        assert arm.stats[4].crc_errors == 1
        line.damaged.clear()


def test_an_error_that_latches_on_the_way_is_named(open_arm, line):
    with open_arm() as arm:
        line.servos[2]["Hardware Error Status"] = 0x20
        with pytest.raises(ServoError, match="overload") as caught:
            arm.read()
        assert caught.value.servo_id == 2
        line.servos[2]["Hardware Error Status"] = 0


@pytest.mark.parametrize(("firmware", "instruction"), [(44, 0x82), (45, 0x8A)])
def test_fast_reads_are_for_firmware_that_knows_them(open_arm, line, firmware, instruction):
    line.servos[1]["Firmware Version"] = firmware
    with open_arm() as arm:
        line.instructions.clear()
        arm.read()
        assert arm.roll[1].firmware == firmware
        assert line.instructions == [instruction]


def test_the_dead_servo_is_named_not_those_that_waited_for_it(open_arm, line):
    with open_arm(margin=SHORT) as arm:
        for dead in (1, 4, 2):  # after the first it is asked last, and 4 comes before 1
            line.silent = {dead}
            for _ in range(4):
                with pytest.raises(BusTimeoutError) as caught:
                    arm.read()
                assert caught.value.servo_id == dead
            line.silent = set()
            arm.read()
        assert {i: stats.timeouts for i, stats in arm.stats.items()} == {1: 4, 2: 4, 4: 4}
