import csv
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from splinearm.control.record import Cycle, Recorder
from splinearm.errors import ConfigError
from splinearm.joints import JointKind, JointSetpoint, JointState

NAMES = ("turn", "slide")
KINDS = (JointKind.REVOLUTE, JointKind.PRISMATIC)


def cycle(index, *, answered=True):
    q = np.array([np.pi / 2, 0.05])
    setpoint = JointSetpoint(t=index * 0.01, q=q, qd=q, qdd=q)
    state = JointState(t=0.0, q=q / 2, qd=q, current=np.array([0.25, np.nan]))
    return Cycle(
        index=index,
        t=index * 0.01,
        lateness=1e-4,
        setpoint=setpoint,
        state=state if answered else None,
        busy=2e-4,
    )


def test_a_row_is_in_the_units_its_columns_wear(tmp_path):
    file = tmp_path / "run.csv"
    with Recorder(NAMES, KINDS, file) as recorder:
        recorder(cycle(0))
    (row,) = csv.DictReader(file.read_text().splitlines())
    assert float(row["turn_wanted_deg"]) == pytest.approx(90.0)
    assert float(row["slide_wanted_mm"]) == pytest.approx(50.0)
    assert float(row["turn_measured_deg"]) == pytest.approx(45.0)
    assert float(row["slide_measured_rate_mm_s"]) == pytest.approx(50.0)
    assert float(row["turn_current_a"]) == 0.25
    assert row["slide_current_a"] == ""
    assert float(row["lateness_ms"]) == pytest.approx(0.1)


def test_a_cycle_without_an_answer_leaves_its_cells_empty(tmp_path):
    file = tmp_path / "run.csv"
    with Recorder(NAMES, KINDS, file) as recorder:
        recorder(cycle(0, answered=False))
    (row,) = csv.DictReader(file.read_text().splitlines())
    assert row["turn_measured_deg"] == ""
    assert row["turn_wanted_deg"] != ""
    assert set(row) == set(csv.DictReader(file.read_text().splitlines()).fieldnames)
    assert None not in row


def lines_of(file):
    return file.read_text().splitlines()


def wait_for(file, count):
    """Wait until a file has so many lines; another process writes it."""
    give_up = time.monotonic() + 60.0
    while len(lines_of(file)) < count:
        assert time.monotonic() < give_up, lines_of(file)[-1]
        time.sleep(0.02)


def test_rows_are_on_disk_before_the_end(tmp_path):
    file = tmp_path / "run.csv"
    with Recorder(NAMES, KINDS, file) as recorder:
        for index in range(120):
            recorder(cycle(index))
        wait_for(file, 121)


def test_of_a_program_that_is_killed_no_row_is_lost(tmp_path):
    file = tmp_path / "run.csv"
    code = f"""
import os, signal, sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from pathlib import Path
from test_record import KINDS, NAMES, Recorder, cycle
recorder = Recorder(NAMES, KINDS, Path({str(file)!r})).__enter__()
for k in range(500):
    recorder(cycle(k))
os.kill(os.getpid(), signal.SIGKILL)
"""
    subprocess.run([sys.executable, "-c", code], check=False)
    wait_for(file, 501)
    assert [int(row["cycle"]) for row in csv.DictReader(lines_of(file))] == list(range(500))


def test_rows_that_the_pipe_has_no_room_for_are_not_lost(tmp_path):
    file = tmp_path / "run.csv"
    with Recorder(NAMES, KINDS, file) as recorder:
        recorder._pipe._process.send_signal(signal.SIGSTOP)
        for index in range(20_000):
            recorder(cycle(index))
        assert recorder._pipe.delayed > 0
        recorder._pipe._process.send_signal(signal.SIGCONT)
    assert [int(row["cycle"]) for row in csv.DictReader(lines_of(file))] == list(range(20_000))


def test_a_writer_that_dies_is_told_and_the_run_goes_on(tmp_path, caplog):
    file = tmp_path / "run.csv"
    with Recorder(NAMES, KINDS, file) as recorder:
        recorder._pipe._process.kill()
        recorder._pipe._process.wait()
        for index in range(10):
            recorder(cycle(index))
    assert len(recorder.cycles) == 10
    assert "are not whole" in caplog.text


def test_a_run_without_a_cycle_leaves_no_file(tmp_path):
    file = tmp_path / "run.csv"
    with Recorder(NAMES, KINDS, file):
        assert file.exists()
    assert not file.exists()


def test_a_file_that_is_there_is_not_overwritten(tmp_path):
    file = tmp_path / "run.csv"
    file.write_text("mine")
    with pytest.raises(ConfigError, match="not overwritten"):
        Recorder(NAMES, KINDS, file)
    assert file.read_text() == "mine"


def test_a_folder_that_is_not_there_is_an_error_with_the_file(tmp_path):
    with pytest.raises(ConfigError, match="cannot be written"):
        Recorder(NAMES, KINDS, tmp_path / "nowhere" / "run.csv")


def test_only_cycles_that_measured_are_given_as_arrays():
    recorder = Recorder(NAMES, KINDS)
    for index in range(4):
        recorder(cycle(index, answered=index != 2))
    t, wanted, measured, current = recorder.measured()
    np.testing.assert_allclose(t, [0.0, 0.01, 0.03])
    np.testing.assert_allclose(measured, wanted / 2)
    assert np.isnan(current[:, 1]).all()


def test_a_recorder_without_cycles_gives_empty_arrays():
    t, wanted, measured, current = Recorder(NAMES, KINDS).measured()
    assert t.shape == (0,)
    assert wanted.shape == measured.shape == current.shape == (0, 2)
