"""``splinearm gcode``: what a program means, and what a controller does not take of it."""

import json

import pytest

PART = "G21 G90\nT1 M6\nS10000 M3\nG0 X0 Y0 Z5\nG1 Z-1 F120\nG3 X10 Y0 I5 F600\nG4 P2\nM2\n"


@pytest.fixture
def part(cli):
    return cli.write("part.ngc", PART)


def test_a_program_is_summed_up(cli, part):
    assert cli("gcode", "check", part) == 0
    assert "1 lines, 1 arcs, 0 splines, 1 rapid" in cli.out
    assert "0 to 10 x -5 to 0 x -1 to 5 mm" in cli.out
    assert "120 to 600 mm/min" in cli.out


def test_a_program_is_summed_up_for_other_programs(cli, part):
    assert cli("gcode", "check", part, "--json") == 0
    facts = json.loads(cli.out)
    assert facts["ways"] == {"lines": 1, "arcs": 1, "splines": 0, "rapids": 1}
    assert facts["cutting_length"] == pytest.approx(6e-3 + 5e-3 * 3.141592653589793)
    assert facts["cutting_time"] == pytest.approx(3.0 + 5e-3 * 3.141592653589793 / 0.01)
    assert facts["dwell_time"] == 2
    assert facts["tools"] == [1]
    assert facts["findings"] == []


def test_what_a_controller_does_not_take_is_told_by_line(cli, part):
    assert cli("gcode", "check", part, "--dialect", "linuxcnc") == 0
    part.write_text("#1=5\nG0 X[#1+1]\no1 if [#1]\nG64\no1 endif\n(" + "x" * 90 + ")\n" + PART)
    assert cli("gcode", "check", part, "--dialect", "grbl") == 1
    for words in (
        "line 1: #1=5",
        "line 2: x[#1+1]",
        "line 3: O1 if",
        "line 4: G64",
        "line 6: is 92",
    ):
        assert words in cli.out
    assert "line 8: M6: grbl does not know it" in cli.out


@pytest.mark.parametrize(
    ("text", "words"),
    [("G0 X1\nG1 Y2\n", ("part.ngc:2", "F: is missing")), ("G2 X&\n", ("part.ngc:1",))],
)
def test_a_program_that_cannot_be_read_is_one_line(cli, part, text, words):
    part.write_text(text)
    assert cli("gcode", "check", part) == 2
    assert cli.out == ""
    assert cli.err.count("\n") == 1
    assert all(word in cli.err for word in words)


def test_what_was_asked_wrongly_is_one_line(cli, part):
    for words in (("--dialect", "fanuc"), ("--tools", "none.toml")):
        assert cli("gcode", "check", part, *words) == 2
        assert cli.err.count("\n") == 1
