import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.config.unit import (
    from_file_units,
    positions_key,
    same_but_for_unit,
    stem_of,
    to_file_units,
    unit_of,
)
from splinearm.joints import JointKind

TURNS, SLIDES = JointKind.REVOLUTE, JointKind.PRISMATIC


@pytest.mark.property
@given(st.lists(st.floats(-1e6, 1e6), min_size=4, max_size=4))
def test_file_units_and_si_are_two_ways_to_say_the_same(values):
    kinds = [TURNS, SLIDES, SLIDES, TURNS]
    q = from_file_units(np.array(values), kinds)
    np.testing.assert_allclose(to_file_units(q, kinds), values, rtol=1e-15, atol=1e-300)
    np.testing.assert_allclose(q, np.array(values) * [np.pi / 180, 1e-3, 1e-3, np.pi / 180])


@pytest.mark.parametrize(
    ("key", "stem"),
    [("a_mm", "a"), ("max_speed_deg_s2", "max_speed"), ("top_m_deg_mm", "top_m"), ("axis", "axis")],
)
def test_a_stem_is_a_key_without_its_unit(key, stem):
    assert stem_of(key) == stem


@pytest.mark.parametrize(
    ("key", "name"),
    [
        ("a_mm", "millimetres"),
        ("max_acceleration_deg_s2", "degrees per second squared"),
        ("inertia_kg_m2", "kilogram square metres"),
        ("axis", ""),
        ("zero_ticks", ""),
    ],
)
def test_a_key_wears_its_unit(key, name):
    assert unit_of(key).name == name


def test_keys_of_one_quantity_differ_in_their_units():
    assert same_but_for_unit("a_cm", "a_mm")
    assert same_but_for_unit("a", "a_mm")
    assert same_but_for_unit("max_speed_rpm", "max_speed_deg_s")
    assert not same_but_for_unit("a_mm", "a_mm")
    assert not same_but_for_unit("b_cm", "a_mm")
    assert not same_but_for_unit("axis_mm", "axis")
    assert not same_but_for_unit("max_deg", "max_speed_deg_s")


def test_positions_of_sliding_joints_show_in_the_key():
    assert positions_key("home", [TURNS, TURNS]) == "home_deg"
    assert positions_key("home", [TURNS, SLIDES]) == "home_deg_mm"
