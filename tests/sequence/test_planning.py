"""Jobs of pieces planned as a whole, before anything moves."""

from dataclasses import replace
from itertools import islice, pairwise

import numpy as np
import pytest

from splinearm.config import load_cell
from splinearm.errors import ConfigError
from splinearm.runner import carry_out_job, plan_job
from splinearm.sequence import StepKind, is_sequence, plan_sequence
from splinearm.sequence.step import Place


@pytest.fixture(scope="module")
def cell():
    return load_cell("planar_2r")


def motions(planned):
    return [step.planned.plan.trajectory for step in planned.steps if step.planned]


def test_pieces_whose_ends_differ_are_joined_by_slow_ways(load, pieces, cell):
    job = load(pieces["wave"] + pieces["saved"] + "times = 2\n" + pieces["job"])
    planned = plan_sequence(job, cell)
    assert [step.name for step in planned.steps] == [
        "wave",
        "to saved (1 of 2)",
        "saved (1 of 2)",
        "to saved (2 of 2)",
        "saved (2 of 2)",
        "to there",
        "there",
    ]
    for before, after in pairwise(motions(planned)):
        np.testing.assert_allclose(before.q_goal, after.q_start, atol=1e-9)
    np.testing.assert_allclose(motions(planned)[0].q_start, job.q_start)
    qd_max = cell.arm.limits.qd_max
    for step in planned.steps:
        if step.kind is StepKind.TRANSITION:
            trajectory = step.planned.plan.trajectory
            _, qd, _ = trajectory.sample(np.linspace(0.0, trajectory.duration, 200))
            assert (np.abs(qd) <= 0.3 * qd_max * (1.0 + 1e-9)).all()
    assert planned.back is None


def test_a_loop_goes_back_to_its_begin_between_rounds_only(load, pieces, cell):
    planned = plan_sequence(replace(load(pieces["wave"]), times=3), cell)
    assert planned.back.kind is StepKind.TRANSITION
    walk = list(planned.walk(Place()))
    assert [place for place, _ in walk] == [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0)]
    assert walk[1][1] is planned.back
    assert [place for place, _ in planned.walk(Place(1, 1))] == [(1, 1), (2, 0)]
    endless = plan_sequence(replace(load(pieces["wave"]), times=None), cell)
    assert [place.round for place, _ in islice(endless.walk(Place()), 1000)][-1] == 499


def test_the_share_of_the_limits_holds_for_every_piece(load, pieces, cell):
    job = load(pieces["wave"] + pieces["saved"] + pieces["job"])
    slow = plan_sequence(replace(job, limits_share=0.2, timing="fastest"), cell)
    limits = cell.arm.limits.scaled(0.2)
    for step in slow.steps:
        if step.kind is StepKind.MOTION:
            trajectory = step.planned.plan.trajectory
            _, qd, qdd = trajectory.sample(np.linspace(0.0, trajectory.duration, 500))
            assert (np.abs(qd) <= limits.qd_max * (1.0 + 1e-6)).all()
            assert (np.abs(qdd) <= limits.qdd_max * (1.0 + 1e-6)).all()


def test_a_taught_piece_is_as_quick_as_it_was_led_or_as_limits_allow(load, pieces, cell):
    job = load(pieces["wave"].replace("0.4", "4.0"))
    recorded, fastest = (
        plan_sequence(replace(job, timing=timing), cell).duration for timing in (None, "fastest")
    )
    assert recorded == pytest.approx(4.0, rel=1e-3)
    assert fastest < 1.0


def test_a_motion_is_cut_where_the_gripper_does_something(load, pieces, cell):
    place = '[[waypoint]]\nname = "{}"\nposition_mm = [{}, {}, 60.0]\n'
    text = (
        '[motion]\nthrough = "line"\n'
        + place.format("a", 380, 0)
        + 'gripper = "open"\ndwell_s = 0.5\n'
        + place.format("b", 380, 60)
        + place.format("c", 380, 0)
        + 'gripper = "close"\nwait_s = 1\n'
    )
    job = load(text)
    planned = plan_sequence(job, cell)
    whole = plan_job(job, cell).plan.trajectory
    assert [step.name for step in planned.steps] == [
        "to a",
        "gripper: open at a",
        "to c",
        "gripper: close at c",
    ]
    assert planned.duration == pytest.approx(whole.duration + 1.0)
    first, second = motions(planned)
    np.testing.assert_array_equal(first.q_goal, second.q_start)
    for t in np.linspace(0.0, second.duration, 20):
        np.testing.assert_allclose(second.at(t).q, whole.at(first.duration + t).q, atol=1e-12)


def test_a_gripper_may_act_at_the_begin_and_twice_in_one_place(load, cell):
    here = "[[waypoint]]\nthrough = 'joint'\njoints_deg = [10.0, 40.0]\n"
    text = "start_deg = [10.0, 40.0]\n" + here + "gripper = 'open'\n" + here + "gripper = 50\n"
    kinds = [step.kind for step in plan_sequence(load(text), cell).steps]
    assert kinds == [StepKind.GRIPPER, StepKind.GRIPPER]


def test_the_arm_rests_for_its_gripper_on_a_closed_curve_too(load, cell):
    place = "[[waypoint]]\nposition_mm = [{}, {}, 60.0]\n"
    text = "[motion]\nclosed = true\n" + place.format(380, 0) + "gripper = 'open'\n"
    text += place.format(380, 60) + place.format(330, 60)
    first, second = motions(plan_sequence(load(text), cell))
    assert first.ends_at_rest
    assert second.starts_at_rest
    np.testing.assert_allclose(second.q_goal, first.q_start, atol=1e-9)


def test_a_piece_that_cannot_be_is_named_before_anything_moves(load, pieces, cell):
    far = pieces["wave"].replace("[26.0, 55.0], [26.0, 55.0]", "[26.0, 55.0], [26.0, 999.0]")
    with pytest.raises(ConfigError, match=r"piece\[1\].*'wave'") as caught:
        plan_sequence(load(pieces["saved"] + far), cell)
    assert "\n" not in str(caught.value)


def test_more_than_one_motion_is_no_job_for_one_plan_or_one_run(load, pieces, cell):
    assert is_sequence(load(pieces["wave"]))
    with pytest.raises(ConfigError, match="is a job of pieces"):
        plan_job(load(pieces["wave"]), cell)
    job = load(pieces["reach"])
    assert not is_sequence(job)
    often = replace(job, times=2)
    assert is_sequence(often)
    with pytest.raises(ConfigError, match="is more than one motion"):
        carry_out_job(plan_job(often, cell), None)
