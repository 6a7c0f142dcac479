from functools import cache
from pathlib import Path

import numpy as np
import pytest

from splinearm.config import Cell, Job, demo_job, load_cell, load_job
from splinearm.kinematics import ik
from splinearm.trajectories.plan import Plan, plan
from splinearm.trajectories.waypoint import Move

EXAMPLES = Path(__file__).parent.parent.parent / "examples"
NAMES = sorted(path.stem for path in EXAMPLES.glob("*.toml"))


@cache
def example(name: str) -> tuple[Job, Cell]:
    job = load_job(EXAMPLES / f"{name}.toml")
    return job, load_cell(job.arm)


@cache
def planned(name: str) -> Plan:
    job, cell = example(name)
    return plan(
        cell.arm,
        job.waypoints,
        job.q_start,
        limits=cell.arm.limits.scaled(job.limits_share),
        position_tolerance=job.position_tolerance,
        closed=job.closed,
    )


def test_there_are_examples_of_every_move():
    assert NAMES == ["heart", "inspect", "pick", "reach", "slot", "square"]
    assert {point.move for name in NAMES for point in example(name)[0].waypoints} == set(Move)


@pytest.mark.parametrize("name", NAMES)
def test_an_example_is_called_as_its_file(name):
    assert example(name)[0].name == name


@pytest.mark.parametrize("name", NAMES)
def test_every_waypoint_of_an_example_is_reached_from_the_one_before(name):
    job, cell = example(name)
    q = job.q_start
    for point in job.waypoints:
        if point.q is not None:
            q = point.q
            continue
        target = point.position if point.pose is None else point.pose
        found = ik.search(cell.arm, target, q, restarts=0)
        assert found.status is ik.IKStatus.REACHED, found.reason
        assert np.abs(found.q - q).max() < 2.0, "no jump to another branch"
        q = found.q


@pytest.mark.parametrize("name", NAMES)
def test_an_example_s_tool_stays_on_its_path_and_within_its_speed(name):
    job, cell = example(name)
    motion = planned(name)
    ts = np.linspace(0.0, motion.trajectory.duration, 600)
    q, qd, qdd = motion.trajectory.sample(ts)
    limits = cell.arm.limits.scaled(job.limits_share)
    for row in zip(q, qd, qdd, strict=True):
        limits.check(*row)
    assert motion.tool_path.distance(cell.arm.fk(q)[:, :3, 3]).max() <= job.position_tolerance
    speeds = [point.speed for point in job.waypoints if point.speed is not None]
    if speeds:
        J = cell.arm.jacobian(q)[:, :3]
        assert np.linalg.norm(np.einsum("mij,mj->mi", J, qd), axis=1).max() <= max(speeds) + 1e-6


@pytest.mark.parametrize("name", NAMES)
def test_an_example_keeps_away_from_the_ends_of_the_joints(name):
    limits = example(name)[1].arm.limits
    q, _, _ = planned(name).trajectory.sample(
        np.linspace(0, planned(name).trajectory.duration, 400)
    )
    room = np.minimum(q.min(axis=0) - limits.q_min, limits.q_max - q.max(axis=0))
    assert np.rad2deg(room).min() > 15.0


def test_the_heart_is_one_closed_figure_of_its_shape():
    job, cell = example("heart")
    assert job.closed
    assert {point.move for point in job.waypoints} == {Move.BSPLINE}
    path = planned("heart").tool_path.sample(2000)
    np.testing.assert_allclose(path[0], path[-1], atol=1e-9)
    middle = 0.33
    sides = path[path[:, 0] > middle], path[path[:, 0] < middle]
    assert abs(sides[0][:, 0].max() - middle - (middle - sides[1][:, 0].min())) < 1e-3
    assert abs(path[:, 1].argmin() - 0) < 20 or abs(path[:, 1].argmin() - 2000) < 20
    notch = path[np.abs(path[:, 0] - middle) < 5e-4]
    upper = notch[notch[:, 1] > 0.0, 1]
    assert upper.max() < path[:, 1].max() - 0.025, "two lobes with a notch between them"
    assert cell.name == "planar_2r"
    speeds = {point.speed for point in job.waypoints}
    assert speeds == {0.2}


def test_the_demo_is_the_heart_of_the_examples():
    assert demo_job().file.read_bytes() == (EXAMPLES / "heart.toml").read_bytes()
    assert demo_job().arm == example("heart")[0].arm
