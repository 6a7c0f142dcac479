import numpy as np
import pytest

from splinearm.curves.course import Course, goes_on
from splinearm.curves.segment import Arc, Line
from splinearm.errors import CurveError

# a line, a quarter circle that leaves it at its tangent, and a line at a sharp corner
SEGMENTS = [
    Line(np.array([-0.2, 0, 0]), np.zeros(3)),
    Arc.through([0, 0, 0], [0.1 * np.sin(0.7), 0.1 - 0.1 * np.cos(0.7), 0], [0.1, 0.1, 0]),
    Line(np.array([0.1, 0.1, 0]), np.array([0.3, 0.1, 0.1])),
]


def course(*widths):
    s = np.concatenate(([0.0], np.cumsum([segment.length for segment in SEGMENTS])))
    return Course(SEGMENTS, s, np.array([0.0, *widths, 0.0]))


@pytest.mark.parametrize("widths", [(0.02, 0.03), (0.1, 0.05), (0.14, 0.01), (0.05, 0.107079)])
def test_rounded_segments_are_one_curve_with_even_bends(widths):
    made = course(*widths)
    assert made.breaks[0] == made.s[0]
    assert made.breaks[-1] == made.s[-1]
    assert (np.diff(made.breaks) > 0.0).all()
    inner = made.breaks[1:-1]
    tiny = 1e-9
    for order, tolerance in ((0, 1e-8), (1, 1e-6), (2, 1e-4)):
        gap = made.at(inner + tiny, order) - made.at(inner - tiny, order)
        assert np.abs(gap).max() <= tolerance


def test_away_from_corners_it_is_the_segments_themselves():
    made = course(0.02, 0.03)
    first, quarter = np.linspace(0.0, 0.18, 9), np.linspace(0.22, 0.2 + 0.05 * np.pi - 0.03, 9)
    assert np.abs(made.at(first)[:, 1:]).max() == 0.0
    radius = np.linalg.norm(made.at(quarter) - [0.0, 0.1, 0.0], axis=1)
    assert np.abs(radius - 0.1).max() <= 1e-15
    assert np.allclose(np.linalg.norm(made.at(quarter, 1), axis=1), 1.0)


def test_a_rounding_stays_near_its_corner():
    made = course(0.02, 0.03)
    assert 0.0 < made.farthest_from_corner(1) <= 0.02 * (1 + 1e-9)
    assert 0.0 < made.farthest_from_corner(2) <= 0.03 * (1 + 1e-9)
    assert made.farthest_from_corner(0) == 0.0


def test_derivatives_are_those_of_differences():
    made = course(0.05, 0.05)
    s, step = np.linspace(*made.domain, 60)[1:-1], 1e-6
    s = s[np.abs(s[:, None] - made.breaks).min(axis=1) > 1e-4]
    for order in (1, 2, 3):
        difference = (made.at(s + step, order - 1) - made.at(s - step, order - 1)) / (2 * step)
        assert np.allclose(made.at(s, order), difference, rtol=1e-5, atol=1e-4)


def test_segments_go_on_where_direction_and_bend_do():
    line, quarter, other = SEGMENTS
    half = Line(np.zeros(3), np.array([0.1, 0, 0]))
    assert goes_on(line, half, (0.2, 0.1))
    assert not goes_on(line, half, (0.2, 0.2))
    assert not goes_on(line, quarter, (line.length, quarter.length))
    assert not goes_on(quarter, other, (quarter.length, other.length))
    one = Arc.about([1, 0, 0], [0, 1, 0], [0, 0, 0], [0, 0, 1])
    two = Arc.about([0, 1, 0], [-1, 0, 0], [0, 0, 0], [0, 0, 1])
    assert goes_on(one, two, (one.length, two.length))


def test_beyond_its_ends_it_is_not_defined():
    with pytest.raises(CurveError, match=r"not at -0\.1"):
        course(0.02, 0.02).at(np.array([-0.1]))
