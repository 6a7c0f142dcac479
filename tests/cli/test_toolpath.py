"""``splinearm toolpath``: a drawing becomes a program that was verified."""

import json
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
PART = EXAMPLES / "bracket.dxf"
POCKET = ("--operation", "pocket", "--layers", "pockets", "--tool", "6", "--depth", "4")

pytest.importorskip("ezdxf")


def test_a_drawing_becomes_a_program(cli):
    assert cli("toolpath", PART, *POCKET, "-o", "part.ngc") == 0
    assert "verified: gouge 0.000000 mm" in cli.out
    assert "3 closed wires, 0 open" in cli.out
    assert "left out: 1 TEXT" in cli.out
    assert "about" in cli.out
    text = (cli.folder / "part.ngc").read_text()
    assert text.startswith("%\n(bracket.dxf by splinearm)\n")
    assert "G2 " in text
    assert cli("gcode", "check", cli.folder / "part.ngc", "--dialect", "linuxcnc") == 0


@pytest.mark.parametrize("ending", ["png", "svg"])
def test_a_preview_is_drawn(ending, cli):
    picture = cli.folder / f"part.{ending}"
    assert cli("toolpath", PART, *POCKET, "--preview", picture, "--no-verify") == 0
    assert picture.stat().st_size > 10_000


@pytest.mark.parametrize(
    "words",
    [
        ("--side", "outside", "--layers", "outline", "--tabs", "3", "--lead", "3", "--ramp", "3"),
        (
            "--operation",
            "pocket",
            "--layers",
            "pockets",
            "--helix",
            "2",
            "--stock",
            "0.2",
            "--finish",
        ),
        ("--operation", "zigzag", "--layers", "pockets", "--angle", "30", "--step-over", "80"),
        ("--operation", "spiral", "--layers", "pockets", "--conventional", "--step-down", "1"),
        ("--operation", "drill", "--layers", "holes", "--peck", "2"),
    ],
)
@pytest.mark.parametrize("dialect", ["linuxcnc", "grbl"])
def test_every_operation_is_verified_for_every_controller(words, dialect, cli):
    code = cli(
        "toolpath", PART, "--tool", "6", "--depth", "4", *words, "--dialect", dialect, "-o", "a.ngc"
    )
    assert code == 0, cli.out + cli.err
    assert "verified:" in cli.out
    assert cli("gcode", "check", "a.ngc", "--dialect", dialect) == 0


def test_a_job_file_does_several_operations(cli):
    assert cli("toolpath", EXAMPLES / "bracket" / "bracket.toml", "-o", "a.ngc", "--json") == 0
    facts = json.loads(cli.out)
    assert [one["kind"] for one in facts["operations"]] == ["pocket", "drill", "profile"]
    assert facts["verification"]["ok"]
    assert facts["verification"]["gouge"] <= 1e-9
    assert facts["layers"] == ["outline", "pockets", "holes"]
    assert facts["low"][2] == -8e-3
    assert facts["time"] > facts["cutting_time"]
    text = (cli.folder / "a.ngc").read_text()
    assert [line for line in text.splitlines() if "M6" in line] == ["T1 M6", "T2 M6", "T1 M6"]


def test_engraving_is_verified_unless_that_is_not_wanted(cli):
    words = ("--tool", "3", "--depth", "0.2", "--operation", "engrave")
    assert cli("toolpath", PART, *words) == 0
    assert "verified: gouge 0.000000 mm, left 0.000000 mm" in cli.out
    assert cli("toolpath", PART, *words, "--no-verify") == 0
    assert "not verified" in cli.out
    assert cli.files() == set()


def test_a_program_that_is_wrong_is_not_written(cli):
    # the cutter's table allows less than a pass takes
    tools = cli.write(
        "tools.toml",
        'schema = "splinearm-tools/1"\n[[tool]]\nnumber = 1\ndiameter_mm = 6\nfeed_mm_min = 600\n'
        "plunge_mm_min = 200\nstep_down_mm = 1\n",
    )
    words = ("--tools", tools, "--tool", "1", "--depth", "4", "--step-down", "4")
    assert cli("toolpath", PART, "--layers", "outline", *words, "-o", "a.ngc") == 1
    assert "step down" in cli.out
    assert cli.files() == {"tools.toml"}
    assert cli("toolpath", PART, "--tools", tools, "--tool", "2", "--depth", "4") == 2
    assert "there are 1" in cli.err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--depth", "3"), "--tool"),
        (("--tool", "6"), "--depth"),
        (("--tool", "6", "--depth", "3", "--layers", "none"), "'outline', 'pockets', 'holes'"),
        (("--tool", "6", "--depth", "-1"), "depth"),
        (("--tool", "6", "--depth", "3", "--dialect", "fanuc"), "linuxcnc, grbl"),
        (("--tool", "6", "--depth", "3", "--unit", "yd"), "unit"),
        (("--tool", "80", "--depth", "3", "--operation", "pocket"), "nothing is left"),
        (("--tool", "6", "--depth", "3", "--tabs", "99", "--layers", "outline"), "no room"),
        (("--tool", "6", "--depth", "3", "--tolerance", "0"), "tolerance"),
        (("--tool", "6", "--depth", "3", "--spindle", "nan"), "speed"),
        (("--tool", "6", "--depth", "3", "--finish"), "stock"),
        (("--tool", "6", "--depth", "3", "--step-down", "1e-9"), "more than 1000 passes"),
        (("--tool", "6", "--depth", "3", "--ramp", "1e-9"), "want 0.01 to below 90 deg"),
        (
            ("--tool", "6", "--depth", "3", "--stock", "1e9", "--layers", "outline"),
            "too wide to be cut",
        ),
        (("--tool", "6", "--depth", "3", "-o", "nowhere/a.ngc"), "folder"),
    ],
)
def test_what_cannot_be_done_is_one_line(words, said, cli):
    assert cli("toolpath", PART, *words) == 2
    assert cli.out == ""
    assert cli.err.count("\n") == 1
    assert said in cli.err


def test_parts_that_overlap_are_refused_with_the_place(cli):
    text = PART.read_text().replace("AcDbCircle\n 10\n40.0", "AcDbCircle\n 10\n9.0")
    assert text != PART.read_text()
    part = cli.write("part.dxf", text)
    assert cli("toolpath", part, *POCKET) == 2
    assert "cross" in cli.err
    assert " mm" in cli.err


def test_linuxcnc_takes_every_arc_as_an_arc(cli, rs274):
    assert cli("toolpath", EXAMPLES / "bracket" / "bracket.toml", "-o", "a.ngc", "--json") == 0
    ways = json.loads(cli.out)["ways"]
    done = rs274(cli.folder / "a.ngc", "T1 P1 D6 Z0\nT2 P2 D6 Z0\n")
    assert done.stdout.count("ARC_FEED") == ways["arcs"]
    assert done.stdout.count("STRAIGHT_FEED") == ways["lines"]


def test_a_file_that_is_there_is_kept(cli):
    cli.write("a.ngc", "mine")
    assert cli("toolpath", PART, *POCKET, "-o", "a.ngc") == 2
    assert (cli.folder / "a.ngc").read_text() == "mine"


def test_open_ends_and_what_is_drawn_twice_are_told_with_their_places(cli):
    svg = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="40mm" viewBox="0 0 60 40">'
        '<rect x="5" y="5" width="30" height="25"/><path d="M40,10 L50,10"/>'
        '<path d="M40,20 L50,20"/><path d="M50,20 L40,20"/></svg>'
    )
    pytest.importorskip("svgelements")
    part = cli.write("part.svg", svg)
    assert cli("toolpath", part, "--tool", "3", "--depth", "2") == 0
    told = " ".join(cli.out.split())
    assert "1 closed wires, 2 open; 4 open ends at (40, " in told
    assert "1 drawn twice at (45, 20) mm" in told
    assert "2 open wires enclose nothing" in told
