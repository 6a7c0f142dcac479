"""Jobs of pieces beside what they are made of."""

import pytest

from splinearm.config import load_cell, load_job, save_motion
from splinearm.trajectories.plan import plan_joint_move

HEAD = 'schema = "splinearm-job/1"\nname = "many"\ntitle = "Many pieces"\narm = "{arm}"\n'
REACH = '[[waypoint]]\nthrough = "joint"\njoints_deg = [10.0, 40.0]\n'
WAVE = """[[piece]]
name = "wave"
degree = 3
knots = [0.0, 0.0, 0.0, 0.0, 0.4, 0.4, 0.4, 0.4]
points_deg = [[20.0, 60.0], [20.0, 60.0], [26.0, 55.0], [26.0, 55.0]]
"""
SAVED = '[[piece]]\nname = "saved"\nmotion = "saved.json"\n'


@pytest.fixture(autouse=True)
def short_rehearsal(monkeypatch):
    """No test here is about the rate that this computer holds."""
    monkeypatch.setattr("splinearm.stage.REHEARSAL", 0.05)


@pytest.fixture(scope="session")
def pieces():
    """The texts of pieces, by name; ``head`` takes the arm."""
    return {
        "head": HEAD,
        "reach": REACH,
        "wave": WAVE,
        "saved": SAVED,
        "job": '[[piece]]\nname = "there"\njob = "reach.toml"\n',
        "open": '[[piece]]\nname = "open"\ngripper = "open"\n',
        "close": '[[piece]]\nname = "close"\ngripper = "close"\n',
    }


@pytest.fixture
def load(tmp_path, pieces):
    """Load a job text of the planar arm, beside a saved motion and another job."""
    limits = load_cell("planar_2r").arm.limits
    save_motion(tmp_path / "saved.json", plan_joint_move(limits, [0.3, 0.8], [0.4, 0.7]))
    (tmp_path / "reach.toml").write_text(pieces["head"].format(arm="planar_2r") + pieces["reach"])

    def loaded(text, arm="planar_2r"):
        file = tmp_path / "job.toml"
        file.write_text(pieces["head"].format(arm=arm) + text)
        return load_job(file)

    return loaded
