from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.kinematics import homogeneous, plane

numbers = st.floats(-5.0, 5.0)
points = st.tuples(numbers, numbers)
lines = st.tuples(numbers, numbers, numbers).filter(lambda line: abs(line[0]) + abs(line[1]) > 0.1)


@pytest.mark.property
@given(st.floats(-7.0, 7.0), points, points)
def test_a_rotation_keeps_distances_from_its_point_and_turns_by_its_angle(angle, about, point):
    image = plane.apply(plane.rotation(angle, about), point)
    before, after = np.subtract(point, about), np.subtract(image, about)
    assert np.linalg.norm(after) == pytest.approx(np.linalg.norm(before), abs=1e-12)
    turned = before[0] * after[1] - before[1] * after[0]
    assert turned == pytest.approx(np.sin(angle) * (before @ before), abs=1e-12)


@pytest.mark.property
@given(lines, points)
def test_a_reflection_puts_points_as_far_on_the_other_side(line, point):
    mirrored = plane.apply(plane.reflection(line), point)
    here, there = homogeneous.distance(line, point), homogeneous.distance(line, mirrored)
    assert there == pytest.approx(-here, abs=1e-11)
    np.testing.assert_allclose(plane.apply(plane.reflection(line), mirrored), point, atol=1e-11)


def test_the_axes_are_lines_to_mirror_in():
    np.testing.assert_array_equal(plane.reflection((0.0, 1.0, 0.0)), plane.reflection_in_x_axis())
    np.testing.assert_array_equal(plane.reflection((3.0, 0.0, 0.0)), plane.reflection_in_y_axis())
    np.testing.assert_array_equal(plane.apply(plane.reflection_in_x_axis(), (2, 3)), (2, -3))
    np.testing.assert_array_equal(plane.apply(plane.reflection_in_y_axis(), (2, 3)), (-2, 3))


def test_a_line_without_normal_is_refused():
    with pytest.raises(ValueError, match=r"line: want a normal .* got \(0.0, 0.0, 1.0\)"):
        plane.reflection((0.0, 0.0, 1.0))


def test_scaling_about_a_point_leaves_it_and_scales_from_there():
    T = plane.scaling((2.0, 3.0), (1.0, 1.0))
    np.testing.assert_allclose(plane.apply(T, [(1.0, 1.0), (2.0, 2.0)]), [(1.0, 1.0), (3.0, 4.0)])
    np.testing.assert_array_equal(plane.scaling(2.0), plane.scaling((2.0, 2.0)))


def test_shear_along_y_is_the_general_shear_the_other_way_round():
    np.testing.assert_allclose(plane.shear((0.0, 1.0), -0.7), plane.shear_along_y(0.7))
    np.testing.assert_allclose(plane.apply(plane.shear_along_y(0.7), (2.0, 3.0)), (2.0, 4.4))


@pytest.mark.property
@given(st.floats(-pi, pi), numbers, points)
def test_a_shear_keeps_areas_and_the_line_it_runs_along(angle, factor, about):
    direction = np.array((np.cos(angle), np.sin(angle)))
    T = plane.shear(direction, factor, about)
    assert plane.area_factor(T) == pytest.approx(1.0, abs=1e-12)
    on_line = np.add(about, 2.5 * direction)
    np.testing.assert_allclose(plane.apply(T, on_line), on_line, atol=1e-11)


def test_the_area_factor_of_a_reflection_is_minus_one():
    assert plane.area_factor(plane.reflection((1.0, 2.0, 3.0))) == pytest.approx(-1.0)
