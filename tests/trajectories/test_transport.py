import numpy as np
import pytest

from splinearm.curves.bspline import BSpline
from splinearm.curves.course import Course
from splinearm.curves.interpolation import interpolate
from splinearm.curves.segment import Arc
from splinearm.errors import CurveError
from splinearm.kinematics import quaternion
from splinearm.trajectories.transport import TransportedOrientation

ONE = np.array([1.0, 0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def wavy():
    points = np.random.default_rng(3).uniform(-0.2, 0.2, (8, 3))
    return interpolate(points, degree=5)


def test_the_direction_of_the_way_is_carried_along(wavy):
    made = TransportedOrientation(wavy, ONE)
    u = np.linspace(*made.domain, 300)
    tangents = wavy.at(u, 1)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    carried = quaternion.rotate(made.at(u).quat, tangents[0])
    assert np.abs(carried - tangents).max() <= 1e-8


def test_it_does_not_spin_about_the_way(wavy):
    turning = TransportedOrientation(wavy, ONE).at(np.linspace(*wavy.domain, 100))
    tangents = wavy.at(np.linspace(*wavy.domain, 100), 1)
    size = np.linalg.norm(tangents, axis=1) * (1.0 + np.linalg.norm(turning.omega, axis=1))
    assert np.abs(np.sum(turning.omega * tangents, axis=1) / size).max() <= 1e-14


def test_rates_are_those_of_differences(wavy):
    made, step = TransportedOrientation(wavy, ONE), 1e-5
    u = np.linspace(*made.domain, 80)[1:-1]
    before, here, behind = (made.at(u + d) for d in (-step, 0.0, step))
    turned = quaternion.log(quaternion.multiply(behind.quat, quaternion.conjugate(before.quat)))
    assert np.allclose(turned / (2 * step), here.omega, atol=1e-4, rtol=1e-4)
    assert np.allclose((behind.omega - before.omega) / (2 * step), here.alpha, atol=1e-2, rtol=1e-4)


def test_on_a_circle_it_turns_about_its_axis_by_the_angle_gone():
    arc = Arc.about([0.1, 0, 0], [0.1, 0, 0], [0, 0, 0], [0, 0, 1])
    course = Course([arc], np.array([0.0, arc.length]), np.zeros(2))
    start = quaternion.normalize(np.array([0.5, -0.1, 0.7, 0.3]))
    s = np.linspace(0.0, arc.length, 50)
    made = TransportedOrientation(course, start).at(s)
    turns = quaternion.exp(np.stack((0 * s, 0 * s, s / 0.1), axis=1))
    gap = quaternion.angle_between(made.quat, quaternion.multiply(turns, start))
    assert np.max(gap) <= 1e-9


def test_on_a_helix_the_turn_is_less_than_the_turns_by_its_torsion():
    # after a full turn the transported frame lags by 2 pi times the sine of the pitch angle
    helix = Arc.about([0.1, 0, 0], [0.1, 0, 0.2], [0, 0, 0], [0, 0, 1])
    course = Course([helix], np.array([0.0, helix.length]), np.zeros(2))
    end = TransportedOrientation(course, ONE).at(np.array([helix.length])).quat[0]
    tangent = helix.at(np.zeros(1), 1)[0] / helix.length
    left = 2.0 * np.pi * (1.0 - 0.2 / helix.length)
    expected = quaternion.from_axis_angle(tangent, left)
    assert quaternion.angle_between(end, expected) <= 1e-8


def test_a_way_that_stands_still_has_no_direction():
    cusp = BSpline([0, 0, 0, 0, 1, 1, 1, 1], [[0, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0, 0]], 3)
    with pytest.raises(CurveError, match="has no direction"):
        TransportedOrientation(cusp, ONE)
