from math import pi

import pytest

from splinearm.joints import JointKind
from splinearm.kinematics import DHConvention, DHLink, structure
from splinearm.kinematics.structure import ArmClass

WORDS = {
    "puma": "spherical wrist, a base whose second and third axes are parallel",
    "industrial": "spherical wrist, a base whose second and third axes are parallel",
    "ur5": "three parallel axes",
    "base 12": "spherical wrist, a base whose first and second axes meet",
    "base 23": "spherical wrist, a base whose second and third axes meet",
    "parallel 12": "spherical wrist, a base whose first and second axes are parallel",
    "quartic": "spherical wrist, a base that asks for a quartic",
    "koch": "pan, three parallel axes and roll",
    "omx_f": "pan, three parallel axes and roll",
    "wx200": "pan, three parallel axes and roll",
    "open_manipulator_x": "pan and three parallel axes",
    "panda": "no closed form",
    "meeting wrist": "six joints of any kind",
}


@pytest.mark.parametrize("name", WORDS)
def test_the_class_is_found_from_the_model(closed_arms, name):
    assert structure.find(closed_arms[name].packed).words == WORDS[name]


def test_the_shipped_widowx_250_has_a_spherical_wrist(widowx):
    assert structure.find(widowx.packed).kind is ArmClass.SPHERICAL_WRIST


def test_planar_arms_want_two_or_three_turns_and_at_most_one_slide(dh_arm):
    turns = [DHLink(f"t{i}", 0.2, 0.0, 0.0, 0.0) for i in range(4)]
    slides = [DHLink(f"s{i}", 0.0, 0.0, 0.0, 0.0, JointKind.PRISMATIC) for i in range(2)]

    def kind(rows):
        return structure.find(dh_arm(rows, DHConvention.STANDARD).packed).kind

    assert kind(turns[:2]) is ArmClass.PLANAR
    assert kind(turns[:3]) is ArmClass.PLANAR
    assert kind([*turns[:3], slides[0]]) is ArmClass.PLANAR
    assert kind(turns) is ArmClass.NONE
    assert kind([turns[0], *slides]) is ArmClass.NONE
    tilted = DHLink("tilted", 0.1, pi / 2, 0.0, 0.0)
    assert kind([turns[0], tilted, slides[0]]) is ArmClass.NONE
