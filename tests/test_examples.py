"""Every example job is planned and carried out."""

from pathlib import Path

import numpy as np
import pytest

from splinearm.backends import open_arm
from splinearm.config import load_cell, load_job
from splinearm.control.follow import Outcome
from splinearm.runner import plan_job, run_job
from splinearm.sequence import carry_out_sequence, is_sequence, plan_sequence

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.toml"))
SEQUENCES = [file for file in EXAMPLES if is_sequence(load_job(file))]


def carry_out(file, where):
    job = load_job(file)
    planned = plan_job(job, load_cell(job.arm))
    said: list[str] = []
    with open_arm(planned.cell, where) as station:
        result = run_job(planned, station, announce=said.append)
    return result, said


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_an_example_stays_within_the_limits_it_allows(file):
    job = load_job(file)
    planned = plan_job(job, load_cell(job.arm))
    limits = planned.cell.arm.limits.scaled(job.limits_share)
    trajectory = planned.plan.trajectory
    q, qd, qdd = trajectory.sample(np.linspace(0.0, trajectory.duration, 10_000))
    assert (q >= limits.q_min).all()
    assert (q <= limits.q_max).all()
    assert (np.abs(qd) <= limits.qd_max * (1.0 + 1e-9)).all()
    assert (np.abs(qdd) <= limits.qdd_max * (1.0 + 1e-9)).all()
    np.testing.assert_allclose(qd[[0, -1]], 0.0, atol=1e-9)


@pytest.mark.sim
@pytest.mark.parametrize(
    "file", [file for file in EXAMPLES if file not in SEQUENCES], ids=lambda file: file.stem
)
def test_an_example_runs_on_mujoco(file):
    result, _ = carry_out(file, "mujoco")
    assert result.outcome is Outcome.FINISHED
    assert result.tracking.path_commanded.worst <= 5e-5
    assert result.tracking.path_measured.worst <= 2e-3
    assert result.loop.missed == 0


@pytest.mark.bus
@pytest.mark.parametrize("name", ["heart", pytest.param("inspect", marks=pytest.mark.slow)])
def test_an_example_runs_on_virtual_servos_at_100_hz(name):
    (file,) = (file for file in EXAMPLES if file.stem == name)
    result, said = carry_out(file, "virtual")
    assert result.outcome is Outcome.FINISHED
    assert result.loop.rate == 100.0
    assert result.tracking.path_commanded.worst <= 5e-5
    # every cycle is either recorded or counted as missed; a busy computer may miss a few
    cycles = result.recorder.cycles
    assert len(cycles) + result.loop.missed == cycles[-1].index + 1
    assert result.loop.missed <= 0.02 * len(cycles)
    assert result.loop.unanswered <= 0.02 * len(cycles)
    assert cycles[-1].t >= result.planned.plan.trajectory.duration
    assert any(line.startswith("motion of") for line in said)


@pytest.mark.sim
@pytest.mark.parametrize("file", SEQUENCES, ids=lambda file: file.stem)
def test_an_example_of_more_than_one_motion_runs_on_mujoco(file):
    job = load_job(file)
    planned = plan_sequence(job, load_cell(job.arm))
    said: list[str] = []
    with open_arm(planned.cell, "mujoco") as station:
        result = carry_out_sequence(planned, station, announce=said.append)
    assert result.outcome is Outcome.FINISHED
    assert "MuJoCo: no gripper moves here; its waits are kept" in said
    for run in result.runs:
        if run.motion is not None:
            assert run.motion.tracking.path_commanded.worst <= 5e-5
            assert run.motion.tracking.path_measured.worst <= 2e-3
    assert result.totals.missed == 0


@pytest.mark.bus
@pytest.mark.slow
def test_the_gripper_of_an_example_moves_on_virtual_servos():
    job = load_job(EXAMPLES[0].parent / "pick.toml")
    planned = plan_sequence(job, load_cell(job.arm))
    with open_arm(planned.cell, "virtual", rate=job.rate) as station:
        result = carry_out_sequence(planned, station)
    assert result.outcome is Outcome.FINISHED
    openings = [run.grip.percent for run in result.runs if run.grip is not None]
    np.testing.assert_allclose(openings, [100.0, 0.0, 60.0], atol=2.0)
    assert result.totals.missed <= 0.02 * result.totals.cycles
    assert result.totals.unanswered <= 0.02 * result.totals.cycles
