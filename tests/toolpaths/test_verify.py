"""Verification: what is right passes, and each thing that is wrong is named with its place."""

import json
from dataclasses import replace
from math import pi, sqrt, tan

import numpy as np
import pytest

from splinearm.curves.bspline import BSpline
from splinearm.toolpaths.action import ArcFeed, Feed, Rapid, SplineFeed, ToolChange
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.cutter import Cutter, Tip
from splinearm.toolpaths.gcode_dialect import DIALECTS
from splinearm.toolpaths.gcode_machine import NcMachine, NcTool
from splinearm.toolpaths.gcode_writer import write_gcode
from splinearm.toolpaths.offset import offset, rings
from splinearm.toolpaths.piece import LinePiece
from splinearm.toolpaths.region import Region
from splinearm.toolpaths.stock import Stock
from splinearm.toolpaths.verify import Allowance, verify, verify_file
from splinearm.toolpaths.verify_part import Task, Zone
from splinearm.toolpaths.verify_way import track_of

pytestmark = pytest.mark.kernel

MM = 1e-3
MILL = Cutter(
    number=1, name="mill", diameter=6 * MM, feed=0.02, plunge=0.005, step_down=2 * MM,
    step_over=2.4 * MM, cutting_length=20 * MM,
)  # fmt: skip
PLATE = Region(Contour.rectangle([0, 0], [50 * MM, 30 * MM], 4 * MM))
HOLED = Region(PLATE.outer, (Contour.circle([25 * MM, 15 * MM], 4 * MM),))
COARSE = Allowance(cell=0.4 * MM)


class Pen:
    """Writes moves one after the other."""

    def __init__(self, safe=5 * MM):
        self.moves, self.at, self.safe = [], np.array([0.0, 0.0, safe]), safe

    def rapid(self, *end):
        self.moves.append(Rapid(start=self.at, end=np.array(end), line=len(self.moves) + 1))
        self.at = self.moves[-1].end

    def feed(self, *end, feed=0.02):
        here = len(self.moves) + 1
        self.moves.append(Feed(start=self.at, end=np.array(end), feed=feed, line=here))
        self.at = self.moves[-1].end

    def around(self, contour, z, plunge=0.005, feed=0.02):
        self.rapid(*contour.vertices[0], self.safe)
        self.feed(*contour.vertices[0], z, feed=plunge)
        for piece in contour.pieces():
            end = np.array([*piece.end, z])
            if isinstance(piece, LinePiece):
                self.feed(*end, feed=feed)
                continue
            centre = np.array([*piece.centre, z])
            self.moves.append(
                ArcFeed(start=self.at, end=end, centre=centre, axis=2, turn=piece.turn,
                        feed=feed, line=len(self.moves) + 1)
            )  # fmt: skip
            self.at = end
        self.rapid(*self.at[:2], self.safe)


def profile(off=3 * MM, levels=(-2 * MM, -4 * MM), **keywords):
    pen = Pen()
    for z in levels:
        for region in offset(PLATE, off):
            pen.around(region.outer, z, **keywords)
    return pen.moves


def cleared(part, off=3 * MM, levels=(-2 * MM,), step=2.4 * MM, most=99):
    pen = Pen()
    steps = [-(off + k * step) for k in range(most)]
    for z in levels:
        for regions in rings(part, steps):
            for contour in [c for region in regions for c in region.contours]:
                pen.around(contour, z)
            if not regions:
                break
    return pen.moves


def block(thick=10 * MM, margin=8 * MM):
    return Stock.about(PLATE, margin=margin, thick=thick)


def outside(**keywords):
    zone = {"regions": (PLATE,), "floor": -4 * MM, "side": "outside", "cleared": False, **keywords}
    return Task(block(), (Zone(**zone),))


def inside(part=HOLED, floor=-2 * MM):
    return Task(block(), (Zone(regions=(part,), floor=floor),))


def kinds(found):
    return {fault.kind for fault in found.faults}


def only(found, kind):
    (fault,) = found.faults
    assert fault.kind == kind, found.text()
    return fault


def test_a_profile_that_is_right_passes():
    found = verify(profile(), outside(), MILL, COARSE)
    assert found.ok, found.text()
    assert abs(found.gouge) < 1e-14
    assert found.left < 1e-14
    assert found.unreachable == 0.0
    around = PLATE.length * 6 * MM + pi * (6 * MM) ** 2  # Minkowski: a band as wide as the cutter
    assert found.removed == pytest.approx(around * 4 * MM, rel=3e-3)
    assert "verified" in found.text()
    assert json.loads(json.dumps(found.document()))["ok"] is True


def test_a_pocket_that_is_right_passes_and_its_corners_are_not_held_against_it():
    found = verify(cleared(HOLED), inside(), MILL, COARSE)
    assert found.ok, found.text()
    assert found.unreachable == 0.0
    sharp = Region(Contour.rectangle([0, 0], [50 * MM, 30 * MM]))
    found = verify(cleared(sharp), inside(sharp), MILL, COARSE)
    assert found.ok, found.text()
    assert 0.8 * MM < found.unreachable < (sqrt(2) - 1) * 3 * MM


@pytest.mark.parametrize("depth", [2e-6, 0.1 * MM, 1.7 * MM])
def test_a_gouge_is_measured_to_rounding(depth):
    fault = verify(profile(3 * MM - depth), outside(), MILL, COARSE).faults[0]
    assert fault.kind == "gouge"
    assert fault.amount == pytest.approx(depth, abs=1e-13)
    assert PLATE.distance(np.array(fault.where[:2])) < 1e-12
    assert "mm into the part" in str(fault)


def test_a_way_across_the_part_is_a_gouge_though_its_ends_are_clear():
    pen = Pen()
    pen.rapid(-6 * MM, 15 * MM, 5 * MM)
    pen.feed(-6 * MM, 15 * MM, -1 * MM, feed=0.005)
    pen.feed(56 * MM, 15 * MM, -1 * MM)
    found = verify(pen.moves, outside(), MILL, COARSE)
    gouge = next(fault for fault in found.faults if fault.kind == "gouge")
    assert gouge.line == 3
    assert gouge.amount > 15 * MM
    assert {"left over", "too low"} < kinds(found)


def test_what_is_not_cut_is_left_over():
    missed = verify(cleared(HOLED, most=2), inside(), MILL, COARSE)
    assert kinds(missed) == {"left over", "standing"}
    short = verify(cleared(HOLED, off=3.05 * MM), inside(), MILL, COARSE)
    assert short.left == pytest.approx(0.05 * MM, abs=1e-12)
    assert kinds(short) == {"left over"}
    kept = Allowance(cell=0.4 * MM, left=0.06 * MM)
    assert verify(cleared(HOLED, off=3.05 * MM), inside(), MILL, kept).ok


def test_a_profile_that_stops_above_its_floor_is_left_over_but_for_tabs():
    moves = profile(levels=(-2 * MM, -3 * MM))
    assert only(verify(moves, outside(), MILL, COARSE), "left over").amount == np.inf
    over = verify(moves, outside(tab_height=1 * MM), MILL, COARSE)
    assert not over.ok  # all of the edge is no tab


def test_a_program_that_cuts_nothing_leaves_all():
    found = verify([], inside(), MILL, COARSE)
    assert only(found, "left over").amount == np.inf
    document = json.loads(json.dumps(found.document(), allow_nan=False))
    assert document["left"] is None


def test_a_way_below_the_floor_is_too_deep():
    found = verify(profile(levels=(-2 * MM, -4 * MM, -4.5 * MM)), outside(), MILL, COARSE)
    assert "too deep" in kinds(found)
    fault = next(fault for fault in found.faults if fault.kind == "too deep")
    assert fault.amount == pytest.approx(0.5 * MM)


def test_rapid_ways_through_material_are_named_and_those_through_air_are_not():
    pen = Pen()
    pen.rapid(-3 * MM, 5 * MM, 5 * MM)
    pen.rapid(-3 * MM, 5 * MM, -1 * MM)
    found = verify(pen.moves, Task(block()), MILL, COARSE)
    fault = only(found, "rapid")
    assert (fault.line, fault.amount) == (2, pytest.approx(1 * MM))
    pen = Pen()
    pen.rapid(-3 * MM, 5 * MM, 5 * MM)
    pen.feed(-3 * MM, 5 * MM, -1 * MM, feed=0.005)
    pen.feed(-3 * MM, 25 * MM, -1 * MM)
    pen.rapid(-3 * MM, 5 * MM, -1 * MM)  # back through what was cut
    assert verify(pen.moves, Task(block()), MILL, COARSE).ok


@pytest.mark.parametrize(
    ("keywords", "kind"),
    [
        ({"plunge": 0.01}, "plunge"),
        ({"feed": 0.05}, "feed"),
        ({"levels": (-4 * MM,)}, "step down"),
    ],
)
def test_feeds_and_steps_beyond_the_cutter_s_are_named(keywords, kind):
    found = verify(profile(**keywords), outside(), MILL, COARSE)
    assert only(found, kind).line > 0


def test_a_cutter_that_is_too_short_is_named():
    short = replace(MILL, cutting_length=3 * MM)
    found = verify(profile(), outside(), short, COARSE)
    assert only(found, "cutting length").amount == pytest.approx(1 * MM)


def test_ramps_and_helices_cut_what_they_should():
    pen = Pen()
    pen.rapid(25 * MM + 3 * MM, 15 * MM, 1 * MM)
    centre = np.array([25 * MM, 15 * MM, 1 * MM])
    end = np.array([28 * MM, 15 * MM, -2 * MM])
    pen.moves.append(
        ArcFeed(start=pen.at, end=end, centre=centre, axis=2, turn=6 * pi, feed=0.005, line=2)
    )
    pen.at = end
    circle = Contour.circle([25 * MM, 15 * MM], 3 * MM)
    pen.moves += [
        ArcFeed(start=end, end=end, centre=centre, axis=2, turn=2 * pi, feed=0.02, line=3)
    ]
    hole = Region(Contour.circle([25 * MM, 15 * MM], 6 * MM))
    assert circle.length > 0
    found = verify(pen.moves, inside(hole), MILL, COARSE)
    assert found.ok, found.text()
    small = Region(Contour.circle([25 * MM, 15 * MM], 5.9 * MM))
    found = verify(pen.moves, inside(small), MILL, COARSE)
    assert next(f for f in found.faults if f.kind == "gouge").amount == pytest.approx(0.1 * MM)


def test_a_ramp_is_looked_at_below_the_surface_only():
    # it comes over the part in the air and is clear of it where it dips in
    pen = Pen()
    pen.rapid(10 * MM, 15 * MM, 2 * MM)
    pen.feed(-14 * MM, 15 * MM, -1 * MM, feed=0.005)
    found = verify(pen.moves, outside(floor=-1 * MM), MILL, COARSE)
    assert "gouge" not in kinds(found), found.text()
    pen = Pen()
    pen.rapid(10 * MM, 15 * MM, 1 * MM)
    pen.feed(-14 * MM, 15 * MM, -1 * MM, feed=0.005)
    found = verify(pen.moves, outside(floor=-1 * MM), MILL, COARSE)
    assert next(f for f in found.faults if f.kind == "gouge").amount > 0.5 * MM


@pytest.mark.parametrize("tip", [Tip.BALL, Tip.POINT])
def test_other_tips_cut_as_wide_as_they_are_deep(tip):
    cutter = replace(MILL, tip=tip, tip_angle=pi / 2 if tip is Tip.POINT else pi)
    pen = Pen()
    pen.rapid(5 * MM, 15 * MM, 5 * MM)
    pen.feed(5 * MM, 15 * MM, -1 * MM, feed=0.005)
    pen.feed(45 * MM, 15 * MM, -1 * MM)
    half = cutter.radius_at(1 * MM)
    assert half == pytest.approx(1 * MM * (tan(pi / 4) if tip is Tip.POINT else sqrt(5)))
    for off, ok in ((1e-7, True), (-1e-5, False)):
        slot = Contour.rectangle(
            [0, 15 * MM - half - off], [50 * MM, 2 * (half + off)],
        )  # fmt: skip
        task = Task(block(), (Zone(regions=(Region(slot),), floor=-1 * MM, cleared=False),))
        found = verify(pen.moves, task, cutter, Allowance(cell=0.2 * MM, left=1.0))
        assert ("gouge" not in kinds(found)) is ok, found.text()
    left = found.map
    row = round((15 * MM - left.corner[1]) / left.cell)
    line = left.heights[row - 12 : row + 13, left.heights.shape[1] // 2]
    off = left.corner[1] + left.cell * np.arange(row - 12, row + 13) - 15 * MM
    rise = np.abs(off) if tip is Tip.POINT else 3 * MM - np.sqrt(9 * MM**2 - off**2)
    np.testing.assert_allclose(line, np.minimum(0.0, -1 * MM + rise), atol=1e-12)


def test_a_pocket_in_a_pocket_has_two_floors():
    inner = Region(Contour.rectangle([15 * MM, 8 * MM], [20 * MM, 14 * MM], 3 * MM))
    zones = (
        Zone(regions=(PLATE,), floor=-2 * MM),
        Zone(regions=(inner,), floor=-4 * MM),
    )
    moves = cleared(PLATE) + cleared(inner, levels=(-4 * MM,))
    found = verify(moves, Task(block(), zones), MILL, COARSE)
    assert found.ok, found.text()
    wide = cleared(PLATE) + cleared(inner, off=2.5 * MM, levels=(-4 * MM,))
    found = verify(wide, Task(block(), zones), MILL, COARSE)
    assert next(f for f in found.faults if f.kind == "gouge").amount == pytest.approx(0.5 * MM)


def test_two_zones_may_have_one_edge():
    zones = (
        Zone(regions=(PLATE,), floor=-2 * MM),
        Zone(regions=(PLATE,), floor=-4 * MM, cleared=False),
    )
    moves = cleared(PLATE)
    pen = Pen()
    pen.around(offset(PLATE, -3 * MM)[0].outer, -4 * MM)
    found = verify(moves + pen.moves, Task(block(), zones), MILL, COARSE)
    assert kinds(found) <= {"step down"}, found.text()


def test_each_way_is_measured_with_the_tool_that_goes_it():
    small = replace(MILL, number=2, diameter=3 * MM, step_over=1.2 * MM)
    sharp = Region(Contour.rectangle([0, 0], [50 * MM, 30 * MM], 1.5 * MM))
    pen = Pen()
    pen.around(offset(sharp, -1.5 * MM)[0].outer, -2 * MM)
    change = [ToolChange(tool=1)], [ToolChange(tool=2)]
    moves = [*change[0], *cleared(sharp), *change[1], *pen.moves]
    found = verify(moves, inside(sharp), {1: MILL, 2: small}, COARSE)
    assert found.ok, found.text()
    assert found.unreachable == 0.0
    swapped = [*change[1], *cleared(sharp), *change[0], *pen.moves]
    assert "gouge" in kinds(verify(swapped, inside(sharp), {1: MILL, 2: small}, COARSE))
    with pytest.raises(ValueError, match="number 3; there are 1, 2"):
        verify([ToolChange(tool=3), *moves], inside(), {1: MILL, 2: small})


def test_splines_are_followed_to_a_nanometre():
    points = np.array([[-9, -8, -1], [20, -30, -1], [40, 40, -1], [70, -9, -1]]) * MM
    curve = BSpline(np.array([0, 0, 0, 0, 1, 1, 1, 1.0]), points, 3)
    way = SplineFeed(start=points[0], end=points[-1], curve=curve, feed=0.02)
    track = track_of([way])
    assert track.bound <= 1e-9
    from splinearm.toolpaths.verify_kernel import gaps

    places = np.ascontiguousarray(curve.at(np.linspace(0.0, 1.0, 1001))[:, :2])
    far = np.empty(len(places))
    gaps(track.pieces, places, 0.0, far)
    assert far.max() <= 1e-9


def test_a_written_program_is_verified_from_its_file(tmp_path):
    file = tmp_path / "part.ngc"
    file.write_text(write_gcode([ToolChange(tool=1), *profile()], DIALECTS["linuxcnc"], "part"))
    machine = NcMachine(tools={1: NcTool(diameter=6 * MM)})
    found = verify_file(file, outside(), {1: MILL}, COARSE, machine=machine)
    assert found.ok, found.text()
    assert abs(found.gouge) < 5e-9
    found = verify_file(
        file, outside(), {1: MILL}, COARSE, machine=machine, dialect=DIALECTS["grbl"]
    )
    assert kinds(found) == {"dialect"}


def test_compensated_ways_are_verified_where_the_tool_goes(tmp_path):
    file = tmp_path / "part.ngc"
    text = "G21 G90 F300\nG0 X-20 Y-20 Z5\nG1 Z{z} F200\nG41.1 D{d} G1 X0 Y-10 F1000\nY30\nX50\n"
    file.write_text((text + "Y0\nX-10\nG40 G1 X-20\nG0 Z5\nM2\n").format(z=-2, d=6))
    square = Region(Contour.rectangle([0, 0], [50 * MM, 30 * MM]))
    zone = Zone(regions=(square,), floor=-2 * MM, side="outside", cleared=False)
    task = Task(Stock.about(square, margin=8 * MM, thick=5 * MM), (zone,))
    found = verify_file(file, task, MILL, COARSE)
    assert found.ok, found.text()
    wide = replace(MILL, diameter=6.4 * MM)
    found = verify_file(file, task, wide, COARSE)
    assert next(f for f in found.faults if f.kind == "gouge").amount == pytest.approx(0.2 * MM)


def test_ways_that_are_marked_or_without_a_tool_are_refused():
    marked = [replace(move, side=1, radius=1e-3) for move in profile() if isinstance(move, Feed)]
    with pytest.raises(ValueError, match="marked"):
        verify(marked, outside(), MILL)
    with pytest.raises(ValueError, match="before a tool"):
        verify(profile(), outside(), {1: MILL, 2: MILL})


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Stock([0, 0, 0], [1, 1, 0]), "high"),
        (lambda: Zone(regions=(), floor=0.0), "regions"),
        (lambda: Zone(regions=(PLATE,), floor=np.nan), "floor"),
        (lambda: Zone(regions=(PLATE,), floor=0.0, side="left"), "side"),
        (lambda: Zone(regions=(PLATE,), floor=0.0, side="outside"), "cleared"),
        (lambda: Zone(regions=(PLATE,), floor=0.0, tab_height=-1.0), "tab_height"),
        (lambda: Task(block(), (Zone(regions=(PLATE,), floor=0.0),)), "below the surface"),
    ],
)
def test_what_makes_no_sense_is_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()
