"""The arms that come with the package, in MuJoCo and on the virtual bus."""

import json
from pathlib import Path

import mujoco
import numpy as np
import pytest

from splinearm.config import load_cell, shipped_arms
from splinearm.sim.model import build_spec, compile_model
from splinearm.sim.motor import motors_for
from splinearm.sim.mujoco_arm import MujocoArm
from splinearm.sim.virtual_bus import VirtualBus

pytestmark = pytest.mark.sim

CASES = Path(__file__).parents[1] / "data" / "arms"


@pytest.mark.parametrize("name", shipped_arms())
def test_gravity_torque_is_that_of_another_program(name):
    # the cases were computed with Pinocchio from the vendors' own descriptions
    cell = load_cell(name)
    cases = json.loads((CASES / f"{name}.cases.json").read_text(encoding="utf-8"))["cases"]
    model = compile_model(build_spec(cell.arm, motors_for(cell.arm, cell.chain)))
    data = mujoco.MjData(model)
    for case in cases:
        data.qpos[:] = case["q"]
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(data.qfrc_bias, case["gravity_torque"], atol=1e-10)


@pytest.mark.parametrize("name", shipped_arms())
def test_its_motors_hold_it_at_home(name):
    cell = load_cell(name)
    home = cell.poses["home"]
    with MujocoArm(cell.arm, motors_for(cell.arm, cell.chain), home) as driver:
        driver.advance(1.0)
        np.testing.assert_allclose(driver.read().q, home, atol=1e-3)


@pytest.mark.parametrize("name", shipped_arms())
def test_its_servos_hold_it_near_home(name):
    cell, now = load_cell(name), 0.0
    bus = VirtualBus(cell.arm, cell.chain, cell.poses["home"], clock=lambda: now)
    for servo in bus.servos.values():
        assert servo.write(64, b"\x01") == 0
    now = 2.0
    bus.advance()
    np.testing.assert_allclose(bus.q, cell.poses["home"], atol=0.1)
