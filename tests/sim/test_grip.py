"""Something between the fingers of a virtual gripper."""

from math import inf

import pytest

from splinearm.backends import centred
from splinearm.config import load_cell
from splinearm.drivers.model import servo_model
from splinearm.sim.motor import motor_of
from splinearm.sim.plant import FreePlant
from splinearm.sim.shaft import Shaft
from splinearm.sim.virtual_bus import VirtualBus


def turned(plant: FreePlant, shaft: Shaft, duty: float, steps: int) -> float:
    shaft.duty = duty
    for _ in range(steps):
        plant.step()
    return shaft.angle


def test_a_shaft_stops_at_what_it_cannot_pass_and_goes_back_freely():
    shaft = Shaft()
    plant = FreePlant(motor_of(servo_model("XL430-W250")), shaft)
    plant.between = (-0.1, inf)
    assert turned(plant, shaft, -0.5, 500) == -0.1
    assert plant.speed == 0.0
    assert turned(plant, shaft, 0.5, 300) > 0.2
    plant.between = (-inf, inf)
    assert turned(plant, shaft, -0.5, 2000) < -0.5


def test_only_a_grippers_servo_has_fingers():
    cell = load_cell("wx250s")
    bus = VirtualBus(cell.arm, centred(cell.chain))
    bus.grip("gripper", (0.0, 1.0))
    bus.grip("gripper", None)
    with pytest.raises(ValueError, match="name: want one of gripper, got 'waist'"):
        bus.grip("waist", None)
