"""Operations on drawings, joined to one program and verified."""

from math import pi

import numpy as np
import pytest

from splinearm.errors import DrawingError, ToolpathError
from splinearm.toolpaths.action import ArcFeed, Feed, Rapid, Spindle, SplineFeed, ToolChange
from splinearm.toolpaths.checking import verified
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.drawing import Drawing, Drawn
from splinearm.toolpaths.fitting import fitted
from splinearm.toolpaths.gcode_check import write_checked
from splinearm.toolpaths.gcode_dialect import DIALECTS
from splinearm.toolpaths.joining import joined_program
from splinearm.toolpaths.operation import Entry, Milled, Notes, Side
from splinearm.toolpaths.piece import LinePiece
from splinearm.toolpaths.shape import ellipse_piece
from splinearm.toolpaths.tab import Tabs
from splinearm.toolpaths.work import Exactness, Kind, Work, carry_out


@pytest.fixture
def drawing():
    """A plate with a pocket, an ellipse, a hole and a line on layers of their own."""
    drawn = []

    def add(contour, layer):
        drawn.extend(Drawn(piece, layer) for piece in contour.pieces())

    add(Contour.rectangle([0.0, 0.0], [0.1, 0.06], 0.005), "outline")
    add(Contour.rectangle([0.01, 0.01], [0.03, 0.03], 0.004), "pocket")
    add(Contour.circle([0.09, 0.05], 0.002), "holes")
    round_ = ellipse_piece(
        np.array([0.065, 0.03]), np.array([0.015, 0.0]), np.array([0.0, 0.009]), 0.0, 2 * pi
    )
    drawn.append(Drawn(round_, "oval"))
    drawn.append(Drawn(LinePiece(np.array([0.005, 0.05]), np.array([0.03, 0.055])), "mark"))
    return Drawing(file="plate.dxf", unit="mm", drawn=tuple(drawn), left_out={})


def works(milling):
    """Give operations with two cutters."""
    one = {"depth": 3e-3, "entry": Entry.HELIX, "stock": 1e-4, "finish": True}
    drill = milling(number=2, depth=5e-3)
    return [
        Work(kind=Kind.POCKET, milling=milling(**one), layers=("pocket",)),
        Work(kind=Kind.SPIRAL, milling=milling(depth=3e-3), layers=("oval",)),
        Work(kind=Kind.DRILL, milling=drill, layers=("holes",), peck=2e-3),
        Work(
            kind=Kind.PROFILE,
            milling=milling(depth=5e-3, lead=2e-3),
            layers=("outline",),
            tabs=Tabs(count=3, length=3e-3, height=1e-3),
        ),
    ]


def test_a_part_is_made_and_verified(drawing, milling, follows):
    told = []
    actions, done = carry_out(drawing, works(milling), each=told.append)
    assert [one.work.kind for one in told] == [one.work.kind for one in done]
    follows(a for a in actions if not isinstance(a, Spindle | ToolChange))
    assert [a.tool for a in actions if isinstance(a, ToolChange)] == [1, 2, 1]
    report = verified(actions, done, 1e-5)
    assert report.ok, report.text()
    assert any(isinstance(a, SplineFeed) for a in actions)
    for dialect in DIALECTS.values():
        if not dialect.splines:
            actions, _ = carry_out(drawing, works(milling), Exactness(splines=False))
        text = write_checked(actions, dialect, "plate")
        # up before anything else, and after each change of tools
        assert "G0 Z5" in text
        assert "X0 Y0" not in text


def test_the_spindle_turns_whenever_something_is_cut(drawing, milling):
    actions, _ = carry_out(drawing, works(milling))
    turns = 0.0
    for action in actions:
        if isinstance(action, ToolChange):
            assert turns == 0.0
        if isinstance(action, Spindle):
            turns = action.speed
        if isinstance(action, Feed):
            assert turns == 1000.0
    assert turns == 0.0


def test_splines_are_cut_with_arcs_that_do_not_gouge(drawing, milling, cuts):
    tolerance = 2e-5
    work = Work(kind=Kind.PROFILE, milling=milling(), layers=("oval",), side=Side.INSIDE)
    actions, done = carry_out(drawing, [work], Exactness(tolerance=tolerance, splines=False))
    assert done[0].slack == 0.5 * tolerance
    (piece,) = [each.piece for each in drawing.drawn if each.layer == "oval"]
    first, last = piece.curve.domain
    looks = piece.curve.at(np.linspace(first, last, 20_001))
    from splinearm.toolpaths.contour_kernel import distances

    far = np.empty(len(looks))
    distances(cuts(actions).below(0.0), np.ascontiguousarray(looks), far)
    assert 2e-3 - 1e-9 <= far.min() <= far.max() <= 2e-3 + tolerance + 1e-9


def test_engraving_keeps_splines_where_the_controller_has_them(drawing, milling):
    work = Work(kind=Kind.ENGRAVE, milling=milling(depth=1e-3), layers=("oval", "mark"))
    for splines, count in ((True, 1), (False, 0)):
        actions, done = carry_out(drawing, [work], Exactness(splines=splines))
        assert sum(isinstance(a, SplineFeed) for a in actions) == count
        report = verified(actions, done, 1e-5)
        assert report.ok, report.text()
        assert report.left <= (1e-8 if splines else 1e-5)
        write_checked(actions, DIALECTS["linuxcnc" if splines else "grbl"])


def test_arcs_too_wide_for_a_controller_become_lines():
    centre = np.array([0.0, -30.0, 0.0])
    ends = [centre + 30.0 * np.array([np.sin(a), np.cos(a), 0.0]) for a in (0.0, 1e-3)]
    arc = ArcFeed(
        start=ends[0], end=ends[1], feed=0.01, blend=1e-5, centre=centre, axis=2, turn=-1e-3
    )
    up = [Rapid(start=np.zeros(3), end=ends[0] + [0, 0, 0.005])]
    down = [*up, Feed(start=up[0].end, end=ends[0], feed=0.01), arc]
    assert fitted(down, DIALECTS["linuxcnc"])[-1] is arc
    (*_, last) = lines = fitted(down, DIALECTS["grbl"])[2:]
    assert 4 <= len(lines) <= 8
    assert {(line.feed, line.blend) for line in lines} == {(0.01, 1e-5)}
    np.testing.assert_array_equal(last.end, arc.end)
    for line in lines:
        middle = 0.5 * (line.start + line.end)
        assert 30.0 - np.linalg.norm(middle - centre) <= 1e-7
    write_checked(fitted(down, DIALECTS["grbl"]), DIALECTS["grbl"])


@pytest.mark.parametrize("kind", [Kind.ZIGZAG, Kind.FACING])
def test_lines_to_and_fro_are_asked_for_like_others(kind, drawing, milling):
    work = Work(kind=kind, milling=milling(), layers=("pocket",), angle=0.3)
    actions, done = carry_out(drawing, [work])
    report = verified(actions, done, 1e-5)
    assert report.ok, report.text()


def test_what_cannot_be_cut_is_told(drawing, milling):
    work = Work(kind=Kind.POCKET, milling=milling(), layers=("pocket", "mark"))
    _, (done,) = carry_out(drawing, [work])
    assert "1 open wires" in done.milled.notes[-1]
    assert "(5, 50)" in done.milled.notes[-1]
    wide = Work(kind=Kind.DRILL, milling=milling(diameter=3e-3, step_over=1e-3), layers=("holes",))
    _, (done,) = carry_out(drawing, [wide])
    assert done.milled.notes == ("circles of 4 mm are drilled with 3 mm",)


@pytest.mark.parametrize(
    ("kind", "layers", "words"),
    [
        (Kind.POCKET, ("mark",), "needs closed wires; there is none; ends are open at (5, 50)"),
        (Kind.DRILL, ("outline",), "needs circles"),
        (Kind.POCKET, ("nowhere",), "is not there"),
    ],
)
def test_a_drawing_without_what_is_needed_is_refused(kind, layers, words, drawing, milling):
    with pytest.raises(DrawingError) as caught:
        carry_out(drawing, [Work(kind=kind, milling=milling(), layers=layers)])
    assert words in str(caught.value)


def test_a_program_without_ways_is_refused(drawing, milling):
    wide = milling(diameter=0.05, step_over=0.01)
    with pytest.raises(ToolpathError, match="nothing is left"):
        carry_out(drawing, [Work(kind=Kind.POCKET, milling=wide, layers=("pocket",))])
    way = Feed(start=np.zeros(3), end=np.ones(3), feed=1.0)
    with pytest.raises(TypeError, match="straight up"):
        joined_program([(wide.cutter, Milled((way, way, way)))])


def test_a_cutter_that_stays_goes_on_from_where_it_is(drawing, milling):
    own = milling(number=0, speed=0.0)
    several = [Work(kind=Kind.PROFILE, milling=own, layers=(n,)) for n in ("pocket", "outline")]
    actions, _ = carry_out(drawing, several)
    assert not any(isinstance(a, ToolChange | Spindle) for a in actions)
    moves = [a for a in actions if isinstance(a, Rapid | Feed)]
    assert sum(isinstance(a, Rapid) and (a.start == 0).all() for a in moves) == 1


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"depth": 0.0}, "depth"),
        ({"step_over": 5e-3}, "ridges"),
        ({"finish": True}, "stock"),
        ({"top": 1e-3}, "top"),
        ({"ramp_angle": 2.0}, "below 90 deg"),
        ({"lead": -1.0}, "lead"),
        ({"blend": 0.0}, "blend"),
        ({"step_down": float("nan")}, "step_down"),
    ],
)
def test_what_makes_no_sense_is_refused(changes, words, milling):
    with pytest.raises(ValueError, match=words):
        milling(**changes)


def test_levels_are_alike_and_end_at_the_depth(milling):
    assert milling(depth=5e-3).levels == (-5e-3 / 3, -5e-3 * 2 / 3, -5e-3)
    assert milling(depth=4e-3, top=-1e-3).levels == (-3e-3, -5e-3)
    assert milling(depth=4e-3, step_down=1.0).levels == (-4e-3,)


def test_notes_are_told_once_with_how_often():
    notes = Notes()
    for text in ("a", "b", "a"):
        notes.add(text)
    assert notes.given() == ("a (2 times)", "b")
