"""The shipped arms, compiled, against poses, torques and inertias that others computed."""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from splinearm.config import load_cell, shipped_arms
from splinearm.kinematics.dynamics import Dynamics

DATA = Path(__file__).parent.parent / "data" / "arms"
ARMS = shipped_arms()


@cache
def compiled_arm(name):
    return load_cell(name).arm.compiled()


@cache
def cases(name):
    found = json.loads((DATA / f"{name}.cases.json").read_text())["cases"]
    return {key: np.array([case[key] for case in found]) for key in found[0]}


@pytest.mark.parametrize("name", ARMS)
def test_poses_and_jacobians_of_the_kernels(name):
    arm, known = compiled_arm(name), cases(name)
    for q, position, J in zip(known["q"], known["position"], known["jacobian"], strict=True):
        np.testing.assert_allclose(arm.fk(q)[:3, 3], position, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(arm.jacobian(q), J, rtol=0.0, atol=1e-10)
    T = arm.fk(known["q"])
    np.testing.assert_allclose(T[:, :3, 3], known["position"], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(arm.jacobian(known["q"]), known["jacobian"], rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("name", ARMS)
def test_gravity_torques(name):
    known = cases(name)
    dynamics = Dynamics(compiled_arm(name))
    # the cases have 12 digits of up to 4 N m
    batch = dynamics.gravity_torque(known["q"])
    np.testing.assert_allclose(batch, known["gravity_torque"], rtol=0.0, atol=1e-11)
    for q, torque in zip(known["q"], known["gravity_torque"], strict=True):
        np.testing.assert_allclose(dynamics.gravity_torque(q), torque, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("name", ARMS)
def test_mass_matrices(name):
    known = json.loads((DATA / "mass_matrices.json").read_text())["arms"][name]
    q = np.array([case["q"] for case in known])
    wanted = np.array([case["mass_matrix"] for case in known])
    found = Dynamics(compiled_arm(name)).mass_matrix(q)
    # the data have 12 digits
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-11)
