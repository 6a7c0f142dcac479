"""``splinearm run PROGRAM.ngc``."""

import json
from pathlib import Path

import pytest

from splinearm.cli.main import DONE, REFUSED

ENGRAVE = Path(__file__).parents[2] / "examples" / "engrave.ngc"
DRAWING = "G21 G90 G64 P0.1\nG0 X0 Y0\nM3 S100\nG1 X30 F3000\nG3 X30 Y30 J15\nG1 X0\nM2\n"


@pytest.fixture
def program(tmp_path):
    """Writes a program and gives its file."""

    def write(text):
        file = tmp_path / "part.ngc"
        file.write_text(text, encoding="utf-8")
        return file

    return write


@pytest.mark.sim
def test_the_engraving_is_carried_out_on_the_simulated_arm(cli, tmp_path):
    report = tmp_path / "report.json"
    code = cli("run", ENGRAVE, "--arm", "wx250s", "--place", "220,-20,60", "--json", report)
    assert code == DONE
    assert "spindle clockwise at 7639 rpm" in cli.out
    assert "spindle off" in cli.out
    tracking = json.loads(report.read_text())["tracking"]
    assert tracking["path_commanded_mm"]["worst"] < 0.02
    assert tracking["path_measured_mm"]["worst"] < 0.5


@pytest.mark.slow
@pytest.mark.sim
def test_a_planar_arm_draws_on_the_virtual_bus(cli, program, tmp_path):
    rows = tmp_path / "rows.csv"
    file = program(DRAWING.replace("G0 X0 Y0", "G0 X0 Y0 Z5\nG1 Z0 F600"))
    words = ("--arm", "planar_2r", "--place", "200,60,0", "--on", "virtual", "--csv", rows)
    code = cli("run", file, *words)
    assert code == DONE, cli.err
    assert "this arm has no height" in cli.out
    assert rows.read_text().count("\n") > 50


def test_a_pause_is_refused_where_nobody_is_there(cli, program):
    file = program(DRAWING.replace("G3", "M0\nG3"))
    code = cli("run", file, "--arm", "planar_2r", "--place", "200,60,0")
    assert code == REFUSED
    assert "line 5: M0 waits for a person" in cli.err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), "--arm: an NC program says no arm"),
        (("--arm", "planar_2r"), "--place: an NC program says not where it lies"),
        (("--arm", "planar_2r", "--place", "1,2"), "want x,y,z or x,y,z,rx,ry,rz"),
        (("--arm", "planar_2r", "--place", "a,b,c"), "want x,y,z or x,y,z,rx,ry,rz"),
        (("--arm", "planar_2r", "--place", "200,60,0", "--limits-percent", "0"), "0 to 100"),
        (("--arm", "planar_2r", "--place", "200,60,0", "--tool-length-mm", "-3"), "at least 0"),
        (("--arm", "planar_2r", "--place", "900,60,0"), "part.ngc: line 4"),
    ],
)
def test_wrong_words_end_in_one_line(cli, program, words, message):
    code = cli("run", program(DRAWING), *words)
    assert code == REFUSED
    assert message in cli.err
    assert cli.err.count("\n") == 1


def test_a_wrong_program_names_its_line(cli, program):
    words = ("--arm", "planar_2r", "--place", "200,60,0")
    code = cli("run", program("G1 X10\nG1 Y\n"), *words)
    assert code == REFUSED
    assert "part.ngc:" in cli.err
