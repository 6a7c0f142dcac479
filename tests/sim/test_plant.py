from math import tau

import numpy as np
import pytest

from splinearm.drivers.model import servo_model
from splinearm.sim.motor import motor_of
from splinearm.sim.plant import ArmPlant, Drive, FreePlant
from splinearm.sim.shaft import Shaft

pytestmark = pytest.mark.sim

XM430 = motor_of(servo_model("XM430-W350"))


def drives(*joints: str) -> list[Drive]:
    return [Drive(joint, XM430, Shaft()) for joint in joints]


def run(plant, steps: int) -> None:
    for _ in range(steps):
        plant.step()


def test_shafts_are_where_the_joints_are(make_arm):
    both = drives("j1", "j0")
    plant = ArmPlant(make_arm(2, upright=True), both, np.array([0.5, -0.3]))
    assert [d.shaft.angle for d in both] == [-0.3, 0.5]
    run(plant, 200)
    assert [d.shaft.angle for d in both] == plant.q[::-1].tolist()
    assert plant.speed == max(abs(d.shaft.speed) for d in both) > 0.0


def test_who_is_pushed_moves_until_the_push_ends(make_arm):
    plant = ArmPlant(make_arm(2), drives("j0", "j1"), np.zeros(2))
    plant.push([1.0, 0.0])
    run(plant, 100)
    pushed = plant.q[0]
    assert pushed > 0.01
    plant.push(None)
    before = plant.speed
    run(plant, 100)
    assert plant.speed < before
    with pytest.raises(ValueError, match="torques"):
        plant.push([1.0])


def test_cut_off_the_arm_falls_and_at_zero_duty_the_motor_brakes(make_arm):
    fallen = []
    for duty in (None, 0.0):
        both = drives("j0", "j1")
        for drive in both:
            drive.shaft.duty = duty
        plant = ArmPlant(make_arm(2, upright=True), both, np.zeros(2))
        run(plant, 300)
        fallen.append(-plant.q[0])
    assert fallen[0] > 2 * fallen[1] > 0.0


def test_a_second_servo_on_a_joint_helps(make_arm):
    reached = []
    for joints in (("j0", "j1"), ("j0", "j0", "j1")):
        all_of_them = drives(*joints)
        for drive in all_of_them:
            drive.shaft.duty = 0.3 if drive.joint == "j0" else 0.0
        plant = ArmPlant(make_arm(2, upright=True), all_of_them, np.zeros(2))
        run(plant, 150)
        reached.append(plant.q[0])
    assert reached[0] < 0.0 < reached[1]


def test_the_arm_stops_at_its_stops(make_arm):
    one = drives("j0")
    one[0].shaft.duty = 0.5
    plant = ArmPlant(make_arm(1), one, np.zeros(1))
    run(plant, 5000)
    assert plant.q[0] == pytest.approx(2.9, abs=0.05)


def test_more_servos_than_can_be_cut_off_are_refused(make_arm):
    with pytest.raises(ValueError, match="at most 31 servos, got 32"):
        ArmPlant(make_arm(1), drives(*["j0"] * 32), np.zeros(1))


def test_a_free_shaft_runs_up_to_its_no_load_speed():
    shaft = Shaft(duty=1.0)
    plant = FreePlant(XM430, shaft)
    run(plant, 50)
    assert 0.5 < shaft.speed / XM430.no_load_speed < 0.7  # one time constant
    run(plant, 1000)
    assert shaft.speed == pytest.approx(46 / 60 * tau, rel=0.01)
    assert plant.speed == shaft.speed


def test_a_free_shaft_that_is_cut_off_runs_down_by_its_friction():
    shaft = Shaft(speed=-2.0)
    plant = FreePlant(XM430, shaft)
    run(plant, 100)
    assert -2.0 < shaft.speed < 0.0
    run(plant, 5000)
    assert shaft.speed == 0.0


def test_an_arm_with_a_joint_that_nothing_drives_is_refused(make_arm):
    with pytest.raises(ValueError, match="no servo moves j1"):
        ArmPlant(make_arm(2), drives("j0"), np.zeros(2))


def test_a_stuck_joint_stays_while_the_others_move_and_moves_again(make_arm):
    both = drives("j0", "j1")
    plant = ArmPlant(make_arm(2, upright=True), both, np.zeros(2))
    run(plant, 50)
    both[1].shaft.stuck = True
    there = plant.q[1]
    run(plant, 300)
    assert plant.q[1] == pytest.approx(there, abs=1e-4)
    assert plant.q[0] < -0.1
    both[1].shaft.stuck = False
    both[1].shaft.duty = 0.5
    run(plant, 200)
    assert plant.q[1] - there > 0.1


def test_a_free_shaft_can_be_stuck():
    shaft = Shaft(duty=1.0, speed=2.0, stuck=True)
    run(FreePlant(XM430, shaft), 10)
    assert (shaft.angle, shaft.speed) == (0.0, 0.0)
