"""Recordings as tables: there and back, as the recorder writes them, and spoilt ones."""

import numpy as np
import pytest

from splinearm.errors import ConfigError
from splinearm.teaching.rows import read_rows, rows_text


@pytest.fixture
def table(planar, tmp_path):
    """Writes a table and reads it."""

    def read(text):
        file = tmp_path / "rows.csv"
        file.write_text(text, encoding="utf-8")
        return read_rows(file, planar.arm.limits)

    return read


def test_what_is_written_comes_back(planar, table, recording_of):
    rng = np.random.default_rng(0)
    wanted = recording_of(planar, np.arange(50) * 0.01, rng.normal(size=(50, 2)))
    found = table(rows_text(wanted, planar.arm.limits))
    np.testing.assert_allclose(found.t, wanted.t)
    np.testing.assert_allclose(found.q, wanted.q, atol=1e-9)


def test_what_the_recorder_writes_is_read_by_what_was_measured(table):
    head = "cycle,t_s,joint1_wanted_deg,joint2_wanted_deg,joint1_measured_deg,joint2_measured_deg\n"
    found = table(head + "0,0.0,1,2,10,20\n1,0.01,1,2,,\n2,0.02,1,2,11,21\n\n")
    np.testing.assert_allclose(np.degrees(found.q), [[10, 20], [11, 21]])
    assert found.lost == 1


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "t_s"),
        ("t_s,joint1_deg\n0,1\n", "joint2_measured_deg"),
        ("t_s,joint1_deg,joint2_deg\n0,1\n", "line 2: want 3 cells"),
        ("t_s,joint1_deg,joint2_deg\n0,1,x\n", "line 2: want finite numbers"),
        ("t_s,joint1_deg,joint2_deg\n0,1,nan\n", "line 2: want finite numbers"),
        ("t_s,joint1_deg,joint2_deg\n0,1,2\n0,1,2\n", "does not rise after 0 s"),
    ],
)
def test_a_spoilt_table_is_refused_with_the_place(table, text, words):
    with pytest.raises(ConfigError, match=words):
        table(text)


def test_a_table_that_is_not_there_is_refused(planar, tmp_path):
    with pytest.raises(ConfigError, match="cannot be read"):
        read_rows(tmp_path / "none.csv", planar.arm.limits)


def test_a_part_is_cut_by_times(planar, recording_of):
    t = 3.0 + np.arange(100) * 0.01
    recording = recording_of(planar, t, np.zeros((100, 2)))
    assert recording.between(0.1, 0.2).t == pytest.approx(t[10:21])
    with pytest.raises(ValueError, match="rising"):
        recording.between(0.5, 0.4)
