from pathlib import Path

import numpy as np
import pytest

from splinearm.config import load_cell, shipped_arms
from splinearm.errors import ConfigError


def test_a_user_s_own_file_is_just_one_more_path(arm_text, written):
    path = written(arm_text)
    for given in (path, str(path)):
        cell = load_cell(given)
        assert (cell.name, cell.title, cell.file) == ("two", "Two joints", path)
        assert cell.arm.name == "two"
        assert (cell.licence, cell.notice) == ("", "")


def test_a_cell_gives_a_file_that_loads_it_again():
    assert load_cell(load_cell("wx250s").file).name == "wx250s"


def test_an_arm_that_is_not_there_is_told_which_are():
    with pytest.raises(ConfigError) as caught:
        load_cell("wx250")
    assert caught.value.file == "wx250"
    for name in shipped_arms():
        assert name in caught.value.reason


def test_a_path_that_is_not_there_is_no_name():
    with pytest.raises(ConfigError, match="cannot be read"):
        load_cell("nowhere/arm.toml")


def test_the_places_of_base_and_tool_are_read(arm_text, written, edited):
    text = edited(
        arm_text,
        "[tool]",
        "[world]\nxyz_mm = [0, 0, 500]\n[base]\nrpy_deg = [0, 0, 90]\n[tool]\n"
        "quat_wxyz = [0.70710678, 0.0, 0.70710678, 0.0]",
    )
    arm = load_cell(written(text)).arm
    np.testing.assert_array_equal(arm.T_world_base[:3, 3], [0.0, 0.0, 0.5])
    np.testing.assert_allclose(arm.T_base_first[:3, 0], [0.0, 1.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(arm.T_flange_tool[:3, 2], [1.0, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(arm.fk([0.0, 0.0])[:3, 3], [0.0, 0.55, 0.06], atol=1e-15)


def test_poses_are_named_joint_vectors(arm_text, written, edited):
    text = edited(arm_text, "home_deg = [10.0, 20.0]", "home_deg = [10, 20]\naway_deg = [90, -90]")
    cell = load_cell(written(text))
    assert list(cell.poses) == ["home", "away"]
    np.testing.assert_allclose(cell.poses["away"], [np.pi / 2, -np.pi / 2])
    with pytest.raises(ValueError, match="read-only"):
        cell.poses["home"][0] = 1.0


def test_joint_vectors_go_to_the_units_of_the_file_and_back(sliding_arm_text, written):
    cell = load_cell(written(sliding_arm_text))
    np.testing.assert_allclose(cell.to_file_units(np.array([np.pi, 0.02])), [180.0, 20.0])
    np.testing.assert_allclose(cell.from_file_units(np.array([180.0, 20.0])), [np.pi, 0.02])


@pytest.mark.parametrize(
    ("change", "key", "remedy"),
    [
        (('title = "Two joints"\n', ""), "title", "is missing; give a text in quotes"),
        (('title = "Two joints"', "title = 2"), "title", "wants a text in quotes"),
        (("[tool]", "[tol]"), "tol", "did you mean 'tool'"),
        (
            ("xyz_mm = [250.0, 0.0, 0.0]", "xyz_m = [0.25, 0, 0]"),
            "tool.xyz_m",
            "millimetres: xyz_mm",
        ),
        (("home_deg = [10.0, 20.0]", "away_deg = [1, 2]"), "poses.home_deg", "is missing; give 2"),
        (
            ("home_deg = [10.0, 20.0]", "home_rad = [1, 2]"),
            "poses.home_rad",
            "wants degrees: home_deg",
        ),
        (
            ("[10.0, 20.0]", "[10.0, 20.0, 30.0]"),
            "poses.home_deg",
            "one a joint \\(shoulder, elbow\\)",
        ),
        (
            ("[10.0, 20.0]", "[10.0, 140.5]"),
            "poses.home_deg",
            "joint 'elbow': position 140.5 deg is above its limit 140 deg",
        ),
        (("[10.0, 20.0]", "[-151, 0]"), "poses.home_deg", "'shoulder': position -151 deg is below"),
    ],
)
def test_a_cell_that_cannot_be_used_is_refused(change, key, remedy, arm_text, edited, refusal):
    refusal(load_cell, edited(arm_text, *change), key, remedy)


def test_a_bus_without_servos_is_read_like_any_other(sliding_arm_text, written, refusal):
    refusal(load_cell, sliding_arm_text + "[bus]\nsped = 3\n", "bus.sped", "known")
    text = sliding_arm_text + "[bus]\nbaud = 57600\nsupply_v = 12\n"
    assert load_cell(written(text)).chain is None


def test_what_leads_the_goals_is_everything_unless_the_file_says_less(arm_text, written, edited):
    assert load_cell(written(arm_text)).feedforward == "full"
    text = edited(arm_text, "[bus]", '[bus]\nfeedforward = "velocity"')
    assert load_cell(written(text)).feedforward == "velocity"


def test_an_unknown_way_to_lead_the_goals_is_refused(arm_text, edited, refusal):
    text = edited(arm_text, "[bus]", '[bus]\nfeedforward = "none"')
    refusal(load_cell, text, "bus.feedforward", '"off", "velocity", "full"')


def test_a_job_is_no_arm(job_text, written, refusal):
    remedy = 'wants "splinearm-arm/1", got "splinearm-job/1"'
    refusal(load_cell, job_text, "schema", remedy)


def test_shipped_arms_are_listed_by_name():
    assert shipped_arms() == (
        "koch_v1_1",
        "omx_f",
        "open_manipulator_x",
        "planar_2r",
        "rx150",
        "wx200",
        "wx250s",
    )
    assert all(
        load_cell(name).file == Path(load_cell(name).file).resolve() for name in shipped_arms()
    )
