"""Drawings from DXF and SVG: everything in its place, arcs as arcs, and what is broken refused."""

from math import pi

import numpy as np
import pytest

from splinearm.errors import DrawingError
from splinearm.toolpaths.drawing import read_drawing
from splinearm.toolpaths.piece import ArcPiece, LinePiece, SplinePiece

ezdxf = pytest.importorskip("ezdxf")
pytest.importorskip("svgelements")

MM = 1e-3


@pytest.fixture
def dxf(tmp_path):
    """Give a function that saves a DXF file which another function draws, and reads it."""

    def read(draw, *, insunits=4, unit=None, setup=None):
        document = ezdxf.new("R2010")
        document.header["$INSUNITS"] = insunits
        if setup is not None:
            setup(document)
        draw(document.modelspace())
        file = tmp_path / "part.dxf"
        document.saveas(file)
        return read_drawing(file, unit)

    return read


@pytest.fixture
def svg(tmp_path):
    """Give a function that saves an SVG file of a body, and reads it."""

    def read(body, head='width="200mm" height="100mm" viewBox="0 0 200 100"'):
        file = tmp_path / "part.svg"
        file.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {head}>{body}</svg>')
        return read_drawing(file)

    return read


def close(actual, wanted):
    np.testing.assert_allclose(actual, np.asarray(wanted) * MM, atol=1e-14)


def test_a_dxf_line_and_its_layer_come_in_metres(dxf):
    drawing = dxf(lambda space: space.add_line((1, 2), (4, 6), dxfattribs={"layer": "cut"}))
    (piece,) = drawing.pieces
    assert isinstance(piece, LinePiece)
    close(piece.start, (1, 2))
    close(piece.end, (4, 6))
    assert drawing.layers == ("cut",)


@pytest.mark.parametrize(("code", "metres"), [(1, 0.0254), (4, 1e-3), (5, 1e-2), (6, 1.0)])
def test_the_unit_of_a_dxf_file_is_kept(dxf, code, metres):
    drawing = dxf(lambda space: space.add_line((0, 0), (2, 0)), insunits=code)
    assert drawing.pieces[0].length == pytest.approx(2 * metres, rel=1e-15)


def test_a_dxf_file_without_a_unit_is_in_the_one_asked_for(dxf):
    drawing = dxf(lambda space: space.add_line((0, 0), (2, 0)), insunits=0, unit="in")
    assert drawing.unit == "in"
    assert drawing.pieces[0].length == pytest.approx(2 * 0.0254, rel=1e-15)


def test_dxf_arcs_and_circles_stay_arcs(dxf):
    def draw(space):
        space.add_arc((10, 0), 5, start_angle=30, end_angle=-60)
        space.add_circle((1, 1), 2)

    arc, circle = dxf(draw).pieces
    assert isinstance(arc, ArcPiece)
    assert arc.turn == pytest.approx(1.5 * pi)
    close(arc.centre, (10, 0))
    close(arc.start, (10 + 5 * np.cos(pi / 6), 2.5))
    close(arc.end, (12.5, -5 * np.sin(pi / 3)))
    assert circle.turn == pytest.approx(2 * pi)
    assert (circle.start == circle.end).all()
    assert circle.length == pytest.approx(4 * pi * MM)


def test_what_is_drawn_on_the_back_of_the_plane_is_mirrored(dxf):
    attributes = {"extrusion": (0, 0, -1)}

    def draw(space):
        space.add_arc((10, 0), 5, 0, 90, dxfattribs=attributes)
        space.add_lwpolyline([(0, 0, 1.0), (2, 0, 0.0)], format="xyb", dxfattribs=attributes)

    arc, bulge = dxf(draw).pieces
    close(arc.centre, (-10, 0))
    close(arc.start, (-15, 0))
    close(arc.end, (-10, 5))
    assert arc.turn == pytest.approx(-0.5 * pi)
    close(bulge.middle, (-1, -1))
    assert bulge.turn == pytest.approx(-pi)


def test_polylines_with_bulges_become_lines_and_arcs(dxf):
    def draw(space):
        space.add_lwpolyline(
            [(0, 0, 0), (10, 0, 1), (10, 4, 0), (0, 4, 0)], format="xyb", close=True
        )
        space.add_polyline2d([(20, 0, 0.5), (30, 0, 0)], format="xyb")

    pieces = dxf(draw).pieces
    assert [type(piece) for piece in pieces] == [
        LinePiece, ArcPiece, LinePiece, LinePiece, ArcPiece,
    ]  # fmt: skip
    close(pieces[1].middle, (12, 2))
    assert pieces[4].bulge == pytest.approx(0.5)
    # the height of an arc over its chord is half of the chord times the bulge
    close(pieces[4].middle, (25, -2.5))


def test_an_ellipse_is_exact_and_one_that_is_round_is_an_arc(dxf):
    def draw(space):
        space.add_ellipse((5, 5), major_axis=(4, 3), ratio=0.4, start_param=0.3, end_param=2.0)
        space.add_ellipse((0, 0), major_axis=(0, 3), ratio=1.0)

    ellipse, circle = dxf(draw).pieces
    assert isinstance(ellipse, SplinePiece)
    places = ellipse.curve.at(np.linspace(*ellipse.curve.domain, 50)) / MM - 5
    along = places @ (4, 3) / 25
    across = places @ (-3, 4) / 25 / 0.4
    np.testing.assert_allclose(along**2 + across**2, 1.0, atol=1e-13)
    np.testing.assert_allclose(np.arctan2(across, along)[[0, -1]], (0.3, 2.0), atol=1e-13)
    assert isinstance(circle, ArcPiece)
    assert circle.turn == pytest.approx(2 * pi)


def test_a_dxf_spline_keeps_its_knots_points_and_weights(dxf):
    points, knots = [(0, 0), (1, 2), (3, 2), (4, 0)], [0, 0, 0, 0, 1, 1, 1, 1]

    def draw(space):
        space.add_rational_spline(points, [1, 2, 2, 1], degree=3, knots=knots)
        space.add_spline(fit_points=[(0, 0, 0), (1, 1, 0), (2, 0, 0)])

    rational, fitted = dxf(draw).pieces
    close(rational.curve.points, points)
    np.testing.assert_array_equal(rational.curve.weights, [1, 2, 2, 1])
    np.testing.assert_array_equal(rational.curve.knots, knots)
    close(fitted.curve.at(fitted.curve.breaks), [(0, 0), (1, 1), (2, 0)])


def test_blocks_come_where_they_are_inserted_also_within_each_other(dxf):
    def setup(document):
        inner = document.blocks.new("inner")
        inner.add_circle((0, 0), 1)
        outer = document.blocks.new("outer")
        outer.add_blockref("inner", (5, 0), dxfattribs={"xscale": 2, "yscale": 2})

    def draw(space):
        space.add_blockref("outer", (10, 0), dxfattribs={"rotation": 90})

    (circle,) = dxf(draw, setup=setup).pieces
    close(circle.centre, (10, 5))
    assert circle.radius == pytest.approx(2 * MM)


def test_a_block_within_itself_is_refused(dxf):
    def setup(document):
        one, two = document.blocks.new("one"), document.blocks.new("two")
        one.add_blockref("two", (0, 0))
        two.add_blockref("one", (0, 0))

    with pytest.raises(DrawingError, match=r"block 'one'.*within itself"):
        dxf(lambda space: space.add_blockref("one", (0, 0)), setup=setup)


def test_texts_and_hidden_layers_are_left_out_and_counted(dxf):
    def draw(space):
        space.add_line((0, 0), (1, 0))
        space.add_text("hello")
        space.add_line((0, 0), (5, 0), dxfattribs={"layer": "help"})

    drawing = dxf(draw, setup=lambda document: document.layers.add("help").off())
    assert len(drawing.pieces) == 1
    assert drawing.left_out == {"TEXT": 1, "LINE on a layer that is off": 1}


def test_a_drawing_in_space_is_refused_with_the_place(dxf):
    with pytest.raises(DrawingError, match=r"leaves its plane at \(4, 6, 1\)"):
        dxf(lambda space: space.add_line((1, 2, 0), (4, 6, 1)))
    with pytest.raises(DrawingError, match="slant"):
        dxf(lambda space: space.add_circle((0, 0), 1, dxfattribs={"extrusion": (0, 1, 1)}))


def test_an_empty_drawing_says_what_it_holds(dxf):
    with pytest.raises(DrawingError, match="it holds 1 TEXT"):
        dxf(lambda space: space.add_text("only words"))


def test_layers_are_chosen_by_name(dxf):
    def draw(space):
        for name in ("a", "b"):
            space.add_line((0, 0), (1, 0), dxfattribs={"layer": name})

    drawing = dxf(draw)
    assert drawing.on_layers("b").layers == ("b",)
    with pytest.raises(DrawingError, match="'a', 'b'"):
        drawing.on_layers("c")


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 0.999])
def test_a_dxf_file_that_was_cut_off_is_refused_in_one_line(dxf, tmp_path, share):
    dxf(lambda space: space.add_line((0, 0), (1, 0)))
    whole = (tmp_path / "part.dxf").read_bytes()
    broken = tmp_path / "broken.dxf"
    broken.write_bytes(whole[: int(len(whole) * share)])
    with pytest.raises(DrawingError) as caught:
        read_drawing(broken)
    assert "\n" not in str(caught.value)


def test_numbers_that_are_none_are_refused(dxf, tmp_path):
    dxf(lambda space: space.add_line((0, 0), (1.2345, 0)))
    text = (tmp_path / "part.dxf").read_text()
    for wrong in ("nan", "inf", "wrong"):
        (tmp_path / "nan.dxf").write_text(text.replace("1.2345", wrong))
        with pytest.raises(DrawingError) as caught:
            read_drawing(tmp_path / "nan.dxf")
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["none.dxf", "none.svg", "none.txt"])
def test_a_file_that_is_not_there_or_of_another_kind_is_refused(tmp_path, name):
    with pytest.raises(DrawingError, match=name):
        read_drawing(tmp_path / name)


def test_an_svg_page_is_turned_over_and_exact_in_millimetres(svg):
    (piece,) = svg('<path d="M 10 20 L 110 20"/>').pieces
    close(piece.start, (10, 80))
    close(piece.end, (110, 80))


def test_svg_units_without_a_viewbox_are_pixels(svg):
    (piece,) = svg('<path d="M 0 96 L 96 96"/>', head='width="960" height="480"').pieces
    close(piece.start, (0, 101.6))
    close(piece.end, (25.4, 101.6))


def test_svg_curves_keep_their_control_points(svg):
    cubic, quadratic = svg('<path d="M 0 100 C 1 98 3 98 4 100 Q 6 96 8 100"/>').pieces
    close(cubic.curve.points, [(0, 0), (1, 2), (3, 2), (4, 0)])
    close(quadratic.curve.points, [(4, 0), (6, 4), (8, 0)])


@pytest.mark.parametrize("sweep", [0, 1])
@pytest.mark.parametrize("large", [0, 1])
def test_svg_arcs_stay_arcs_whichever_way_they_run(svg, large, sweep):
    (arc,) = svg(f'<path d="M 50 50 A 10 10 0 {large} {sweep} 60 60"/>').pieces
    assert isinstance(arc, ArcPiece)
    assert arc.radius == pytest.approx(10 * MM)
    close(arc.start, (50, 50))
    close(arc.end, (60, 40))
    # on the page, y down, sweep 1 turns from x to y: turned over that is to the right
    assert (arc.turn > 0) == (sweep == 0)
    assert abs(arc.turn) == pytest.approx(1.5 * pi if large else 0.5 * pi)
    assert np.hypot(*(arc.middle - arc.centre)) == pytest.approx(10 * MM)


def test_an_svg_ellipse_under_a_transform_is_exact(svg):
    body = '<ellipse cx="0" cy="0" rx="8" ry="4" transform="translate(50 50) rotate(30)"/>'
    pieces = svg(body).pieces
    places = np.vstack([p.curve.at(np.linspace(*p.curve.domain, 20)) for p in pieces]) / MM - 50
    c, s = np.cos(pi / 6), np.sin(pi / 6)
    x, y = places @ (c, -s), places @ (s, c)  # 30 degrees on the page is -30 turned over
    np.testing.assert_allclose((x / 8) ** 2 + (y / 4) ** 2, 1.0, atol=1e-10)
    assert sum(p.length for p in pieces) == pytest.approx(38.7537929e-3, rel=1e-6)


def test_svg_shapes_groups_and_uses_are_drawn(svg):
    body = """
      <defs><circle id="hole" r="3"/></defs>
      <g transform="translate(20 0)"><rect x="0" y="0" width="10" height="5"/></g>
      <use href="#hole" x="50" y="50"/><polyline points="0,0 1,1 2,0"/><text>no</text>"""
    drawing = svg(body)
    kinds = [type(piece).__name__ for piece in drawing.pieces]
    assert kinds.count("LinePiece") == 6
    assert sum(p.length for p in drawing.pieces if isinstance(p, ArcPiece)) == pytest.approx(
        6 * pi * MM
    )
    assert drawing.left_out == {"text": 1}


NS = "<svg xmlns='http://www.w3.org/2000/svg'"
BILLION = "".join(f"<!ENTITY a{i + 1} '{f'&a{i};' * 9}'>" for i in range(9))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "no xml",
        "<html/>",
        f"{NS}><path d='M 0 0 L 1",
        f"{NS}/>",
        f"{NS} width='5' height='5'><path d='M 0 0 L NaN 1'/></svg>",
        f"{NS} width='5' height='5'><path d='M 0 0 L 1e999 1'/></svg>",
        f"{NS} width='wide' height='5'><path d='M 0 0 L 1 1'/></svg>",
        f"{NS} viewBox='0 0 x 5'><path d='M 0 0 L 1 1'/></svg>",
        f"{NS} width='5' height='5'>{'<g>' * 1000}<path d='M 0 0 L'/>{'</g>' * 1000}</svg>",
        f"<!DOCTYPE s [<!ENTITY a0 'aaaaaaaaa'>{BILLION}]>{NS}><text>&a9;</text></svg>",
    ],
    ids=range(11),
)
def test_a_broken_svg_file_is_refused_in_one_line(tmp_path, text):
    file = tmp_path / "broken.svg"
    file.write_text(text)
    with pytest.raises(DrawingError) as caught:
        read_drawing(file)
    assert "\n" not in str(caught.value)
