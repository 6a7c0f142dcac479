import numpy as np
import pytest

from splinearm.config import load_job
from splinearm.control.tolerance import Tolerances
from splinearm.errors import ConfigError
from splinearm.joints import JointKind

JOB = """
schema = "splinearm-job/1"
name = "one"
title = "One move"
arm = "planar_2r"
{tolerance}
[[waypoint]]
joints_deg = [10.0, 20.0]
through = "joint"
"""


@pytest.fixture
def job(tmp_path):
    def make(tolerance="", motion=""):
        file = tmp_path / "job.toml"
        text = f"[motion]\n{motion}\n[tolerance]\n{tolerance}\n"
        file.write_text(JOB.format(tolerance=text))
        return load_job(file)

    return make


def test_tolerances_are_for_all_joints_or_one_each(job):
    given = job("path_deg = 2.0\ngoal_deg = [1.0, 0.5]\nlag_s = 0.0\nsettle_s = [2.0, 3.0]")
    tolerances = given.tolerances
    np.testing.assert_allclose(np.rad2deg(tolerances["path"]), [2.0, 2.0])
    np.testing.assert_allclose(np.rad2deg(tolerances["goal"]), [1.0, 0.5])
    np.testing.assert_array_equal(tolerances["lag"], [0.0, 0.0])
    np.testing.assert_array_equal(tolerances["settle"], [2.0, 3.0])
    assert "start" not in tolerances


def test_without_the_table_nothing_differs_from_the_usual(job):
    assert dict(job().tolerances) == {}


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("path_deg = 0.0", "above zero"),
        ("goal_deg = [1.0, -1.0]", "above zero"),
        ("goal_deg = [1.0]", "one a joint"),
        ("lag_s = -0.1", "above zero"),
        ("settle_s = 0", "above zero"),
        ("path_mm = 1.0", "path_deg"),
        ("pathh_deg = 1.0", "did you mean 'path_deg'"),
    ],
)
def test_a_tolerance_that_means_nothing_is_refused_with_its_key(job, line, reason):
    with pytest.raises(ConfigError, match=reason) as caught:
        job(line)
    assert caught.value.key.startswith("tolerance.")


def test_a_feedforward_is_one_of_those_there_are(job):
    assert job().feedforward is None
    assert job(motion='feedforward = "off"').feedforward == "off"
    with pytest.raises(ConfigError, match="full"):
        job(motion='feedforward = "all"')


def test_a_sliding_joint_may_be_off_by_millimetres_not_by_what_degrees_are_in_radians():
    usual = Tolerances.usual((JointKind.REVOLUTE, JointKind.PRISMATIC))
    np.testing.assert_allclose(usual.path, [np.deg2rad(8.0), 0.02])
    np.testing.assert_allclose(usual.goal, [np.deg2rad(5.0), 0.01])
    np.testing.assert_allclose(usual.start, [np.deg2rad(0.25), 0.0005])
