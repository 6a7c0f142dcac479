"""NC programs from their file to the end of their motion."""

import runpy
from pathlib import Path

import numpy as np
import pytest

from splinearm.backends import open_arm
from splinearm.config import load_cell, load_job
from splinearm.config.nc_program import NcProgram
from splinearm.control.ending import Outcome
from splinearm.errors import ConfigError, GcodeError, ToolpathError, UnreachableError
from splinearm.machining import (
    carry_out_program,
    nc_job,
    parse_place,
    plan_nc_job,
    require_nobody,
    with_tool,
)
from splinearm.toolpaths.setting import Setting

EXAMPLES = Path(__file__).parents[1] / "examples"
CELL = load_cell("planar_2r")
TWO_PARTS = "G21 G90 G64 P0.1\nG0 X0 Y0\nM3 S100\nG1 X20 F6000\nM0\nM8\nG1 Y20\nM5\nM2\n"


def program(tmp_path, text, **words):
    file = tmp_path / "part.ngc"
    file.write_text(text, encoding="utf-8")
    given = {
        "T_base_work": parse_place("200,60,0"),
        "direction": np.array([0.0, 0.0, -1.0]),
        "turn": None,
        "clearance": 0.02,
        "tool_length": 0.0,
        "tools": {},
        "inches": False,
    }
    return NcProgram(file=file, **{**given, **words})


class Willing:
    """A person who gives always the same answer."""

    def __init__(self, *, answer=True):
        self.answer, self.asked, self.stopped = answer, [], []

    def ask(self, words):
        self.asked.append(words)
        return self.answer

    def go_on(self, result):
        self.stopped.append(result.ending.stopped.t)
        return self.answer


@pytest.fixture
def planned(tmp_path):
    """Two parts with a pause between, on the planar arm."""
    return plan_nc_job(nc_job(program(tmp_path, TWO_PARTS), CELL), CELL)


@pytest.mark.sim
def test_parts_run_one_after_the_other_and_what_is_switched_is_said(planned):
    said, person = [], Willing()
    with open_arm(CELL, "mujoco") as station:
        results = carry_out_program(planned, station, person, announce=said.append)
    assert [result.outcome for result in results] == [Outcome.FINISHED] * 2
    assert person.asked == ["line 5: M0"]
    switched = [words for words in said if words.startswith("line")]
    assert switched == [
        "line 3: spindle clockwise at 100 rpm",
        "line 5: M0",
        "line 6: M8",
        "line 8: spindle off",
        "line 9: M2",
    ]
    end = CELL.arm.fk(planned.jobs[-1].plan.trajectory.q_goal)[:2, 3]
    assert np.allclose(end, [0.22, 0.08], atol=2e-5)
    assert max(result.tracking.path_measured.worst for result in results) < 1e-3


@pytest.mark.sim
def test_a_program_that_was_stopped_goes_on_and_says_all_once(planned, interrupted):
    said, person = [], Willing()
    with open_arm(CELL, "mujoco", q_start=planned.jobs[0].plan.trajectory.q_start) as station:
        one = interrupted(station, 20)
        results = carry_out_program(planned, one, person, announce=said.append)
    (stopped,) = person.stopped
    assert stopped > 0.1
    assert [result.outcome for result in results] == [Outcome.FINISHED] * 2
    assert sum(words.startswith("line") for words in said) == 5


@pytest.mark.sim
def test_a_person_who_says_no_ends_it_there(planned):
    with open_arm(CELL, "mujoco") as station:
        results = carry_out_program(planned, station, Willing(answer=False), announce=str)
    assert len(results) == 1


def test_without_a_person_a_pause_is_refused_before_anything_moves(planned):
    with pytest.raises(ConfigError, match="line 5: M0 waits for a person"):
        require_nobody(planned)


def test_the_tool_is_longer_along_where_it_points():
    cell = load_cell("wx250s")
    longer = with_tool(cell, Setting(T_base_work=np.eye(4)), 0.03)
    q = cell.poses["home"]
    gap = longer.arm.fk(q)[:3, 3] - cell.arm.fk(q)[:3, 3]
    assert np.allclose(gap, 0.03 * cell.arm.fk(q)[:3, 0])
    with pytest.raises(ValueError, match="at least 0"):
        with_tool(cell, Setting(T_base_work=np.eye(4)), -0.01)


@pytest.mark.parametrize("text", ["1,2", "a,b,c", "1,2,3,4", "", "1,2,nan"])
def test_a_place_that_is_none_is_refused(text):
    with pytest.raises(ValueError, match="want x,y,z"):
        parse_place(text)


def test_a_place_turns_about_fixed_axes():
    T = parse_place("100,-20,30,0,0,90")
    assert np.allclose(T[:3, 3], [0.1, -0.02, 0.03])
    assert np.allclose(T[:3, 0], [0.0, 1.0, 0.0])
    both = parse_place("0,0,0,90,0,90")
    assert np.allclose(both[:3, 1], [0.0, 0.0, 1.0])  # about x first


def test_what_cannot_be_reached_names_the_program_and_its_line(tmp_path):
    far = program(tmp_path, TWO_PARTS, T_base_work=parse_place("900,0,0"))
    with pytest.raises(UnreachableError, match=r"part.ngc: line 4.* out of reach by .* mm"):
        plan_nc_job(nc_job(far, CELL), CELL)


def test_a_place_is_found_where_all_can_be_reached(tmp_path):
    far = program(tmp_path, TWO_PARTS, T_base_work=parse_place("900,0,0"))
    found = plan_nc_job(nc_job(far, CELL), CELL, find=True)
    assert len(found.parts) == 2
    huge = program(tmp_path, "G1 F600 X0 Y0\nX5000\nM2")
    with pytest.raises(ToolpathError, match="no place ahead of arm"):
        plan_nc_job(nc_job(huge, CELL), CELL, find=True)


def test_a_program_that_does_not_move_the_tool_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="move the tool"):
        plan_nc_job(nc_job(program(tmp_path, "M3 S100\nM2\n"), CELL), CELL)
    with pytest.raises(GcodeError, match=r"part\.ngc:1"):
        plan_nc_job(nc_job(program(tmp_path, "G1 X Y\n"), CELL), CELL)


JOB = """\
schema = "splinearm-job/1"
name = "letters"
title = "Letters"
arm = "planar_2r"
toolpath = "part.ngc"

[motion]
limits_percent = 50
jerk_time_s = 0.1
rate_hz = 50

[place]
xyz_mm = [200, 60, 0]
tool_length_mm = 0
"""


def job_file(tmp_path, *changes):
    text = JOB
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "part.ngc").write_text(TWO_PARTS.replace("M0\n", ""), encoding="utf-8")
    file = tmp_path / "job.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_a_job_file_names_a_program_and_its_place(tmp_path):
    job = load_job(job_file(tmp_path))
    assert job.program is not None
    planned = plan_nc_job(job, CELL)
    (one,) = planned.jobs
    limits = one.plan.limits.joints
    assert np.allclose(limits.qd_max, 0.5 * CELL.arm.limits.qd_max)
    assert np.allclose(limits.qddd_max, limits.qdd_max / 0.1)
    assert one.job.rate == 50.0
    assert np.allclose(planned.placed.setting.T_base_work[:2, 3], [0.2, 0.06])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('"part.ngc"', '"other.ngc"'), "is no file"),
        (("tool_length_mm = 0", "tool_length_mm = -1"), "tool_length_mm"),
        (("tool_length_mm = 0", "tool_width_mm = 1"), "tool_width_mm"),
        (("[place]", "[[waypoint]]\nposition_mm = [1, 2, 3]\n\n[place]"), "contradicts toolpath"),
    ],
)
def test_a_wrong_job_file_names_its_key(tmp_path, change, message):
    with pytest.raises(ConfigError, match=message):
        load_job(job_file(tmp_path, change))


def test_the_example_is_what_its_script_writes(tmp_path):
    made = runpy.run_path(str(EXAMPLES / "engrave.py"))
    from splinearm.toolpaths.gcode_check import write_checked
    from splinearm.toolpaths.gcode_dialect import dialect_of

    text = write_checked(made["actions"](), dialect_of("linuxcnc"), "letters: arcs, lines, splines")
    assert text == (EXAMPLES / "engrave.ngc").read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.sim
@pytest.mark.parametrize(
    "arm", ["wx250s", "wx200", "rx150", "koch_v1_1", "omx_f", "open_manipulator_x", "planar_2r"]
)
@pytest.mark.parametrize("where", ["mujoco", "virtual"])
def test_every_shipped_arm_engraves_the_example(arm, where):
    cell = load_cell(arm)
    example = NcProgram(
        file=EXAMPLES / "engrave.ngc", T_base_work=np.eye(4),
        direction=np.array([0.0, 0.0, -1.0]), turn=None, clearance=0.02, tool_length=0.01,
        tools={}, inches=False,
    )  # fmt: skip
    planned = plan_nc_job(nc_job(example, cell), cell, find=True)
    with open_arm(planned.jobs[0].cell, where) as station:
        (result,) = carry_out_program(planned, station, announce=str)
    assert result.outcome is Outcome.FINISHED
    assert result.tracking.path_commanded.worst < 2e-5
    if where == "mujoco":
        assert result.tracking.path_measured.worst < 1e-3
