import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import fresnel

from splinearm.curves import conic
from splinearm.curves.arc_length import ArcLength
from splinearm.curves.bspline import BSpline
from splinearm.curves.curvature import curvature, frenet, torsion
from splinearm.curves.hermite import quintic_spline
from splinearm.curves.plane import Plane
from splinearm.errors import CurveError

U = np.linspace(0.0, 1.0, 201)
TWISTED = BSpline(
    [-1, -1, -1, -1, 1, 1, 1, 1],
    [[-1, 1, -1], [-1 / 3, -1 / 3, 1], [1 / 3, -1 / 3, -1], [1, 1, 1]],
    3,
)


def random_curve(seed, dim=3, rational=False):
    rng = np.random.default_rng(seed)
    knots = [0, 0, 0, 0, 0.3, 0.5, 0.9, 1, 1, 1, 1]
    weights = rng.uniform(0.5, 2.0, 7) if rational else None
    return BSpline(knots, rng.normal(size=(7, dim)), 3, weights)


def test_the_twisted_cubic_has_its_curvature_and_torsion():
    u = np.linspace(-1.0, 1.0, 101)
    assert np.allclose(TWISTED.at(u), np.stack((u, u**2, u**3), axis=1), atol=1e-15)
    a, b = 1.0 + 9.0 * u**2 + 9.0 * u**4, 1.0 + 4.0 * u**2 + 9.0 * u**4
    assert np.allclose(curvature(TWISTED, u), 2.0 * np.sqrt(a) / b**1.5, rtol=1e-13)
    assert np.allclose(torsion(TWISTED, u), 3.0 / a, rtol=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_circle_has_one_curvature(sign):
    flat = conic.arc(2.0, 0.0, sign * 5.0)
    assert np.allclose(curvature(flat, U), sign * 0.5, rtol=1e-13)
    tilted = conic.circle(2.0, Plane.facing([1.0, 2.0, 3.0], [1.0, -1.0, 0.5]))
    assert np.allclose(curvature(tilted, U), 0.5, rtol=1e-13)
    assert np.abs(torsion(tilted, U)).max() < 1e-12


def test_an_ellipse_and_a_parabola_have_their_curvature():
    a, b = 3.0, 0.7
    curve = conic.ellipse(a, b)
    x, y = curve.at(U).T
    expected = (x**2 / a**4 + y**2 / b**4) ** -1.5 / (a * b) ** 2
    assert np.allclose(curvature(curve, U), expected, rtol=1e-12)
    parabola = conic.parabola(0.5, -2.0, 3.0)
    v = -2.0 + 5.0 * U
    # to the right as v grows: y^2 = 2 x turns from below to above
    assert np.allclose(np.abs(curvature(parabola, U)), (1.0 + v * v) ** -1.5, rtol=1e-12)


def test_a_helix_and_a_logarithmic_spiral_at_their_nodes():
    t = np.linspace(0.0, 6.0, 400)
    zero = np.zeros_like(t)
    jets = [
        np.stack(row, axis=1)
        for row in (
            (np.cos(t), np.sin(t), 0.5 * t),
            (-np.sin(t), np.cos(t), 0.5 + zero),
            (-np.cos(t), -np.sin(t), zero),
        )
    ]
    helix = quintic_spline(t, tuple(jets))
    assert np.allclose(curvature(helix, t), 1.0 / 1.25, rtol=1e-11)
    middle = 0.5 * (t[1:] + t[:-1])
    assert np.allclose(curvature(helix, middle), 0.8, rtol=1e-7)
    assert np.allclose(torsion(helix, middle), 0.4, rtol=1e-5)
    # r = exp(t / 5): curvature 1 / (r sqrt(1 + 1 / 25))
    z = np.exp((0.2 + 1j) * t)
    jets = [np.stack((w.real, w.imag), axis=1) for w in (z, (0.2 + 1j) * z, (0.2 + 1j) ** 2 * z)]
    spiral = quintic_spline(t, tuple(jets))
    assert np.allclose(curvature(spiral, t), 1.0 / (np.abs(z) * np.sqrt(1.04)), rtol=1e-11)


def test_the_curvature_of_a_clothoid_grows_evenly_with_its_length():
    # from a bend to the right through none to one to the left: direction a s^2 / 2
    a = 1.7
    s = np.linspace(-2.0, 3.0, 201)
    sine, cosine = fresnel(s * np.sqrt(a / np.pi))
    places = np.sqrt(np.pi / a) * np.stack((cosine, sine), axis=1)
    ahead = np.stack((np.cos(0.5 * a * s**2), np.sin(0.5 * a * s**2)), axis=1)
    left = np.stack((-ahead[:, 1], ahead[:, 0]), axis=1)
    clothoid = quintic_spline(s, (places, ahead, a * s[:, None] * left))
    length = ArcLength(clothoid)
    assert length.length == pytest.approx(5.0, rel=1e-10)
    u = np.linspace(-2.0, 3.0, 777)
    # between its nodes the second derivative is off by the fourth power of their steps
    assert np.allclose(curvature(clothoid, u), a * (length.s(u) - 2.0), rtol=0, atol=1e-6)
    middle = length.u(2.0)
    assert abs(curvature(clothoid, middle)) < 1e-9
    assert np.allclose(clothoid.at(middle), [0.0, 0.0], atol=1e-9)


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_frenet_frames_turn_as_curvature_and_torsion_say(seed, rational):
    curve = random_curve(seed, rational=rational)
    # away from knots, where the third derivative jumps
    u = np.array([0.1, 0.2, 0.4, 0.6, 0.7, 0.95])
    frame = frenet(curve, u)
    R = np.stack(frame, axis=-1)
    assert np.allclose(np.swapaxes(R, 1, 2) @ R, np.eye(3), atol=1e-13)
    assert np.allclose(np.linalg.det(R), 1.0)
    h = 1e-6
    before, behind = frenet(curve, u - h), frenet(curve, u + h)
    speed = np.linalg.norm(curve.at(u, 1), axis=1)[:, None]
    turn = [(b - a) / (2.0 * h) / speed for a, b in zip(before, behind, strict=True)]
    k, w = curvature(curve, u)[:, None], torsion(curve, u)[:, None]
    scale = 1e-5 * (1.0 + np.abs(k) + np.abs(w)) ** 3 * (1.0 + 1.0 / speed)
    t, n, b = frame
    assert (np.abs(turn[0] - k * n) <= scale).all()
    assert (np.abs(turn[1] + k * t - w * b) <= scale).all()
    assert (np.abs(turn[2] + w * n) <= scale).all()


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(-3.0, 3.0), st.floats(0.01, 100.0))
def test_curvature_knows_no_frame_and_no_parameter(seed, angle, scale):
    curve = random_curve(seed)
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    moved = BSpline(7.0 * curve.knots + 1.0, scale * curve.points @ turn.T + 5.0, 3)
    u = np.array([0.05, 0.33, 0.6])
    assert np.allclose(curvature(moved, 7.0 * u + 1.0) * scale, curvature(curve, u), rtol=1e-7)
    assert np.allclose(torsion(moved, 7.0 * u + 1.0) * scale, torsion(curve, u), rtol=1e-6)
    # run through backwards: as curved, and as twisted
    back = BSpline(1.0 - curve.knots[::-1], curve.points[::-1], 3)
    assert np.allclose(curvature(back, 1.0 - u), curvature(curve, u), rtol=1e-9)
    assert np.allclose(torsion(back, 1.0 - u), torsion(curve, u), rtol=1e-8)


def test_in_the_plane_the_normal_is_to_the_left():
    frame = frenet(conic.line([0.0, 0.0], [2.0, 0.0]), [0.0, 0.5])
    assert np.array_equal(frame.normal, [[0.0, 1.0], [0.0, 1.0]])
    assert frame.binormal.shape == (2, 0)
    back = frenet(conic.arc(1.0, 0.0, -1.0), 0.0)
    assert np.allclose(back.tangent, [0.0, -1.0])
    assert np.allclose(back.normal, [1.0, 0.0])


def test_in_four_coordinates_curvature_has_no_sign():
    flat = conic.circle(2.0)
    lifted = BSpline(flat.knots, np.hstack((flat.points, flat.points)), 2, flat.weights)
    assert np.allclose(curvature(lifted, U), 0.5 / np.sqrt(2.0))


def test_where_there_is_none_it_is_refused():
    halt = BSpline([0, 0, 0, 1, 1, 1], [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, 0.0]], 2)
    for ask in (curvature, torsion, frenet):
        with pytest.raises(CurveError, match=r"stands still at u = 0\.0"):
            ask(halt, [0.5, 0.0])
    straight = conic.line([0.0, 0.0, 0.0], [1.0, 2.0, 3.0])
    assert np.array_equal(curvature(straight, U), np.zeros(201))
    for ask in (torsion, frenet):
        with pytest.raises(CurveError, match=r"straight at u = 0\.25"):
            ask(straight, 0.25)
    with pytest.raises(ValueError, match="want 3 coordinates, got 2"):
        torsion(conic.circle(1.0), 0.5)
    with pytest.raises(ValueError, match="at least 2 coordinates"):
        curvature(conic.line([0.0], [1.0]), 0.5)
    with pytest.raises(CurveError):
        curvature(straight, 2.0)
