from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.errors import KinematicsError
from splinearm.joints import JointKind
from splinearm.kinematics import DHConvention, DHLink, screw
from splinearm.kinematics.dh_conversion import to_dh

seeds = st.integers(0, 100_000)
conventions = st.sampled_from(list(DHConvention))


def figures(arm):
    return np.array([[row.a, row.alpha, row.d, row.theta] for row in arm.dh])


@pytest.mark.property
@given(seeds, st.integers(1, 8), conventions, conventions)
@settings(deadline=None, max_examples=100)
def test_any_arm_becomes_a_table_of_either_convention(
    random_arm, assert_same_arm, seed, n, first, then
):
    arm = random_arm(seed, n, first)
    table = to_dh(arm, then)
    assert table.convention is then
    assert_same_arm(table, arm)
    # what was made once stays as it is, however it is described in between
    screws, home = screw.screws_of(table), table.fk([0.0] * n)
    again = to_dh(screw.from_screws("again", screws, home, arm.limits), then)
    np.testing.assert_allclose(np.cos(figures(again)), np.cos(figures(table)), atol=1e-9)


@pytest.mark.parametrize("convention", list(DHConvention))
def test_parallel_and_coincident_axes_get_rows_without_noise(dh_arm, convention, assert_same_arm):
    rows = [
        DHLink("lift", 0.0, 0.0, 0.1, 0.0, JointKind.PRISMATIC),
        DHLink("turn", 0.3, 0.0, 0.2, 0.0),
        DHLink("bend", 0.25, pi, 0.0, 0.0),
        DHLink("plunge", 0.0, 0.0, 0.05, 0.0, JointKind.PRISMATIC),
        DHLink("roll", 0.0, 0.0, 0.0, 0.0),
        DHLink("spin", 0.0, 0.0, 0.0, 0.0),
    ]
    arm = dh_arm(rows, DHConvention.STANDARD)
    table = to_dh(arm, convention)
    assert_same_arm(table, arm)
    values = figures(table)
    assert set(np.round(values.ravel(), 12)) <= {0.0, 0.3, 0.25, np.round(pi, 12), 0.1, 0.2}


def test_the_table_of_a_planar_arm_comes_back_as_it_was(planar):
    back = to_dh(to_dh(planar, DHConvention.MODIFIED), DHConvention.STANDARD)
    np.testing.assert_allclose(figures(back), figures(planar), atol=1e-15)
    np.testing.assert_allclose(back.T_base_first, np.eye(4), atol=0)
    np.testing.assert_allclose(back.T_flange_tool, np.eye(4), atol=1e-15)


def test_axes_that_are_almost_parallel_are_refused_with_their_names(dh_arm):
    rows = [DHLink(name, 0.3, 0.0, 0.0, 0.4) for name in ("one", "two", "three")]
    arm = dh_arm(rows, DHConvention.STANDARD)
    turned = screw.screws_of(arm)
    turned[1, 3:] += (1e-8, 0.0, 0.0)
    turned[1, 3:] /= np.linalg.norm(turned[1, 3:])
    turned[1, :3] = np.cross([0.3, 0.1, 0.0], turned[1, 3:])
    off = screw.from_screws("off", turned, arm.fk([0.0] * 3), arm.limits)
    with pytest.raises(KinematicsError, match=r"'one' and 'two'.*from parallel"):
        to_dh(off, DHConvention.MODIFIED)
