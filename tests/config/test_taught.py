"""Taught motions in files: there and back to the last digit, and spoilt ones."""

import numpy as np
import pytest

from splinearm.config import load_cell
from splinearm.config.reader import read_file
from splinearm.config.taught import read_taught, taught_text
from splinearm.errors import ConfigError
from splinearm.trajectories.taught import TaughtMotion

LIMITS = load_cell("planar_2r").arm.limits

TEXT = """\
schema = "any"
degree = 3
knots = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]
points_deg = [
    [10, 20],
    [11.5, 20],
    [12, 21],
    [13, 22.25],
]
rest_u = [0.5]
rest_s = [0.75]
"""


@pytest.fixture
def read(tmp_path):
    def reads(text):
        file = tmp_path / "taught.toml"
        file.write_text(text, encoding="utf-8")
        table = read_file(file, "any")
        found = read_taught(table, LIMITS)
        table.finish()
        return found

    return reads


def test_what_a_file_says_is_read(read):
    motion = read(TEXT)
    np.testing.assert_allclose(np.degrees(motion.points[1]), [11.5, 20.0])
    assert motion.rests == ((0.5, 0.75),)
    assert motion.duration == 1.75


def test_what_is_written_comes_back_to_the_last_bit(read):
    rng = np.random.default_rng(1)
    points = np.radians(np.round(rng.uniform(-100, 100, (9, 2)), 4))
    knots = [0.0] * 4 + sorted(np.round(rng.uniform(0.1, 6.0, 5), 4).tolist()) + [6.0123] * 4
    wanted = TaughtMotion(
        names=LIMITS.names, degree=3, knots=knots, points=points, rests=((1.2, 0.3),), words="near"
    )
    text = taught_text(wanted, LIMITS.kinds)
    found = read('schema = "any"\n' + text)
    np.testing.assert_allclose(found.points, wanted.points, rtol=1e-15)
    assert (found.knots == wanted.knots).all()
    assert (found.rests, found.words) == (wanted.rests, "near")
    assert taught_text(found, LIMITS.kinds) == text


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("degree = 3", "degree = 0", "degree"),
        ("[11.5, 20]", "[11.5]", r"points_deg\[1\]"),
        ("[11.5, 20]", '[11.5, "20"]', r"points_deg\[1\]"),
        ("knots = [0.0,", 'knots = ["0",', r"knots\[0\]"),
        ("1.0, 1.0]", "1.0]", "knots"),
        ("rest_s = [0.75]\n", "", "rest_s"),
        ("rest_s = [0.75]", "rest_s = [0.75, 1]", "rest_s"),
        ("rest_u = [0.5]", "rest_u = [1.5]", "rests"),
        ("rest_s = [0.75]", "rest_s = [1e12]", "at most 3600"),
        ("points_deg", "points_rad", "points_deg"),
        ("knots = [", "knots = 3 # [", "knots"),
    ],
)
def test_a_spoilt_one_is_refused_with_its_key(read, old, new, words):
    assert old in TEXT
    with pytest.raises(ConfigError, match=words):
        read(TEXT.replace(old, new))
