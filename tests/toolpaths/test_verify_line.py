"""Verification of what goes on lines, and of facing, whose cutter goes beyond the edges."""

from dataclasses import replace

import numpy as np
import pytest

from splinearm.toolpaths.action import Feed, Rapid
from splinearm.toolpaths.checking import verified
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.drawing import Drawing, Drawn
from splinearm.toolpaths.operation import Side
from splinearm.toolpaths.piece import ArcPiece, LinePiece
from splinearm.toolpaths.tab import Tabs
from splinearm.toolpaths.verify_line import Lines
from splinearm.toolpaths.work import Kind, Work, carry_out

pytestmark = pytest.mark.kernel

MM = 1e-3


@pytest.fixture
def drawing():
    """A plate, a pocket in it, and a line with an arc at its end."""
    drawn = []
    for layer, contour in (
        ("outline", Contour.rectangle([0, 0], [60 * MM, 40 * MM], 5 * MM)),
        ("pocket", Contour.rectangle([10 * MM, 10 * MM], [30 * MM, 30 * MM], 4 * MM)),
    ):
        drawn += [Drawn(piece, layer) for piece in contour.pieces()]
    line = LinePiece(np.array([35, 10]) * MM, np.array([50, 10]) * MM)
    arc = ArcPiece.about(np.array([50, 15]) * MM, 5 * MM, -0.5 * np.pi, np.pi)
    drawn += [Drawn(piece, "mark") for piece in (line, replace(arc, start=line.end))]
    return Drawing(file="plate.dxf", unit="mm", drawn=tuple(drawn), left_out={})


@pytest.fixture
def engraved(drawing, milling):
    work = Work(kind=Kind.ENGRAVE, milling=milling(depth=0.5 * MM), layers=("mark",))
    return carry_out(drawing, [work])


def kinds(report):
    return {fault.kind for fault in report.faults}


def shifted(action, by):
    """Give a way that was shifted; others stay."""
    if isinstance(action, Feed):
        return replace(action, start=action.start + by, end=action.end + by)
    return action


def test_what_is_engraved_on_its_lines_passes(engraved):
    report = verified(*engraved, 1e-5)
    assert report.ok, report.text()
    assert report.left <= 1e-9
    assert report.removed > 0.0


@pytest.mark.parametrize("off", [5e-6, 1 * MM])
def test_a_way_beside_its_line_gouges_and_leaves_the_line(engraved, off):
    actions, done = engraved
    wrong = [shifted(a, np.array([0.0, -off, 0.0])) for a in actions]
    report = verified(wrong, done, 1e-5)
    assert kinds(report) >= {"gouge", "left over"}
    (missed,) = [fault for fault in report.faults if fault.kind == "left over"]
    assert missed.amount == pytest.approx(off, rel=1e-6)
    assert missed.where[1] == pytest.approx(10 * MM, abs=0.1 * MM)


def test_a_way_too_deep_or_not_deep_enough_is_named(engraved):
    actions, done = engraved
    for by, kind in ((-0.1 * MM, "too deep"), (0.1 * MM, "left over")):
        lower = [shifted(a, np.array([0.0, 0.0, by])) for a in actions]
        assert kind in kinds(verified(lower, done, 1e-5))


def test_a_line_that_is_forgotten_is_named(engraved):
    actions, done = engraved
    report = verified([a for a in actions if isinstance(a, Rapid)], done, 1e-5)
    assert any("no cut" in fault.says for fault in report.faults)
    assert report.document()["left"] is None


def test_a_mark_in_a_pocket_on_a_faced_plate_is_right_and_all_three_are_looked_at(drawing, milling):
    face = Work(kind=Kind.FACING, milling=milling(depth=1 * MM), layers=("outline",), angle=0.4)
    pocket = Work(kind=Kind.POCKET, milling=milling(depth=2 * MM, top=-1 * MM), layers=("pocket",))
    mark = Work(kind=Kind.ENGRAVE, milling=milling(depth=0.3 * MM, top=-1 * MM), layers=("mark",))
    actions, done = carry_out(drawing, [face, pocket, mark])
    report = verified(actions, done, 1e-5)
    assert report.ok, report.text()
    only_faced, faced = carry_out(drawing, [face])
    half = [a for a in only_faced if not isinstance(a, Feed) or a.start[1] < 20 * MM]
    assert kinds(verified(half, faced, 1e-5)) >= {"left over", "standing"}
    deeper = [shifted(a, np.array([0.0, 0.0, -1e-5])) for a in only_faced]
    assert "too deep" in kinds(verified(deeper, faced, 1e-5))


def test_a_profile_on_the_line_may_leave_tabs(drawing, milling):
    work = Work(kind=Kind.PROFILE, milling=milling(depth=3 * MM), layers=("outline",), side=Side.ON)
    tabs = replace(work, tabs=Tabs(count=3, length=3 * MM, height=1 * MM))
    for one in (work, tabs):
        actions, done = carry_out(drawing, [one])
        report = verified(actions, done, 1e-5)
        assert report.ok, report.text()
    assert "left over" in kinds(verified(actions, carry_out(drawing, [work])[1], 1e-5))


def test_lines_that_make_no_sense_are_refused(milling):
    with pytest.raises(ValueError, match="at least one"):
        Lines(wires=(), floor=0.0, cutter=milling().cutter)
