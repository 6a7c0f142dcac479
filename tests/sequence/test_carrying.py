"""Sequences carried out: on MuJoCo, where no gripper moves, and on servos, where one does."""

import csv
import os
import signal
from dataclasses import replace
from math import inf

import numpy as np
import pytest

from splinearm.backends import Station, centred, open_arm
from splinearm.config import load_cell, load_job
from splinearm.control.clock import WallClock
from splinearm.control.ending import Outcome
from splinearm.drivers.chain import ServoRole
from splinearm.drivers.dynamixel import DynamixelBus
from splinearm.drivers.gripper import gripper_on
from splinearm.drivers.servo_arm import ServoArm
from splinearm.errors import ConfigError, LimitError, ServoError
from splinearm.sequence import (
    StepKind,
    carry_out_sequence,
    plan_sequence,
    resume_sequence,
)
from splinearm.sim.virtual_bus import VirtualBus

HOLD = [0.0, -30.0, 30.0, 0.0, 60.0, 0.0]
ASIDE = [3.0, -30.0, 30.0, 0.0, 60.0, 0.0]


class Interrupted:
    """An arm that lets Ctrl-C be pressed at a setpoint."""

    def __init__(self, driver, at):
        self.driver, self.at = driver, at

    def __getattr__(self, name):
        return getattr(self.driver, name)

    def write(self, setpoint):
        self.driver.write(setpoint)
        self.at -= 1
        if self.at == 0:
            os.kill(os.getpid(), signal.SIGINT)


@pytest.fixture(scope="module")
def planar():
    return load_cell("planar_2r")


@pytest.mark.sim
def test_pieces_run_one_after_the_other_and_everything_is_written(load, pieces, planar, tmp_path):
    grip = pieces["close"] + "wait_s = 0.3\n"
    job = load("[motion]\ntimes = 2\n" + pieces["wave"] + grip + pieces["saved"] + pieces["job"])
    planned = plan_sequence(job, planar)
    said, seen = [], []
    rows = tmp_path / "rows.csv"
    with open_arm(planar, "mujoco") as station:
        result = carry_out_sequence(
            planned,
            station,
            csv=rows,
            announce=said.append,
            observe=lambda step, cycle: seen.append((step.name, cycle.index)),
        )
        np.testing.assert_allclose(station.driver.goal, np.radians([10.0, 40.0]), atol=1e-6)
    assert result.outcome is Outcome.FINISHED
    assert (result.rounds, result.totals.motions) == (2, 2 * 5 + 1)
    assert said.count("MuJoCo: no gripper moves here; its waits are kept") == 1
    assert any(line.startswith("slowly to saved: ") for line in said)
    assert len(seen) == result.totals.cycles
    document = result.document()
    kinds = [piece["kind"] for piece in document["pieces"]]
    assert kinds == ["motion", "gripper", "transition", "motion", "transition", "motion"]
    assert {piece["round"] for piece in document["pieces"]} == {2}
    assert document["pieces"][1]["seconds"] == pytest.approx(0.3, abs=0.03)
    assert all(
        piece["tracking"]["path_measured_mm"]["worst"] < 2.0
        for piece in document["pieces"]
        if piece["kind"] == "motion"
    )
    with rows.open() as file:
        table = list(csv.DictReader(file))
    assert len(table) == result.totals.cycles
    t = np.array([float(row["t_s"]) for row in table])
    assert (np.diff(t) > 0.0).all()
    assert (np.diff([int(row["cycle"]) for row in table]) > 0).all()
    assert t[-1] == pytest.approx(result.seconds, abs=0.1)


@pytest.mark.sim
@pytest.mark.parametrize("at", [pytest.param(15, marks=pytest.mark.slow), 140])
def test_what_was_stopped_goes_on_with_the_rest_of_its_step_and_the_others(
    load, pieces, planar, at
):
    planned = plan_sequence(load(pieces["wave"] + pieces["saved"] + pieces["job"]), planar)
    with open_arm(planar, "mujoco", q_start=planned.job.q_start) as station:
        first = carry_out_sequence(
            planned, replace(station, driver=Interrupted(station.driver, at))
        )
        assert first.outcome is Outcome.STOPPED
        document = first.document()
        assert document["stopped_in"] == first.step.name
        assert document["outcome"] == "stopped"
        np.testing.assert_allclose(station.driver.goal, first.ending.stopped.q, atol=1e-5)
        second = resume_sequence(first, station)
        assert second.outcome is Outcome.FINISHED
        assert second.runs[0].place == first.place
        names = [run.step.name for run in first.runs[:-1]] + [r.step.name for r in second.runs]
        assert names == [step.name for step in planned.steps]
        np.testing.assert_allclose(station.driver.goal, np.radians([10.0, 40.0]), atol=1e-6)
        with pytest.raises(ValueError, match="finished"):
            resume_sequence(second, station)


@pytest.mark.sim
def test_one_that_was_stopped_on_the_way_to_its_begin_begins_when_it_goes_on(load, pieces, planar):
    planned = plan_sequence(load(pieces["close"] + pieces["wave"]), planar)
    with open_arm(planar, "mujoco") as station:
        arm = Interrupted(station.driver, 10)
        first = carry_out_sequence(planned, replace(station, driver=arm))
        assert first.outcome is Outcome.STOPPED
        assert first.runs == ()
        second = resume_sequence(first, station)
        assert second.outcome is Outcome.FINISHED
        goal = planned.steps[-1].planned.plan.trajectory.q_goal
        np.testing.assert_allclose(station.driver.goal, goal, atol=1e-6)
        whole = second.runs[-1].motion.recorder.cycles[-1].setpoint.t
        assert whole == pytest.approx(planned.duration, abs=0.02)


@pytest.mark.sim
def test_an_endless_loop_ends_by_a_stop_and_keeps_its_last_round_only(load, pieces, planar):
    planned = plan_sequence(replace(load(pieces["wave"]), times=None), planar)
    with open_arm(planar, "mujoco", q_start=planned.job.q_start) as station:
        arm = Interrupted(station.driver, 500)
        result = carry_out_sequence(planned, replace(station, driver=arm))
    assert result.outcome is Outcome.STOPPED
    assert result.rounds >= 3
    assert result.totals.motions > len(result.runs)
    assert {run.place.round for run in result.runs} == {result.place.round}


@pytest.mark.sim
def test_a_step_that_breaks_a_limit_is_refused_before_anything_moves(load, pieces, planar):
    planned = plan_sequence(load(pieces["wave"] + pieces["saved"]), planar)
    tight = replace(planar, arm=replace(planar.arm, limits=planar.arm.limits.scaled(0.25)))
    narrow = replace(planned, cell=tight)
    with open_arm(planar, "mujoco") as station:
        before = station.driver.goal
        with pytest.raises(LimitError):
            carry_out_sequence(narrow, station)
        np.testing.assert_array_equal(station.driver.goal, before)


@pytest.fixture(scope="module")
def hall():
    """A WidowX with its gripper on a virtual bus."""
    cell = load_cell("wx250s")
    quick = [
        replace(servo, settings={**servo.settings, "Profile Velocity": 250})
        if servo.role is ServoRole.GRIPPER
        else servo
        for servo in centred(cell.chain).servos
    ]
    cell = replace(cell, chain=replace(cell.chain, servos=tuple(quick)))
    names = cell.arm.joint_names
    with VirtualBus(cell.arm, cell.chain, np.radians(HOLD), transport="socket") as virtual:
        bus = DynamixelBus(virtual.port, cell.chain.baud, margin=0.1)
        with ServoArm(cell.chain, names, cell.arm.limits, bus, watchdog=0.5) as arm:
            gripper = gripper_on(cell.chain, bus)
            yield (
                cell,
                virtual,
                Station(driver=arm, clock=WallClock(), where="here", gripper=gripper),
            )


@pytest.fixture
def gripping(hall, tmp_path):
    """Plan a job of the WidowX that goes aside between what its gripper does; nothing is held."""
    cell, virtual, station = hall

    def planned(first, last=""):
        move = "[[waypoint]]\nthrough = 'joint'\njoints_deg = {}\n"
        text = (
            'schema = "splinearm-job/1"\nname = "g"\ntitle = "Grip"\narm = "wx250s"\n'
            f"start_deg = {HOLD}\n[motion]\nlimits_percent = 60\n"
            f"{move.format(HOLD)}{first}{move.format(ASIDE)}{move.format(HOLD)}{last}"
        )
        file = tmp_path / "grip.toml"
        file.write_text(text)
        return plan_sequence(load_job(file), cell)

    virtual.grip("gripper", None)
    if station.gripper.ready:
        station.gripper.recover()
    return planned


def grasp(virtual, something: bool) -> None:
    """Put something between the fingers at 30 %."""
    low = (1802 + 0.3 * (2875 - 1802) - 2048) / 4096 * 2.0 * np.pi
    virtual.grip("gripper", (low, inf) if something else None)


@pytest.mark.bus
@pytest.mark.slow
def test_the_arm_goes_on_while_its_gripper_holds_and_is_looked_after(hall, gripping):
    _, virtual, station = hall
    grasp(virtual, True)
    said = []
    result = carry_out_sequence(
        gripping("gripper = 'close'\nmust_hold = true\n", "gripper = 'open'\n"),
        station,
        announce=said.append,
    )
    assert result.outcome is Outcome.FINISHED
    closed, motion, opened = result.runs
    assert closed.grip.holding
    assert closed.grip.percent == pytest.approx(30.0, abs=2.0)
    assert (motion.step.kind, opened.grip.arrived) == (StepKind.MOTION, True)
    assert "gripper: holds something at 30 %, with 25% of its torque" in said
    assert result.document()["pieces"][0]["gripper"]["holding"] is True
    assert result.totals.unanswered <= 0.02 * result.totals.cycles


@pytest.mark.bus
@pytest.mark.parametrize(
    ("must", "outcome"),
    [pytest.param("false", "finished", marks=pytest.mark.slow), ("true", "failed")],
)
def test_what_is_lost_on_the_way_is_said_and_stops_the_arm_if_it_must_be_held(
    hall, gripping, must, outcome
):
    _, virtual, station = hall
    grasp(virtual, True)
    said = []
    planned = gripping(f"gripper = 'close'\nmust_hold = {must}\n")

    def lose(step, cycle):
        if 0.01 < cycle.setpoint.t < 0.06:
            grasp(virtual, False)

    result = carry_out_sequence(planned, station, announce=said.append, observe=lose)
    assert result.outcome.value == outcome
    assert result.runs[0].grip.holding
    lost = "gripper has lost what it held: it stands at 0 %, holds nothing"
    assert lost in said
    if must == "true":
        assert str(result.ending.fault) == lost
        assert result.ending.stopped.t <= planned.duration
        assert resume_sequence(result, station).outcome is Outcome.FINISHED


@pytest.mark.bus
def test_a_gripper_that_must_hold_and_holds_nothing_ends_the_job_before_the_arm_goes_on(
    hall, gripping
):
    _, _, station = hall
    result = carry_out_sequence(gripping("gripper = 'close'\nmust_hold = true\n"), station)
    assert "gripper holds nothing: it stands at 0 %" in str(result.ending.fault)
    assert [run.step.kind for run in result.runs] == [StepKind.GRIPPER]


@pytest.mark.bus
def test_a_gripper_that_stops_itself_stops_the_arm_along_its_path_and_both_go_on(hall, gripping):
    _, virtual, station = hall
    planned = gripping("gripper = 'close'\n")

    def fail(step, cycle):
        if 0.01 < cycle.setpoint.t < 0.06:
            with virtual.lock:
                virtual.servos[9].fail("overload")

    result = carry_out_sequence(planned, station, observe=fail)
    assert result.outcome is Outcome.FAILED
    assert isinstance(result.ending.fault.__cause__, ServoError)
    assert "overload" in str(result.ending.fault)
    assert result.ending.stopped.t < planned.duration
    station.driver.read()  # the arm holds, with all of its torque
    [fault] = station.gripper.recover()
    assert fault.causes == ("overload",)
    assert resume_sequence(result, station).outcome is Outcome.FINISHED


@pytest.mark.bus
def test_ctrl_c_while_the_gripper_moves_stops_it_and_it_is_done_again(hall, gripping):
    _, _, station = hall
    planned = gripping("gripper = 100\nwait_s = 5\n")

    def press(line):
        if line.startswith("gripper: open"):
            os.kill(os.getpid(), signal.SIGINT)

    result = carry_out_sequence(planned, station, announce=press)
    assert result.outcome is Outcome.STOPPED
    assert result.ending.stopped is None
    assert result.place == (0, 0)
    assert result.seconds < 2.0
    assert station.gripper.look().percent < 98.0 or station.gripper.settled


@pytest.mark.bus
def test_a_force_that_is_too_much_is_refused_before_anything_moves(hall, gripping, tmp_path):
    _, virtual, station = hall
    with virtual.lock:
        virtual.servos[9].memory["PWM Limit"] = 400
    station.gripper.take()
    try:
        with pytest.raises(ConfigError, match=r"gripper: force: want at most 0\.45"):
            carry_out_sequence(gripping("gripper = 50\nforce_percent = 60\n"), station)
    finally:
        with virtual.lock:
            virtual.servos[9].memory["PWM Limit"] = 885
        station.gripper.take()
