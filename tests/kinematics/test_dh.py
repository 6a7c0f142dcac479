from math import inf, nan, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.joints import JointKind
from splinearm.kinematics import DHConvention, DHLink, space

seeds = st.integers(0, 100_000)
kinds = st.sampled_from(list(JointKind))


def some_row(seed, kind):
    a, d = np.random.default_rng(seed).uniform(-0.5, 0.5, 2)
    alpha, theta = np.random.default_rng(seed + 1).uniform(-pi, pi, 2)
    return DHLink("joint", a, alpha, d, theta, kind)


def parts(row, q):
    """Give Rz(theta), Tz(d), Tx(a), Rx(alpha) with q where it belongs."""
    turn, slide = (q, 0.0) if row.kind is JointKind.REVOLUTE else (0.0, q)
    return (
        space.rotation_z(row.theta + turn),
        space.translation((0.0, 0.0, row.d + slide)),
        space.translation((row.a, 0.0, 0.0)),
        space.rotation_x(row.alpha),
    )


@pytest.mark.property
@given(seeds, kinds, st.floats(-4.0, 4.0))
@settings(deadline=None)
def test_a_standard_row_is_rz_tz_tx_rx(seed, kind, q):
    row = some_row(seed, kind)
    Rz, Tz, Tx, Rx = parts(row, q)
    T = row.matrix(q, DHConvention.STANDARD)
    np.testing.assert_allclose(T, Rz @ Tz @ Tx @ Rx, atol=1e-15)


@pytest.mark.property
@given(seeds, kinds, st.floats(-4.0, 4.0))
@settings(deadline=None)
def test_a_modified_row_is_rx_tx_rz_tz(seed, kind, q):
    row = some_row(seed, kind)
    Rz, Tz, Tx, Rx = parts(row, q)
    T = row.matrix(q, DHConvention.MODIFIED)
    np.testing.assert_allclose(T, Rx @ Tx @ Rz @ Tz, atol=1e-15)


def test_the_standard_row_has_the_printed_entries():
    # Spong, Hutchinson, Vidyasagar, Robot Modeling and Control, 2006, eq. 3.10
    a, alpha, d, theta = 0.3, 0.4, 0.5, 0.6
    ca, sa, ct, st_ = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
    printed = [
        [ct, -st_ * ca, st_ * sa, a * ct],
        [st_, ct * ca, -ct * sa, a * st_],
        [0.0, sa, ca, d],
        [0.0, 0.0, 0.0, 1.0],
    ]
    row = DHLink("joint", a, alpha, d, 0.0)
    np.testing.assert_allclose(row.matrix(theta, DHConvention.STANDARD), printed, atol=1e-15)


def test_the_modified_row_has_the_printed_entries():
    # Craig, Introduction to Robotics, 3rd ed. 2005, eq. 3.6
    a, alpha, d, theta = 0.3, 0.4, 0.5, 0.6
    ca, sa, ct, st_ = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
    printed = [
        [ct, -st_, 0.0, a],
        [st_ * ca, ct * ca, -sa, -sa * d],
        [st_ * sa, ct * sa, ca, ca * d],
        [0.0, 0.0, 0.0, 1.0],
    ]
    row = DHLink("joint", a, alpha, d, 0.0)
    np.testing.assert_allclose(row.matrix(theta, DHConvention.MODIFIED), printed, atol=1e-15)


@pytest.mark.property
@given(seeds, st.integers(1, 8))
@settings(deadline=None)
def test_a_standard_table_shifted_by_half_a_row_is_a_modified_one(seed, n):
    # Rz Tz of row i and Tx Rx of row i - 1 are the modified row i: the same numbers, one row later
    rng = np.random.default_rng(seed)
    rows = [some_row(seed + 10 * i, list(JointKind)[rng.integers(2)]) for i in range(n)]
    first = DHLink("none", 0.0, 0.0, 0.0, 0.0)
    shifted = [
        DHLink(row.name, before.a, before.alpha, row.d, row.theta, row.kind)
        for before, row in zip([first, *rows[:-1]], rows, strict=True)
    ]
    q = rng.uniform(-pi, pi, n)
    standard, modified = np.eye(4), np.eye(4)
    for row, half, value in zip(rows, shifted, q, strict=True):
        standard = standard @ row.matrix(value, DHConvention.STANDARD)
        modified = modified @ half.matrix(value, DHConvention.MODIFIED)
    tail = space.translation((rows[-1].a, 0.0, 0.0)) @ space.rotation_x(rows[-1].alpha)
    np.testing.assert_allclose(modified @ tail, standard, atol=1e-13)


@pytest.mark.parametrize("value", [nan, inf])
def test_a_row_that_is_not_finite_is_refused_by_name(value):
    with pytest.raises(ValueError, match="link 'elbow': d: want a finite number"):
        DHLink("elbow", 0.0, 0.0, value, 0.0)
