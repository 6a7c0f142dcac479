import time

import mujoco
import numpy as np
import pytest

from splinearm.drivers.conformance import check_arm_driver
from splinearm.drivers.model import servo_model
from splinearm.errors import LimitError
from splinearm.joints import JointSetpoint
from splinearm.sim.motor import Motor, motor_of
from splinearm.sim.mujoco_arm import MujocoArm

pytestmark = pytest.mark.sim

XM430 = motor_of(servo_model("XM430-W350"))
LENGTHS = (0.3, 0.25)
CENTRE, RADIUS = np.array([0.33, 0.05]), 0.08


def setpoint(q, qd=None, qdd=None) -> JointSetpoint:
    still = np.zeros(len(q))
    return JointSetpoint(
        t=0.0, q=q, qd=still if qd is None else qd, qdd=still if qdd is None else qdd
    )


def circle(speed: float, turns: float = 1.5):
    """Give times and joint motion of a two-joint arm whose tool runs round a circle."""
    duration = turns * 2 * np.pi * RADIUS / speed + 0.5
    t = np.linspace(0.0, duration, 20001)
    ramp = np.clip(np.minimum(t, duration - t) / 0.5, 0.0, 1.0)
    v = speed * ramp**3 * (10 - 15 * ramp + 6 * ramp**2)
    way = np.concatenate([[0.0], np.cumsum((v[1:] + v[:-1]) / 2) * (t[1] - t[0])])
    x, y = CENTRE[:, None] + RADIUS * np.array([np.cos(way / RADIUS), np.sin(way / RADIUS)])
    l1, l2 = LENGTHS
    b = np.arccos((x**2 + y**2 - l1**2 - l2**2) / (2 * l1 * l2))
    a = np.arctan2(y, x) - np.arctan2(l2 * np.sin(b), l1 + l2 * np.cos(b))
    q = np.stack([a, b], axis=1)
    qd = np.gradient(q, t, axis=0, edge_order=2)
    return t, q, qd, np.gradient(qd, t, axis=0, edge_order=2)


def worst_path_error(arm, speed: float, **options) -> float:
    """Give how far the tool leaves the circle at most, m."""
    t, q, qd, qdd = circle(speed)
    errors = []
    with MujocoArm(arm, [XM430] * 2, q[0], **options) as driver:
        for k in range(int(t[-1] * 100)):
            i = np.searchsorted(t, k / 100)
            tool = arm.fk(driver.read().q)[:2, 3]
            errors.append(abs(np.linalg.norm(tool - CENTRE) - RADIUS))
            driver.write(setpoint(q[i], qd[i], qdd[i]))
            driver.advance(0.01)
    return max(errors)


@pytest.mark.parametrize("upright", [False, True])
@pytest.mark.parametrize("speed", [0.15, 0.3])
def test_the_tool_stays_within_half_a_millimetre_of_its_path(make_arm, upright, speed):
    assert worst_path_error(make_arm(2, upright=upright), speed) < 0.5e-3


def test_a_plain_position_servo_lags_and_droops_more(make_arm):
    arm = make_arm(2, upright=True)
    helped = worst_path_error(arm, 0.15)
    alone = worst_path_error(arm, 0.15, feedforward=False)
    assert alone > 5 * helped


def test_no_motor_ever_leaves_its_line(make_arm):
    arm = make_arm(2, upright=True)
    driver = MujocoArm(arm, [XM430] * 2, [0.5, 0.5])
    rng = np.random.default_rng(1)
    saturated = 0
    with driver:
        for _ in range(200):
            driver.write(setpoint(rng.uniform(-2.5, 2.5, 2), rng.uniform(-9, 9, 2)))
            driver.advance(0.01)
            mujoco.mj_forward(driver.model, driver.data)
            duty = driver.torque / XM430.stall_torque + driver.data.qvel / XM430.no_load_speed
            assert np.abs(duty).max() < 1.0 + 1e-9
            saturated += bool(np.abs(duty).max() > 1.0 - 1e-9)
    assert saturated > 20  # or the test would say nothing


def test_it_runs_many_times_faster_than_real_time(make_arm):
    arm = make_arm(6, upright=True)
    with MujocoArm(arm, [XM430] * 6) as driver:
        begun = time.perf_counter()
        driver.advance(10.0)
        assert time.perf_counter() - begun < 1.0


def test_its_time_is_that_of_its_steps(make_arm):
    with MujocoArm(make_arm(2), [XM430] * 2) as driver:
        assert driver.now == 0.0
        for _ in range(100):
            driver.advance(0.01)
        assert driver.now == pytest.approx(1.0)
        assert driver.read().t == driver.now
        driver.advance(0.0)
        assert driver.now == pytest.approx(1.0)
        driver.advance(0.0004)  # in whole steps
        assert driver.now == pytest.approx(1.001)


def test_time_does_not_run_backwards(make_arm):
    driver = MujocoArm(make_arm(2), [XM430] * 2)
    with pytest.raises(ValueError, match="duration: want a finite time of at least zero"):
        driver.advance(-0.1)


def test_it_holds_where_it_stands_when_entered_and_when_left(make_arm):
    arm, start = make_arm(2, upright=True), np.array([0.6, -0.4])
    driver = MujocoArm(arm, [XM430] * 2, start)
    with driver:
        driver.advance(2.0)
        np.testing.assert_allclose(driver.read().q, start, atol=2e-3)
    driver.advance(2.0)
    np.testing.assert_allclose(driver.read().q, start, atol=2e-3)


def test_it_holds_after_an_error_in_the_middle_of_a_motion(make_arm):
    driver = MujocoArm(make_arm(2, upright=True), [XM430] * 2, [0.0, 0.5])

    def break_off() -> None:
        with driver:
            driver.write(setpoint([1.0, 1.0]))
            driver.advance(0.1)
            raise RuntimeError

    with pytest.raises(RuntimeError):
        break_off()
    stopped = driver.read().q
    driver.advance(2.0)
    assert np.abs(driver.read().q - stopped).max() < 0.15  # what it takes to brake
    assert np.abs(driver.read().qd).max() < 1e-3


@pytest.mark.parametrize("feedforward", [True, False])
def test_it_keeps_what_every_arm_driver_promises(make_arm, feedforward):
    arm = make_arm(4, upright=True)
    driver = MujocoArm(arm, [XM430] * 4, [0.5, -0.5, 0.5, 0.5], feedforward=feedforward)
    check_arm_driver(driver, wait=driver.advance)


def test_held_again_and_again_it_does_not_creep_down(make_arm):
    arm = make_arm(2, upright=True)
    with MujocoArm(arm, [XM430] * 2, [0.5, 0.0], feedforward=False) as driver:
        driver.advance(1.0)
        drooped = driver.read().q
        for _ in range(10):
            driver.hold()
            driver.advance(0.5)
        np.testing.assert_allclose(driver.read().q, drooped, atol=2e-3)


def test_released_it_falls_and_hold_catches_it(make_arm):
    with MujocoArm(make_arm(2, upright=True), [XM430] * 2, [0.0, 0.5]) as driver:
        driver.release()
        driver.advance(0.4)
        assert driver.read().q[0] < -0.1
        assert np.all(driver.torque == 0.0)
        driver.hold()
        driver.advance(1.0)
        caught = driver.read().q
        driver.advance(1.0)
        np.testing.assert_allclose(driver.read().q, caught, atol=1e-3)


def test_what_was_released_stays_limp_when_left_and_when_written_to(make_arm):
    driver = MujocoArm(make_arm(2, upright=True), [XM430] * 2, [0.0, 0.5])
    with driver:
        driver.release()
        driver.write(setpoint([0.0, 0.5]))
    driver.advance(0.3)
    assert np.all(driver.torque == 0.0)


def test_before_it_is_entered_its_motors_are_off(make_arm):
    driver = MujocoArm(make_arm(2, upright=True), [XM430] * 2)
    driver.advance(0.2)
    assert driver.read().q[0] < -0.01


def test_current_is_the_share_of_the_stall_torque(make_arm):
    arm = make_arm(2, upright=True)
    with MujocoArm(arm, [XM430] * 2, [0.0, 0.0]) as driver:
        driver.advance(1.0)
        state = driver.read()
        np.testing.assert_allclose(state.current, driver.torque / 4.1 * 2.3)
        assert state.current[0] > 0.5  # it carries its links
    nameless = Motor(stall_torque=4.1, no_load_speed=4.8)
    with MujocoArm(arm, [nameless] * 2) as driver:
        assert np.isnan(driver.read().current).all()


def test_it_starts_at_joint_zero_or_the_nearest_the_limits_allow(make_arm):
    assert (MujocoArm(make_arm(2), [XM430] * 2).read().q == 0.0).all()


def test_a_start_outside_the_limits_is_refused(make_arm):
    with pytest.raises(LimitError, match="'j1'"):
        MujocoArm(make_arm(2), [XM430] * 2, [0.0, 3.0])


def test_a_setpoint_of_another_arm_is_refused(make_arm):
    driver = MujocoArm(make_arm(2), [XM430] * 2)
    with pytest.raises(ValueError, match="want 2 joints, got 3"):
        driver.write(setpoint([0.0, 0.0, 0.0]))
