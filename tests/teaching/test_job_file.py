"""Job files of taught pieces: written, read again, added to, and never spoilt."""

import numpy as np
import pytest

from splinearm.config import load_job
from splinearm.errors import ConfigError
from splinearm.teaching.job_file import append_to_job, new_job
from splinearm.trajectories.taught import TaughtMotion


@pytest.fixture
def motion(planar):
    points = np.radians([[-45.0, 90.0], [-40.0, 90.0], [-30.0, 80.0], [-20.1234, 80.0]])
    return TaughtMotion(
        names=planar.arm.joint_names,
        degree=3,
        knots=[0.0] * 4 + [1.25] * 4,
        points=points,
        rests=((0.5, 0.7),),
        words="within 1 mm",
    )


def test_a_job_comes_back_as_it_was_written(planar, motion, tmp_path):
    file = tmp_path / "job.toml"
    new_job(file, planar, [motion, "close", motion, "open"], 'to "pick"')
    job = load_job(file)
    assert job.name == 'to "pick"'
    assert job.timing == "recorded"
    assert [piece.name for piece in job.pieces] == ["piece 1", "piece 2", "piece 3", "piece 4"]
    np.testing.assert_allclose(job.q_start, motion.q_start, atol=1e-15)
    with pytest.raises(ConfigError, match="not overwritten"):
        new_job(file, planar, [motion], "again")


def test_pieces_are_added_behind_those_that_are_there(planar, motion, tmp_path):
    file = tmp_path / "job.toml"
    new_job(file, planar, [motion], "job")
    append_to_job(file, planar, ["close", motion])
    assert [piece.name for piece in load_job(file).pieces] == ["piece 1", "piece 2", "piece 3"]
    assert {one.name for one in tmp_path.iterdir()} == {"job.toml"}


def test_a_job_of_waypoints_is_not_added_to(planar, motion, tmp_path):
    file = tmp_path / "job.toml"
    text = (
        'schema = "splinearm-job/1"\nname = "a"\ntitle = "A"\narm = "planar_2r"\n'
        "[[waypoint]]\njoints_deg = [0.0, 30.0]\n"
    )
    file.write_text(text)
    with pytest.raises(ConfigError, match="no pieces"):
        append_to_job(file, planar, [motion])
    assert file.read_text() == text


def test_an_arm_of_ones_own_is_named_by_its_path(planar, motion, tmp_path):
    from splinearm.config import load_cell

    own = tmp_path / "arms" / "mine.toml"
    own.parent.mkdir()
    own.write_text(planar.file.read_text())
    file = tmp_path / "job.toml"
    new_job(file, load_cell(own), [motion], "job")
    assert 'arm = "arms/mine.toml"' in file.read_text()
    assert load_job(file).arm == own
