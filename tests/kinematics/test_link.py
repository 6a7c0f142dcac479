from math import pi

import numpy as np
import pytest

from splinearm.joints import JointKind
from splinearm.kinematics import Inertia, Link, space


def test_a_turning_link_turns_about_z_between_its_two_transforms():
    before, after = space.rotation_x(0.3), space.translation((0.1, 0.2, 0.3))
    link = Link("elbow", JointKind.REVOLUTE, before, after)
    np.testing.assert_allclose(link.matrix(0.7), before @ space.rotation_z(0.7) @ after)


def test_a_sliding_link_slides_along_z_between_its_two_transforms():
    before = space.rotation_x(pi / 2)
    link = Link("lift", JointKind.PRISMATIC, before, np.eye(4))
    np.testing.assert_allclose(link.matrix(0.2)[:3, 3], [0.0, -0.2, 0.0], atol=1e-16)
    np.testing.assert_array_equal(link.matrix(0.2)[:3, :3], before[:3, :3])


def test_a_link_refuses_what_is_not_rigid_and_names_itself():
    with pytest.raises(ValueError, match="link 'elbow': T_joint_link: want a rotation"):
        Link("elbow", JointKind.REVOLUTE, np.eye(4), np.diag((1.0, 1.0, 2.0, 1.0)))


@pytest.mark.parametrize(
    ("mass", "com", "tensor", "message"),
    [
        (-1.0, np.zeros(3), np.eye(3), "mass: want .* at least zero, got -1"),
        (np.nan, np.zeros(3), np.eye(3), "mass: want a finite number"),
        (1.0, np.zeros(2), np.eye(3), r"com: want shape \(3\)"),
        (1.0, np.zeros(3), np.triu(np.ones((3, 3))), "tensor: want a symmetric matrix"),
        (1.0, np.zeros(3), np.diag((1.0, 1.0, -1.0)), "tensor: want no negative principal moment"),
    ],
)
def test_an_inertia_that_no_body_has_is_refused(mass, com, tensor, message):
    with pytest.raises(ValueError, match=message):
        Inertia(mass, com, tensor)


def test_a_body_without_mass_is_allowed():
    assert Inertia(0.0, np.zeros(3), np.zeros((3, 3))).mass == 0.0
