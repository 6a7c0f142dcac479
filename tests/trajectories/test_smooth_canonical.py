"""The same problem in other units becomes the same numbers, to the last bit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.curves.interpolation import interpolate
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.smooth_canonical import canonical, rounded

UNITS = st.sampled_from([1e-6, 1e-3, 0.7, 3.0, 1e3, 1e6])


def problem(seed):
    rng = np.random.default_rng(seed)
    m, n = int(rng.integers(4, 10)), int(rng.integers(1, 8))
    points = rng.uniform(-2.0, 2.0, (m, n))
    u = np.cumsum(rng.uniform(0.3, 1.0, m))
    path = JointPath(interpolate(points, degree=int(rng.choice([3, 5])), parameters=u))
    return path, rng.uniform(0.5, 2.0, (3, n))


@pytest.mark.property
@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), length=UNITS, time=UNITS, parameter=UNITS)
def test_no_unit_is_left(seed, length, time, parameter):
    path, limits = problem(seed)
    curve = path.curve
    other = JointPath(BSpline(curve.knots * parameter, curve.points * length, curve.degree))
    one = canonical(path.breaks, path.coefficients, path.domain, limits, None)
    scaled = limits * length / time ** np.arange(1.0, 4.0)[:, None]
    same = canonical(other.breaks, other.coefficients, other.domain, scaled, None)
    assert same.unit == pytest.approx(one.unit * time, rel=1e-13)
    # nearly always to the last bit, unless one number lies where it is rounded up or down
    for got, want in (
        (same.way.path.breaks, one.way.path.breaks),
        (same.way.path.coefficients, one.way.path.coefficients),
        (same.way.limits, one.way.limits),
    ):
        assert (got != want).sum() <= 1
        assert got == pytest.approx(want, rel=1e-9, abs=1e-10)


@pytest.mark.property
@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), begin=st.floats(0.0, 0.9), share=st.floats(0.05, 1.0))
def test_a_part_of_a_way_has_its_slopes(seed, begin, share):
    path, limits = problem(seed)
    first, last = path.domain
    start = first + begin * (last - first)
    span = (start, start + share * (last - start))
    same = canonical(path.breaks, path.coefficients, span, limits, None)
    shares = np.linspace(0.0, 1.0, 41)
    s = same.at(shares)
    assert (s[0], s[-1]) == span
    _, slope, bend = path.sample(s)
    pace = same.length / (limits[0] * same.unit)
    got = same.way.slopes(shares)
    for value, want in ((got[0], slope * pace), (got[1], bend * pace * same.length)):
        assert value == pytest.approx(want, rel=1e-7, abs=1e-7 * np.abs(want).max())


@given(values=st.lists(st.floats(-1e300, 1e300), min_size=1, max_size=5))
def test_rounding_takes_no_more_than_a_few_digits(values):
    values = np.array(values)
    once = rounded(values)
    assert (np.abs(once - values) <= np.abs(values) * 2.0**-34).all()
    assert (rounded(once) == once).all()
