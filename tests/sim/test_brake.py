"""The last resort: a client that falls silent, and arms that must be at rest soon after."""

from dataclasses import replace

import numpy as np
import pytest

from splinearm.config import load_cell
from splinearm.sim.brake import Brake
from splinearm.sim.choice import TripStop
from splinearm.sim.motor import motor_of
from splinearm.sim.plant import ArmPlant, Drive, FreePlant
from splinearm.sim.rig import Rig
from splinearm.sim.shaft import Shaft
from splinearm.sim.trace import Trace
from splinearm.sim.virtual_servo import VirtualServo

SILENCE = 0.06  # watchdog of 2 units, and 20 ms to stop


def rig_of(cell):
    """Give a rig of a shipped arm with all torques on and watchdogs at 2 units."""
    home = cell.poses["home"]
    servos, drives, plants = [], [], []
    for spec in cell.chain.servos:
        shaft, motor = Shaft(), motor_of(spec.servo_model)
        servo = VirtualServo.of(spec, cell.chain.baud, shaft)
        if spec.joint is None:
            plants.append(FreePlant(motor, shaft))
        else:
            shaft.angle = home[cell.arm.joint_names.index(spec.joint)]
            drives.append(Drive(spec.joint, motor, shaft))
            servo.trace = Trace()
        servos.append(servo)
    rig = Rig(servos, [ArmPlant(cell.arm, drives, np.asarray(home)), *plants])
    for servo in servos:
        put(servo, "Torque Enable", 1)
        put(servo, "Bus Watchdog", 2)
    return rig, [servo for servo in servos if servo.trace is not None]


def put(servo, name: str, value: int) -> None:
    register = servo.memory.table[name]
    assert servo.write(register.address, register.encode(value)) == 0


def stream(rig, servos, speed: float, cycles: int) -> float:
    """Let every joint speed up to ``speed`` (rad/s) by goals at 100 Hz; give when the last came."""
    begin = [servo.position for servo in servos]
    for k in range(cycles):
        t = 0.01 * k
        way = speed * (t * t / 0.4 if t < 0.2 else t - 0.1)
        for servo, position in zip(servos, begin, strict=True):
            servo.heard()
            put(servo, "Goal Position", position + round(way * servo.scale.per_rad))
        rig.advance_to(t + 0.01)
    return rig.now - 0.01


@pytest.mark.sim
@pytest.mark.parametrize("arm", ["planar_2r", "rx150", "wx250s", "open_manipulator_x"])
def test_a_client_killed_in_motion_leaves_every_joint_at_rest_within_60_ms(arm):
    rig, servos = rig_of(load_cell(arm))
    last = stream(rig, servos, 0.5, 40)
    rig.advance_to(last + 0.5)
    for servo in servos:
        motion = servo.trace.motion()
        late = motion.after(last + SILENCE)
        assert motion.after(last).speed[0] > 0.4
        assert np.abs(late.speed).max() < 0.1
        assert np.abs(late.angle - late.angle[0]).max() < np.radians(0.5)
        assert late.torque_on.all()


@pytest.mark.sim
def test_held_at_its_present_position_instead_an_arm_moves_on():
    rig, servos = rig_of(load_cell("wx250s"))
    for servo in servos:
        servo.choices = replace(servo.choices, on_trip=TripStop.HOLD)
    last = stream(rig, servos, 0.5, 40)
    rig.advance_to(last + 0.5)
    late = [servo.trace.motion().after(last + SILENCE) for servo in servos]
    assert max(np.abs(motion.speed).max() for motion in late) > 0.1


def braked(load: float, time_constant: float, *, slew: float = np.inf) -> tuple[Brake, float]:
    """Brake a motor with something on it for 200 ms; give the brake and the last speed."""
    speed, given = 0.2, load + 0.2
    brake, before = Brake(load, 0.0, slew), speed
    for _ in range(200):
        wanted = brake.tick(speed, given, 1.0)
        given = min(max(wanted, given - slew), given + slew)
        before, speed = speed, speed + (given - speed - load) / time_constant
    return brake, before


@pytest.mark.parametrize("time_constant", [50.0, 120.0, 400.0])
@pytest.mark.parametrize("load", [-0.4, 0.0, 0.3])
def test_whatever_hangs_on_it_it_comes_to_rest_and_knows_the_load(load, time_constant):
    brake, speed = braked(load, time_constant)
    assert brake.done
    assert abs(speed) < 0.004
    assert brake.carried == pytest.approx(load, abs=0.02)


def test_with_a_slow_output_it_comes_to_rest_too():
    brake, speed = braked(0.2, 60.0, slew=0.055)
    assert brake.done
    assert abs(speed) < 0.004


def test_without_an_end_it_gives_up_and_carries_what_it_can():
    brake = Brake(0.0, 0.0, np.inf)
    for _ in range(600):
        output = brake.tick(0.5, -1.0, 1.0)
    assert brake.done
    assert output == -1.0
