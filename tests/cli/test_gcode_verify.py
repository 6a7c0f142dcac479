"""``splinearm gcode check --part``: right programs pass, wrong ones exit with 1 and their worst."""

import json

import pytest

from splinearm.cli.main import main

ezdxf = pytest.importorskip("ezdxf", reason="ezdxf is not installed")

PROGRAM = """G21 G90 G94
M3 S9000
G0 Z5
G0 X-{r} Y0
G1 Z-2 F200
Y20 F600
G2 X0 Y{u} I{r}
G1 X40
G2 X{v} Y20 J-{r}
G1 Y0
G2 X40 Y-{r} I-{r}
G1 X0
G2 X-{r} Y0 J{r}
G0 Z5
M2
"""


@pytest.fixture
def part(tmp_path):
    document = ezdxf.new(units=4)
    document.modelspace().add_lwpolyline([(0, 0), (40, 0), (40, 20), (0, 20)], close=True)
    document.saveas(tmp_path / "part.dxf")
    return tmp_path / "part.dxf"


def program(tmp_path, radius):
    file = tmp_path / "part.ngc"
    file.write_text(PROGRAM.format(r=radius, u=20 + radius, v=40 + radius))
    return str(file)


def check(file, part, *words):
    return main(["gcode", "check", file, "--part", str(part), "--cell", "0.5", *words])


def test_a_program_that_cuts_its_part_passes(tmp_path, part, capsys):
    assert check(program(tmp_path, 3), part, "--depth", "2", "--tool", "6") == 0
    assert "verified: gouge 0.000000 mm" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--depth", "2", "--tool", "6.2"], ": cuts 0.1 mm into the part at ("),
        (["--depth", "2", "--tool", "5"], "left over: leaves 0.5 mm"),
        (["--depth", "1.5", "--tool", "6"], "too deep: line 5: goes 0.5 mm below the floor"),
        (["--depth", "2", "--tool", "6", "--side", "inside"], "gouge"),
    ],
)
def test_a_program_that_does_not_names_the_worst(tmp_path, part, capsys, words, says):
    assert check(program(tmp_path, 3), part, *words) == 1
    assert says in capsys.readouterr().out


def test_json_holds_the_verification(tmp_path, part, capsys):
    words = ("--depth", "2", "--tool", "6.2", "--json", "--dialect", "grbl")
    assert check(program(tmp_path, 3), part, *words) == 1
    found = json.loads(capsys.readouterr().out)["verification"]
    assert found["gouge"] == pytest.approx(1e-4, abs=1e-9)
    assert found["faults"][0]["kind"] == "gouge"
    assert found["faults"][0]["line"] > 0


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--tool", "6"], "--depth: is missing"),
        (["--depth", "2"], "--tool: is missing"),
        (["--depth", "-2", "--tool", "6"], "above zero"),
        (["--depth", "2", "--tool", "6", "--layer", "none"], "layer 'none'"),
    ],
)
def test_words_that_are_missing_or_wrong_are_named(tmp_path, part, capsys, words, says):
    assert check(program(tmp_path, 3), part, *words) == 2
    assert says in capsys.readouterr().err


def test_a_table_of_tools_says_how_fast_each_may_go(tmp_path, part, capsys):
    table = tmp_path / "tools.toml"
    table.write_text(
        'schema = "splinearm-tools/1"\n[[tool]]\nnumber = 1\ndiameter_mm = 6\n'
        "feed_mm_min = 500\nplunge_mm_min = 300\nstep_down_mm = 2\n"
    )
    assert check(program(tmp_path, 3), part, "--depth", "2", "--tools", str(table)) == 1
    said = capsys.readouterr().out
    assert "feed: line 6: cuts at 600 mm/min; the cutter may 500 mm/min" in said
