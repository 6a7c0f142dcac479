import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves import conic
from splinearm.curves.bspline import BSpline
from splinearm.curves.curvature import frenet
from splinearm.curves.frame import RotationMinimisingFrame, double_reflection
from splinearm.curves.plane import Plane
from splinearm.errors import CurveError

TWISTED = BSpline(
    [-1, -1, -1, -1, 1, 1, 1, 1],
    [[-1, 1, -1], [-1 / 3, -1 / 3, 1], [1 / 3, -1 / 3, -1], [1, 1, 1]],
    3,
)


def random_curve(seed, m=9, rational=False):
    rng = np.random.default_rng(seed)
    knots = np.concatenate((np.zeros(3), np.linspace(0.0, 1.0, m - 2), np.ones(3)))
    points = np.cumsum(rng.normal(size=(m, 3)), axis=0)
    return BSpline(knots, points, 3, rng.uniform(0.5, 2.0, m) if rational else None)


def angle_between(first, second, tangent):
    sine = np.sum(np.cross(first, second) * tangent, axis=-1)
    return np.arctan2(sine, np.sum(first * second, axis=-1))


@pytest.mark.property
@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_frames_are_right_handed_and_do_not_twist(seed, rational):
    curve = random_curve(seed, rational=rational)
    frame = RotationMinimisingFrame(curve)
    u = np.random.default_rng(seed).uniform(0.01, 0.99, 40)
    R = frame.at(u)
    assert np.allclose(np.swapaxes(R, 1, 2) @ R, np.eye(3), atol=1e-14)
    assert np.allclose(np.linalg.det(R), 1.0)
    slope = curve.at(u, 1)
    speed = np.linalg.norm(slope, axis=1)
    assert np.allclose(R[..., 0], slope / speed[:, None], atol=1e-13)
    h = 1e-6
    turn = (frame.at(u + h)[..., 1] - frame.at(u - h)[..., 1]) / (2.0 * h)
    bend = np.linalg.norm(turn, axis=1)
    assert (np.abs(np.sum(turn * R[..., 2], axis=1)) <= 1e-6 * (1.0 + bend + bend**3)).all()


def test_the_frame_turns_against_frenets_by_the_torsion():
    # the twisted cubic: torsion times speed, integrated by Gauss
    frame = RotationMinimisingFrame(TWISTED, tolerance=1e-14)
    u = np.linspace(-1.0, 1.0, 21)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    half = 0.5 * np.diff(u)[:, None]
    x = u[:-1, None] + half * (1.0 + nodes)
    rate = 3.0 / (1 + 9 * x**2 + 9 * x**4) * np.sqrt(1 + 4 * x**2 + 9 * x**4)
    wanted = np.append(0.0, np.cumsum(np.sum(half * weights * rate, axis=1)))
    other = frenet(TWISTED, u)
    angle = np.unwrap(angle_between(frame.at(u)[..., 1], other.normal, other.tangent))
    assert np.allclose(angle - angle[0], wanted, rtol=0, atol=1e-12)


def test_in_a_plane_one_normal_stays():
    plane = Plane.facing([1.0, 0.0, 2.0], [1.0, 2.0, -1.0])
    up = np.cross(plane.x, plane.y)
    # an S: inflections are nothing special
    points = plane.points([[0, 0], [1, 2], [2, -2], [3, 0], [3, 1], [3, 2]])
    curve = BSpline([0, 0, 0, 0, 1, 2, 3, 3, 3, 3], points, 3)
    R = RotationMinimisingFrame(curve, up).at(np.linspace(0.0, 3.0, 50))
    assert np.abs(R[..., 1] - up).max() < 1e-14


def test_a_frame_depends_on_no_other():
    frame = RotationMinimisingFrame(random_curve(5), [0.0, 0.0, 1.0])
    u = np.linspace(0.0, 1.0, 12).reshape(3, 4)
    R = frame.at(u)
    assert R.shape == (3, 4, 3, 3)
    assert np.allclose(frame.at(u[::-1])[::-1], R, rtol=0, atol=1e-14)
    assert np.allclose(frame.at(float(u[1, 2])), R[1, 2], rtol=0, atol=1e-14)
    t = R[0, 0, :, 0]
    wanted = np.array([0.0, 0.0, 1.0]) - t[2] * t
    assert np.allclose(R[0, 0, :, 1], wanted / np.linalg.norm(wanted), atol=1e-15)


def test_corners_are_turned_on_the_shortest_way():
    curve = BSpline([0, 0, 1, 2, 3, 3], [[0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 1]], 1)
    R = RotationMinimisingFrame(curve, [0, 0, 1]).at([0.5, 1.5, 2.5])
    assert np.allclose(R[:, :, 1], [[0, 0, 1], [0, 0, 1], [0, -1, 0]], atol=1e-15)
    back = BSpline([0, 0, 1, 2, 2], [[0, 0, 0], [1, 0, 0], [0, 0, 0]], 1)
    with pytest.raises(CurveError, match="turns back"):
        RotationMinimisingFrame(back)


@pytest.mark.kernel
def test_a_closed_frame_ends_as_it_starts():
    rng = np.random.default_rng(2)
    ring = np.array([[2.0 * np.cos(a), 2.0 * np.sin(a), 0.0] for a in np.arange(8) * np.pi / 4])
    curve = BSpline.closed(np.arange(9.0), ring + 0.5 * rng.normal(size=(8, 3)), 3)
    open_frame = RotationMinimisingFrame(curve)
    assert open_frame.closing_twist == 0.0
    R = open_frame.at([0.0, 8.0])
    missing = angle_between(R[1, :, 1], R[0, :, 1], R[0, :, 0])
    assert abs(missing) > 0.1
    frame = RotationMinimisingFrame(curve, closed=True)
    assert frame.closing_twist == pytest.approx(missing, abs=1e-12)
    R = frame.at([0.0, 8.0])
    assert np.allclose(R[0], R[1], rtol=0, atol=1e-12)
    # what is missing is spread evenly along the way
    u = np.array([1.1, 3.3, 7.7])
    both = frame.at(u), open_frame.at(u)
    twist = angle_between(both[1][..., 1], both[0][..., 1], both[0][..., 0])
    lengths = np.array([curve.length(0.0, x) for x in u]) / curve.length()
    assert np.allclose(twist, missing * lengths, atol=1e-12)


def test_double_reflection_is_of_fourth_order():
    frame = RotationMinimisingFrame(TWISTED, [0.0, 0.0, 1.0])
    errors = []
    for count in (33, 65, 129, 257):
        u = np.linspace(-1.0, 1.0, count)
        R = frame.at(u)
        D = double_reflection(TWISTED.at(u), R[..., 0], R[0, :, 1])
        assert np.allclose(np.swapaxes(D, 1, 2) @ D, np.eye(3), atol=1e-13)
        assert np.allclose(np.linalg.det(D), 1.0)
        errors.append(abs(angle_between(D[-1, :, 1], R[-1, :, 1], R[-1, :, 0])))
    ratios = np.array(errors[:-1]) / errors[1:]
    assert (np.abs(ratios - 16.0) < 2.0).all()
    assert errors[0] < 1e-5


def test_double_reflection_of_a_plane_curve_is_exact():
    circle = conic.circle(2.0, Plane.facing([0, 0, 0], [0, 0, 1]))
    u = np.linspace(0.0, 1.0, 9)
    tangents = frenet(circle, u).tangent
    D = double_reflection(circle.at(u), tangents, [0.0, 0.0, 3.0])
    assert np.allclose(D[..., 1], [0.0, 0.0, 1.0], atol=1e-14)


@pytest.mark.parametrize(
    ("make", "error", "why"),
    [
        (lambda: RotationMinimisingFrame(conic.circle(1.0)), ValueError, "want 3 coordinates"),
        (lambda: RotationMinimisingFrame(TWISTED, tolerance=0.0), ValueError, "tolerance"),
        (lambda: RotationMinimisingFrame(TWISTED, [1, -2, 3]), ValueError, "across the tangent"),
        (lambda: RotationMinimisingFrame(TWISTED, closed=True), CurveError, "not closed"),
        (lambda: RotationMinimisingFrame(TWISTED).at(1.5), CurveError, "not at 1.5"),
        (lambda: RotationMinimisingFrame(TWISTED).at(float("nan")), CurveError, "not at nan"),
        (lambda: double_reflection(np.ones((2, 3)), np.eye(3)[:2]), ValueError, "the same"),
        (lambda: double_reflection(np.eye(3), 2.0 * np.eye(3)), ValueError, "length 1"),
    ],
)
def test_what_has_no_frame_is_refused(make, error, why):
    with pytest.raises(error, match=why):
        make()


def test_a_cusp_has_no_frame():
    points = [[1, -1, 0], [-1 / 3, 1, 0], [-1 / 3, -1, 0], [1, 1, 0]]
    with pytest.raises(CurveError, match=r"stands still|turns back|too quickly"):
        RotationMinimisingFrame(BSpline([-1, -1, -1, -1, 1, 1, 1, 1], points, 3))
