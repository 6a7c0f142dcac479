import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.corner import ramp, rounded_polyline


@st.composite
def polylines(draw):
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    corners = rng.normal(size=(draw(st.integers(2, 6)), 3))
    steps = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    room = 0.5 * np.minimum(np.append(steps, np.inf), np.append(np.inf, steps))
    # some corners touch their neighbours
    widths = room * rng.choice([0.1, 0.7, 1.0], len(corners))
    widths[[0, -1]] = 0.0
    return corners, np.concatenate(([0.0], np.cumsum(steps))), widths


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(polylines())
def test_a_rounded_polyline_is_c2_and_straight_between_its_corners(line):
    corners, u, widths = line
    curve = rounded_polyline(corners, u, widths)
    assert np.allclose(curve.at(np.array(curve.domain)), corners[[0, -1]], atol=1e-14)
    for x in curve.breaks[1:-1]:
        for order in (0, 1, 2):
            step = 1e-7
            before, behind = curve.at([x - step, x + step], order)
            scale = 1.0 / widths[widths > 0.0].min() ** (order + 1)
            assert np.abs(behind - before).max() < 20.0 * step * scale
    for i in range(len(u) - 1):
        low, high = u[i] + widths[i], u[i + 1] - widths[i + 1]
        if high - low < 1e-6:
            continue
        at = np.linspace(low, high, 5)
        want = corners[i] + np.outer((at - u[i]) / (u[i + 1] - u[i]), corners[i + 1] - corners[i])
        assert np.allclose(curve.at(at), want, atol=1e-13)
        assert np.abs(curve.at(at[1:-1], 2)).max() < 1e-7


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(polylines())
def test_rounding_stays_nearer_to_the_corner_than_its_width(line):
    corners, u, widths = line
    curve = rounded_polyline(corners, u, widths)
    for i in range(1, len(u) - 1):
        p = curve.at(np.linspace(u[i] - widths[i], u[i] + widths[i], 50))
        assert np.linalg.norm(p - corners[i], axis=1).max() <= widths[i] * (1.0 + 1e-9)


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(st.floats(0.01, 10.0))
def test_a_ramp_is_its_own_derivatives(width):
    x = np.linspace(-2.0 * width, 2.0 * width, 401)
    value, slope, bend = ramp(x, np.full(x.shape, width))
    assert np.array_equal(value[x <= -width], 0.0 * x[x <= -width])
    assert np.allclose(value[x >= width], x[x >= width])
    step = 1e-6 * width
    after, before = ramp(x + step, width + 0.0 * x), ramp(x - step, width + 0.0 * x)
    assert np.allclose((after[0] - before[0]) / (2 * step), slope, atol=1e-8)
    assert np.allclose((after[1] - before[1]) / (2 * step), bend, atol=2e-6 / width)


def test_a_ramp_without_width_is_sharp():
    value, slope, bend = ramp(np.array([-1.0, 0.0, 2.0]), np.zeros(3))
    assert value.tolist() == [0.0, 0.0, 2.0]
    assert slope.tolist() == [0.0, 1.0, 1.0]
    assert not bend.any()
