from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.kinematics import affine, plane, space

numbers = st.floats(-3.0, 3.0)
shapes = st.sampled_from([2, 3])


def some_transform(draw_seed, d):
    rng = np.random.default_rng(draw_seed)
    linear = rng.normal(size=(d, d)) + 2.0 * np.eye(d)
    return affine.from_parts(linear, rng.normal(size=d))


@pytest.mark.property
@given(st.integers(0, 10_000), shapes)
@settings(deadline=None)
def test_concatenation_carries_out_the_first_named_first(seed, d):
    first, then = some_transform(seed, d), some_transform(seed + 1, d)
    points = np.random.default_rng(seed).normal(size=(5, d))
    both = affine.apply(affine.concatenate(first, then), points)
    np.testing.assert_allclose(both, affine.apply(then, affine.apply(first, points)), atol=1e-12)


@pytest.mark.property
@given(st.integers(0, 10_000), shapes)
@settings(deadline=None)
def test_the_inverse_leads_back(seed, d):
    T = some_transform(seed, d)
    if abs(affine.measure_factor(T)) > 1e-2:
        np.testing.assert_allclose(T @ affine.inverse(T), np.eye(d + 1), atol=1e-10)


def test_the_inverse_works_on_batches():
    Ts = np.array([plane.rotation(0.3, (1.0, 2.0)), plane.shear_along_x(2.0)])
    np.testing.assert_allclose(affine.inverse(Ts) @ Ts, [np.eye(3)] * 2, atol=1e-15)


def test_a_flattening_transform_has_no_inverse():
    with pytest.raises(ValueError, match="flattens nothing"):
        plane.inverse(plane.scaling((1.0, 0.0)))


def test_directions_are_not_moved_by_translations():
    T = space.concatenate(space.rotation_z(pi / 2), space.translation((1.0, 2.0, 3.0)))
    image = space.apply_to_directions(T, [1.0, 0.0, 0.0])
    np.testing.assert_allclose(image, [0.0, 1.0, 0.0], atol=1e-15)


@pytest.mark.property
@given(numbers, numbers)
def test_a_transform_about_a_point_leaves_it_where_it_is(x, y):
    T = affine.about(np.array([[1.0, 2.0], [-0.5, 3.0]]), (x, y))
    np.testing.assert_allclose(affine.apply(T, (x, y)), (x, y), atol=1e-12)


def test_a_vector_without_length_has_no_direction():
    with pytest.raises(ValueError, match=r"axis: want a vector of some length, got \[0.0, 0.0\]"):
        affine.unit([0.0, 0.0], "axis")
