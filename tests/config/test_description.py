import numpy as np
import pytest

from splinearm.config import load_cell, shipped_arms
from splinearm.errors import ConfigError
from splinearm.kinematics import DHConvention, screw
from splinearm.kinematics.dh_conversion import to_dh
from splinearm.kinematics.mjcf import read_mjcf, write_mjcf
from splinearm.kinematics.urdf import read_urdf, write_urdf


def through_screws(arm):
    home = arm.fk(np.zeros(arm.n))
    inertias = screw.inertias_of(arm)
    return screw.from_screws(arm.name, screw.screws_of(arm), home, arm.limits, inertias=inertias)


WAYS = {
    "standard": lambda arm: to_dh(arm, DHConvention.STANDARD),
    "modified": lambda arm: to_dh(arm, DHConvention.MODIFIED),
    "screws": through_screws,
    "urdf": lambda arm: read_urdf(write_urdf(arm)).arm,
    "mjcf": lambda arm: read_mjcf(write_mjcf(arm)).arm,
}


def assert_same(arm, like):
    q = np.random.default_rng(1).uniform(-2.0, 2.0, (20, like.n))
    np.testing.assert_allclose(arm.fk(q), like.fk(q), rtol=0, atol=1e-12)
    np.testing.assert_allclose(arm.jacobian(q), like.jacobian(q), rtol=0, atol=1e-12)
    for name in ("q_min", "q_max", "qd_max", "qdd_max", "torque_max"):
        np.testing.assert_array_equal(getattr(arm.limits, name), getattr(like.limits, name))
    for have, want in zip(screw.inertias_of(arm), screw.inertias_of(like), strict=True):
        assert have.mass == pytest.approx(want.mass, abs=1e-12)
        np.testing.assert_allclose(have.com, want.com, atol=1e-12)
        np.testing.assert_allclose(have.tensor, want.tensor, atol=1e-12)


@pytest.mark.parametrize("name", shipped_arms())
def test_a_shipped_arm_goes_round_through_every_two_descriptions(name):
    arm = load_cell(name).arm
    for first in WAYS.values():
        there = first(arm)
        assert_same(there, arm)
        for then in WAYS.values():
            assert_same(then(there), arm)


@pytest.mark.parametrize(("suffix", "write"), [("urdf", write_urdf), ("xml", write_mjcf)])
def test_a_description_file_is_a_cell_without_servos(tmp_path, suffix, write):
    arm = load_cell("wx250s").arm
    file = tmp_path / f"mine.{suffix}"
    file.write_text(write(arm), encoding="utf-8")
    cell = load_cell(file)
    assert_same(cell.arm, arm)
    assert cell.chain is None
    assert cell.name == "wx250s"
    np.testing.assert_array_equal(cell.poses["home"], np.zeros(6))
    cell.arm.limits.check(cell.poses["home"])


def test_home_is_within_the_limits_where_zero_is_not(tmp_path):
    arm = load_cell("planar_2r").arm
    text = write_urdf(arm).replace('lower="', 'lower="0.5" was="')
    file = tmp_path / "mine.urdf"
    file.write_text(text, encoding="utf-8")
    cell = load_cell(file)
    np.testing.assert_allclose(cell.poses["home"], 0.5 * (0.5 + arm.limits.q_max))


def test_a_tip_is_chosen_by_name_and_only_where_there_are_some(tmp_path):
    file = tmp_path / "mine.urdf"
    file.write_text(write_urdf(load_cell("wx250s").arm), encoding="utf-8")
    assert load_cell(file, tip="forearm_roll_link").arm.n == 4
    with pytest.raises(ConfigError, match="'nose': is not there"):
        load_cell(file, tip="nose")
    with pytest.raises(ConfigError, match="takes no tip"):
        load_cell("wx250s", tip="nose")
    with pytest.raises(ConfigError, match="cannot be read"):
        load_cell(tmp_path / "none.urdf")
