"""Places saved as waypoints of a job."""

import numpy as np
import pytest

from splinearm.config import load_cell, load_job
from splinearm.errors import ConfigError
from splinearm.jogging.waypoint import WaypointFile, pose_words
from splinearm.units import DEG


@pytest.fixture(scope="module")
def cell():
    return load_cell("planar_2r")


PLACES = np.array([[10.0, 20.0], [30.0, -40.0], [50.0, 60.0]]) * DEG


def test_places_make_a_job_that_goes_there(cell, tmp_path):
    file = tmp_path / "mine.toml"
    saved = WaypointFile(file, cell)
    assert "new job" in saved.save(PLACES[0])
    assert "p1" in saved.save(PLACES[1])
    again = WaypointFile(file, cell)  # as on another day
    assert "p2" in again.save(PLACES[2])
    job = load_job(file)
    np.testing.assert_allclose(job.q_start, PLACES[0], atol=1e-4 * DEG)
    assert [waypoint.name for waypoint in job.waypoints] == ["p1", "p2"]
    for waypoint, q in zip(job.waypoints, PLACES[1:], strict=True):
        np.testing.assert_allclose(waypoint.q, q, atol=1e-4 * DEG)


def test_an_arm_file_of_ones_own_is_found_from_anywhere(cell, tmp_path):
    arm = tmp_path / "arm.toml"
    arm.write_text(cell.file.read_text())
    file = tmp_path / "jobs" / 'my "own" \\ job.toml'  # a name that TOML must escape
    file.parent.mkdir()
    saved = WaypointFile(file, load_cell(arm))
    for q in PLACES:
        saved.save(q)
    job = load_job(file)
    assert job.arm.resolve() == arm.resolve()
    assert job.name == 'my "own" \\ job'


def test_without_a_file_the_lines_are_kept(cell):
    saved = WaypointFile(None, cell)
    saved.save(PLACES[0])
    assert saved.lines[0].startswith('[[waypoint]]\nname = "p1"\njoints_deg = [10.000, 20.000]')


def test_a_name_that_is_taken_is_not_given_again(cell, tmp_path):
    file = tmp_path / "job.toml"
    file.write_text('schema = "splinearm-job/1"\n[[waypoint]]\nname = "p1"\n')
    assert "p2" in WaypointFile(file, cell).save(PLACES[0])


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("not = = toml", "cannot be added to"),
        ('schema = "splinearm-arm/1"', "no job file"),
        ('schema = "splinearm-job/1"\n[[piece]]\n', "takes no waypoints"),
    ],
)
def test_what_is_no_job_with_waypoints_is_left_alone(cell, tmp_path, text, wanted):
    file = tmp_path / "other.toml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=wanted):
        WaypointFile(file, cell)
    assert file.read_text() == text


def test_a_folder_that_is_not_there_is_said(cell, tmp_path):
    saved = WaypointFile(tmp_path / "none" / "job.toml", cell)
    with pytest.raises(ConfigError, match="cannot be written"):
        saved.save(PLACES[0])


def test_a_pose_is_said_in_mm_and_degrees(cell):
    words = pose_words(cell, np.zeros(2))
    x = cell.arm.fk(np.zeros(2))[0, 3] * 1e3
    assert words.startswith(f"x {x:.1f}  y 0.0")
    assert words.endswith("roll 0.0  pitch 0.0  yaw 0.0 deg")
