"""Broken drawings and programs: each ends in one clear line, soon, and never in a traceback."""

import time

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from splinearm.cli.main import main
from splinearm.errors import DrawingError, GcodeError, SplinearmError
from splinearm.toolpaths.drawing import read_drawing
from splinearm.toolpaths.gcode_interpreter import run_gcode

SOON = 5.0

SVG = """<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"
 width="100mm" height="50mm" viewBox="0 0 100 50">{}</svg>"""
LINE = '<line x1="0" y1="0" x2="1" y2="1"/>'
SHAPES = """<g transform="translate(1,2) rotate(10)"><path d="M0,0 L10,0 A5 5 0 0 1 10 10
 C 5 5 4 4 0 10 Q 1 1 0 0 Z"/><rect x="1" y="2" width="5" height="6" rx="1"/>
 <circle cx="3" cy="4" r="2"/><ellipse cx="3" cy="4" rx="2" ry="1"/></g>"""
PROGRAM = """%
(a part)
#1=3 #<depth>=[2*#1]
o<cut> sub
o1 if [#1 gt 2]
G1 X[#1+sin[30]] Y2 F100
o1 else
G2 X1 Y1 I1 J0
o1 endif
o<cut> endsub [#1]
G21 G90 G0 Z5
o<cut> call [5]
G81 X1 Y2 Z-3 R1 F60
G80
o3 repeat [3]
G3 X0 Y0 R5 F100
G1 X1
o3 endrepeat
G5 I0 J3 P0 Q-3 X1 Y1
M2
%
"""
WORDS = [b"nan", b"inf", b"-1e999", b"1e308", b"1e-320", b"0", b"-1", b"9" * 30, b"[", b"]", b"#"]


@pytest.fixture(scope="module")
def dxf(tmp_path_factory):
    ezdxf = pytest.importorskip("ezdxf", reason="ezdxf is not installed")
    file = tmp_path_factory.mktemp("dxf") / "part.dxf"
    document = ezdxf.new(units=4)
    space = document.modelspace()
    space.add_arc((0, 0), 2, 10, 80)
    space.add_ellipse((0, 0), (2, 1), 0.4)
    space.add_lwpolyline([(0, 0, 0, 0, 1), (2, 0), (2, 2, 0, 0, -0.5)], close=True)
    space.add_spline([(0, 0), (1, 2), (3, 1), (4, 4)])
    document.blocks.new("B").add_line((0, 0), (1, 0))
    space.add_blockref("B", (1, 1))
    document.saveas(file)
    return file.read_bytes()


@st.composite
def broken(draw, whole):
    """Text that was cut off, written over, cut out of, doubled or put in other order."""
    data, size = bytearray(whole), len(whole)
    at = draw(st.integers(0, size - 1))
    how = draw(st.sampled_from(("cut", "over", "out", "twice", "word", "noise")))
    if how == "cut":
        return bytes(data[:at])
    if how == "over":
        for _ in range(draw(st.integers(1, 8))):
            data[draw(st.integers(0, size - 1))] = draw(st.integers(0, 255))
        return bytes(data)
    end = min(size, at + draw(st.integers(1, 60)))
    if how == "out":
        return bytes(data[:at] + data[end:])
    if how == "twice":
        return bytes(data[:end] + data[at:end] * draw(st.integers(1, 4)) + data[end:])
    if how == "word":
        while at < size and not chr(data[at]).isdigit():
            at += 1
        return bytes(data[:at] + draw(st.sampled_from(WORDS)) + data[at + 1 :])
    return bytes(data[:at] + draw(st.binary(min_size=1, max_size=20)) + data[at:])


def ends_well(read, file):
    begun, says = time.monotonic(), ""
    try:
        read(file)
    except SplinearmError as error:
        says = str(error)
    assert "\n" not in says
    assert len(says) < 600
    # no bound of speed: what hangs takes forever
    assert time.monotonic() - begun < 12 * SOON


many = settings(
    max_examples=120, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@pytest.mark.property
@many
@given(data=st.data())
def test_broken_dxf_files_end_in_one_line(tmp_path, dxf, data):
    file = tmp_path / "part.dxf"
    file.write_bytes(data.draw(broken(dxf)))
    ends_well(read_drawing, file)


@pytest.mark.property
@many
@given(text=broken(SVG.format(SHAPES).encode()))
def test_broken_svg_files_end_in_one_line(tmp_path, text):
    pytest.importorskip("svgelements", reason="svgelements is not installed")
    file = tmp_path / "part.svg"
    file.write_bytes(text)
    ends_well(read_drawing, file)


@pytest.mark.property
@many
@given(text=broken(PROGRAM.encode()) | st.binary(max_size=200))
def test_broken_programs_end_in_one_line(tmp_path, text):
    file = tmp_path / "part.ngc"
    file.write_bytes(text)
    ends_well(run_gcode, file)


BOMB = "".join(
    f'<g id="a{i}">' + (f'<use xlink:href="#a{i - 1}"/>' * 10 if i else LINE) + "</g>"
    for i in range(9)
)
DRAWINGS = {
    "used within itself": f'<g id="a">{LINE}<use xlink:href="#a"/></g>',
    "elements; at most": f'<defs>{BOMB}</defs><use xlink:href="#a8"/>',
    "too deep": "<g>" * 3000 + LINE + "</g>" * 3000,
    "valid SVG": '<path d="M nan,0 L 1 1"/>',
    "m large": '<path d="M 1e200,0 L -1e200 1"/>',
    "division by zero": '<path d="M 0,0 A 1e-300 1 0 1 1 5 5"/>',
    "nothing in it": f'<g transform="scale(0)">{LINE}</g>',
    "Singular": '<g transform="matrix(1 1 1 1 0 0)"><circle cx="1" cy="1" r="1"/></g>',
    "characters long": "<style>" + "a{" * 40_000 + f"</style>{LINE}",
}


@pytest.mark.parametrize("says", DRAWINGS)
def test_drawings_that_mean_too_much_or_nothing_are_refused(tmp_path, says):
    pytest.importorskip("svgelements", reason="svgelements is not installed")
    file = tmp_path / "part.svg"
    file.write_text(SVG.format(DRAWINGS[says]))
    with pytest.raises(DrawingError, match=says):
        read_drawing(file)


def test_an_entity_that_explodes_is_refused(tmp_path):
    lol = "".join(f'<!ENTITY e{i} "{f"&e{i - 1};" * 10}">' for i in range(1, 12))
    file = tmp_path / "part.svg"
    text = f'<!DOCTYPE svg [<!ENTITY e0 "lol">{lol}]>' + SVG.format("<text>&e11;</text>")
    file.write_text(text)
    with pytest.raises(DrawingError, match="valid SVG"):
        read_drawing(file)


def blocks(kind):
    def cycle(document):
        for one, other in (("A", "B"), ("B", "A")):
            document.blocks.new(one).add_blockref(other, (0, 0))

    def tree(document):
        for i in range(9):
            block = document.blocks.new("A" if i == 8 else f"A{i}")
            for _ in range(10):
                block.add_blockref(f"A{i - 1}", (0, 0)) if i else block.add_line((0, 0), (1, 1))

    def field(document):
        document.blocks.new("A").add_line((0, 0), (1, 1))

    return {"cycle": cycle, "tree": tree, "field": field}[kind]


@pytest.mark.parametrize(
    ("kind", "says"),
    [("cycle", "lies within itself"), ("tree", "blocks are placed"), ("field", "are placed")],
)
def test_blocks_without_end_are_refused(tmp_path, monkeypatch, kind, says):
    ezdxf = pytest.importorskip("ezdxf", reason="ezdxf is not installed")
    document = ezdxf.new()
    blocks(kind)(document)
    monkeypatch.setattr("splinearm.toolpaths.drawing_dxf._MOST_BLOCKS", 300)
    side = {"row_count": 30_000, "row_spacing": 1, "column_count": 30_000, "column_spacing": 1}
    many = side if kind == "field" else {}
    document.modelspace().add_blockref("A", (0, 0), dxfattribs=many)
    document.saveas(tmp_path / "part.dxf")
    with pytest.raises(DrawingError, match=says):
        read_drawing(tmp_path / "part.dxf")


@pytest.mark.parametrize("data", [bytes(range(256)) * 99, b"AutoCAD Binary DXF\r\n\x1a\0xyz", b""])
@pytest.mark.parametrize("suffix", [".dxf", ".svg"])
def test_noise_is_no_drawing(tmp_path, data, suffix):
    file = tmp_path / f"part{suffix}"
    file.write_bytes(data)
    with pytest.raises(DrawingError):
        read_drawing(file)


PROGRAMS = {
    "has it an end": "F1\no1 while [1]\n#1=[#1+1]\no1 endwhile\n",
    "calls within": "o<a> sub\no<a> call\no<a> endsub\no<a> call\n",
    "brackets lie": "G1 F1 X" + "[" * 1000 + "1" + "]" * 1000,
    "too long to be worked out": "G1 F1 X[" + "+".join(["1"] * 2000) + "]",
    "lies more than 100 deep": "".join(f"o{i} if [1]\n" for i in range(1000)),
    "want a word": "".join(map(chr, range(256))) * 9,
    "characters long": "X" * 100_000,
    "turns": "G3 X0 I1 P1000000000 F1",
    "drills 1e": "G83 Z-1000000 R0 Q0.000001 F1",
    "at most 100000": "G91 G81 X1 Z-1 R1 L1000000000 F1",
    "control points, got": "F1\nG5.2 L1000000\nX1 Y1\nX2 Y2\nG5.3",
    "too large": "G1 X1" + "0" * 400 + " F1",
    "no finite number": "G1 X[9**9**9**9]",
    "cannot be done inf times": "#1=[10**300]\no1 repeat [#1*#1]\no1 endrepeat",
}


@pytest.mark.parametrize("says", PROGRAMS)
def test_programs_without_end_or_sense_name_their_line(tmp_path, monkeypatch, says):
    monkeypatch.setattr("splinearm.toolpaths.gcode_flow.MOST_BLOCKS", 20_000)
    file = tmp_path / "part.ngc"
    file.write_text(PROGRAMS[says])
    with pytest.raises(GcodeError, match=says) as caught:
        run_gcode(file)
    assert caught.value.line > 0


@pytest.mark.parametrize("command", [["gcode", "check"], ["toolpath"]])
@pytest.mark.parametrize("name", ["none.dxf", "noise.dxf", "noise.svg", "noise.ngc", "a.txt"])
def test_the_command_line_says_one_line_and_leaves(tmp_path, capsys, command, name):
    file = tmp_path / name
    if name != "none.dxf":
        file.write_bytes(bytes(range(256)))
    words = ["--tool", "6", "--depth", "2"] if command == ["toolpath"] else []
    assert main([*command, str(file), *words]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("splinearm: ")
    assert said.err.count("\n") == 1


def test_notes_behind_the_end_of_a_program_are_not_read(tmp_path):
    file = tmp_path / "part.ngc"
    file.write_text("G0 X1\nm02\nthese are notes\n")
    assert len(run_gcode(file)) == 2
    file.write_text("o1 if [0]\nM2\no1 endif\nthese are none\n")
    with pytest.raises(GcodeError, match="4"):
        run_gcode(file)
