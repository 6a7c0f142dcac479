import numpy as np
import pytest

from splinearm.curves.bspline import BSpline


def make_curve(seed, *, degree=None, form="any", rational=None, dim=2):
    """Give a random curve: clamped, unclamped or a ring, with repeated and very uneven knots."""
    rng = np.random.default_rng(seed)
    form = rng.choice(["clamped", "unclamped", "ring"]) if form == "any" else form
    degree = int(rng.integers(1, 6)) if degree is None else degree
    rational = bool(rng.integers(2)) if rational is None else rational
    spans = int(rng.integers(1, 8))
    steps = 10.0 ** rng.uniform(-rng.choice([0.3, 3.0]), 0.0, spans)
    breaks = rng.normal() + np.concatenate(([0.0], np.cumsum(steps)))
    counts = np.where(rng.random(spans - 1) < 0.7, 1, rng.integers(1, degree + 1, spans - 1))
    inner = np.repeat(breaks[1:-1], counts)
    if form == "ring":
        seam = np.full(rng.integers(1, degree + 1), breaks[-1])
        turn = np.concatenate((breaks[:1], inner, seam))
        m = len(turn) - 1
        weights = rng.uniform(0.5, 2.0, m) if rational else None
        return BSpline.closed(turn, rng.uniform(-1.0, 1.0, (m, dim)), degree, weights)
    outer = np.zeros((2, degree))
    if form == "unclamped":
        outer = np.cumsum(rng.uniform(0.1, 1.0, (2, degree)), axis=1)
    knots = np.concatenate(
        (breaks[0] - outer[0, ::-1], breaks[:1], inner, breaks[-1:], breaks[-1] + outer[1])
    )
    m = len(knots) - degree - 1
    weights = rng.uniform(0.5, 2.0, m) if rational else None
    return BSpline(knots, rng.uniform(-1.0, 1.0, (m, dim)), degree, weights)


@pytest.fixture(scope="session")
def random_curve():
    return make_curve


@pytest.fixture(scope="session")
def places():
    """Parameters on every piece of a curve, its knots among them, its jumps left out."""

    def parameters(curve, count=7):
        pieces = zip(curve.breaks[:-1], curve.breaks[1:], strict=True)
        return np.unique(np.concatenate([np.linspace(a, b, count) for a, b in pieces]))

    return parameters


@pytest.fixture(scope="session")
def circle():
    """The unit circle of nine control points, degree 2, over 0 to 4."""
    points = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]]
    knots = [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4]
    s = np.sqrt(0.5)
    return BSpline(knots, points, 2, [1, s, 1, s, 1, s, 1, s, 1])
