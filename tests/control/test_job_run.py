"""Jobs from their plan to their report: the runner with the loop, on MuJoCo and virtual servos."""

import json
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from splinearm import stage
from splinearm.backends import Station, open_arm
from splinearm.config import demo_job, load_cell
from splinearm.control.clock import WallClock
from splinearm.control.ending import ExitReason, Outcome
from splinearm.control.realtime import Footing
from splinearm.errors import ConfigError, FollowingError, MotionError
from splinearm.runner import carry_out_job, plan_job, resume, run_job


@pytest.fixture(scope="module")
def planned():
    job = demo_job()
    return plan_job(job, load_cell(job.arm))


@pytest.fixture
def station(planned):
    with open_arm(planned.cell, "mujoco") as opened:
        yield opened


@pytest.mark.sim
def test_a_job_that_was_stopped_goes_on_from_there_to_its_end(planned, station, interrupted):
    said: list[str] = []
    first = carry_out_job(planned, interrupted(station, 220), announce=said.append)
    assert first.outcome is Outcome.STOPPED
    assert first.recorder.cycles
    assert any(line.startswith("stop asked for: stopping along the path in") for line in said)
    assert any(line.startswith("a stop takes up to") for line in said)
    with pytest.raises(ValueError, match="finished"):
        resume(resume(first, station), station)
    np.testing.assert_allclose(station.driver.goal, planned.plan.trajectory.q_goal, atol=1e-6)


@pytest.mark.sim
def test_the_rest_of_a_job_stays_on_its_path(planned, station, interrupted):
    first = carry_out_job(planned, interrupted(station, 260))
    second = resume(first, station)
    assert second.ending.reason is ExitReason.SUCCESSFUL
    for result in (first, second):
        assert result.tracking.path_commanded.worst <= 5e-5
        assert result.tracking.path_measured.worst <= 2e-3
    left = planned.plan.trajectory.duration - first.ending.stopped.t
    assert left <= second.recorder.cycles[-1].t <= left + 0.3


@pytest.mark.sim
def test_a_stop_on_the_way_to_the_start_leaves_the_whole_motion(planned, station, interrupted):
    first = carry_out_job(planned, interrupted(station, 20))
    assert first.outcome is Outcome.STOPPED
    assert first.recorder.cycles == []
    assert first.document()["tracking"] is None
    assert resume(first, station).outcome is Outcome.FINISHED


@pytest.mark.sim
def test_a_fault_is_raised_or_given_with_what_is_known(planned, station):
    strict = replace(planned.job, tolerances={"path": np.full(2, 1e-6), "lag": np.zeros(2)})
    watched = replace(planned, job=strict)
    result = carry_out_job(watched, station)
    assert result.outcome is Outcome.FAILED
    assert isinstance(result.ending.fault, FollowingError)
    document = result.document()
    assert document["error_code"] == -4
    assert document["error_name"] == "PATH_TOLERANCE_VIOLATED"
    assert document["error_string"] == str(result.ending.fault)
    with pytest.raises(FollowingError) as caught:
        run_job(watched, station)
    assert caught.value.stopped is not None


@pytest.mark.sim
def test_a_report_is_json_with_units_in_its_keys(planned, station):
    document = run_job(planned, station).document()
    assert json.loads(json.dumps(document, allow_nan=False)) == document
    assert (document["schema"], document["error_code"]) == ("splinearm-run/1", 0)
    assert set(document["tracking"]["joints"]) == {"joint1", "joint2"}
    assert document["loop"]["missed"] == 0
    assert document["real_time"] is None
    assert document["stop_forecast"]["tool_mm"] > 0.0


@pytest.mark.sim
def test_an_observer_sees_every_cycle_and_its_error_comes_through(planned, station):
    seen: list[int] = []
    result = run_job(planned, station, observe=lambda cycle: seen.append(cycle.index))
    assert seen == [cycle.index for cycle in result.recorder.cycles]

    def fail(cycle):
        raise KeyError(cycle.index)

    with pytest.raises(KeyError):
        run_job(planned, station, observe=fail)


@contextmanager
def no_permission():
    yield Footing(fifo=False, locked=False)


class LateClock(WallClock):
    """A clock of a computer that wakes just so late, however busy the one of the test is."""

    late = 0.0

    def wait_until(self, t):
        super().wait_until(t)
        return self.late


@pytest.fixture
def late_station(station, monkeypatch):
    monkeypatch.setattr(stage, "real_time", no_permission)
    monkeypatch.setattr(stage, "REHEARSAL", 0.05)
    return Station(driver=station.driver, clock=LateClock(), where="here")


@pytest.mark.sim
def test_without_permission_the_rate_is_lowered_and_that_is_said(planned, late_station):
    said: list[str] = []
    late_station.clock.late = 7e-3
    job = replace(planned.job, rate=200.0)
    period = stage._period(job, late_station, Footing(fifo=False, locked=False), said.append)
    assert period == pytest.approx(1 / 30)
    assert "no real-time priority" in said[0]
    assert said[1].startswith("going at 30 setpoints a second, not 200: up to 7.0 ms late")


@pytest.mark.sim
def test_a_computer_that_can_hold_no_rate_is_told_before_anything_moves(planned, late_station):
    late_station.clock.late = 0.2
    with pytest.raises(MotionError, match="cannot hold 20 setpoints a second"):
        carry_out_job(planned, late_station)


@pytest.mark.bus
def test_on_virtual_servos_each_servo_is_counted(planned):
    with open_arm(planned.cell, "virtual") as station:
        result = carry_out_job(planned, station)
    assert result.outcome is Outcome.FINISHED
    assert [servo.joint for servo in result.loop.servos] == ["joint1", "joint2"]
    for servo in result.loop.servos:
        assert servo.reads >= len(result.recorder.cycles)
    assert result.footing is not None
    assert result.tracking.path_measured.worst <= 5e-3


@pytest.mark.sim
def test_a_log_that_cannot_be_written_leaves_no_empty_rows_behind(planned, station, tmp_path):
    pytest.importorskip("mcap", reason="the extra log is not installed")
    rows, log = tmp_path / "rows.csv", tmp_path / "run.mcap"
    log.write_text("mine")
    with pytest.raises(ConfigError, match="is there already"):
        run_job(planned, station, csv=rows, mcap=log)
    assert not rows.exists()


@pytest.mark.sim
def test_every_cycle_is_in_both_files(planned, station, tmp_path):
    pytest.importorskip("mcap", reason="the extra log is not installed")
    from mcap.reader import make_reader

    rows, log = tmp_path / "rows.csv", tmp_path / "run.mcap"
    result = run_job(planned, station, csv=rows, mcap=log)
    count = len(result.recorder.cycles)
    assert len(rows.read_text().splitlines()) == count + 1
    with log.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert set(summary.statistics.channel_message_counts.values()) == {count}


@pytest.mark.sim
def test_a_fault_on_the_way_to_the_start_leaves_the_whole_motion(planned, station):
    start = planned.plan.trajectory.q_start
    tight = {"path": np.full(2, 1e-9), "lag": np.zeros(2), "start": np.full(2, 1.0)}
    watched = replace(planned, job=replace(planned.job, tolerances=tight))
    result = carry_out_job(watched, station)
    assert result.outcome is Outcome.FAILED
    assert result.recorder.cycles == []
    assert result.ending.fault.stopped is result.ending.stopped
    np.testing.assert_allclose(result.ending.stopped.remaining().q_start, start, atol=1e-9)
