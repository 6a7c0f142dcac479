"""Drilling and engraving."""

from math import pi

import numpy as np
import pytest

from splinearm.curves.bspline import BSpline
from splinearm.toolpaths.action import ArcFeed, Feed, Rapid, SplineFeed
from splinearm.toolpaths.drill import drill
from splinearm.toolpaths.engrave import engrave
from splinearm.toolpaths.gcode_check import write_checked
from splinearm.toolpaths.gcode_dialect import DIALECTS
from splinearm.toolpaths.joining import joined_program
from splinearm.toolpaths.piece import ArcPiece, LinePiece, SplinePiece
from splinearm.toolpaths.wire import Wire

SPOTS = np.array([[0.01, 0.0], [0.03, 0.02], [0.01, 0.02], [0.03, 0.0]])


def test_every_hole_is_drilled_once_to_its_depth(milling, follows):
    milled = drill(SPOTS, milling(depth=7e-3))
    follows(milled.actions)
    ways = [a for a in milled.actions if isinstance(a, Feed)]
    assert len(ways) == 4
    assert {tuple(way.end) for way in ways} == {(x, y, -7e-3) for x, y in SPOTS}
    assert {way.feed for way in ways} == {0.005}
    travel = [a.end for a in milled.actions if isinstance(a, Rapid) and a.start[2] == a.end[2]]
    steps = np.linalg.norm(np.diff(np.array(travel), axis=0), axis=1)
    assert steps.sum() == pytest.approx(0.06)


@pytest.mark.parametrize("peck", [1e-3, 2e-3, 3e-3, 9e-3])
def test_a_drill_comes_out_after_each_peck(peck, milling, follows):
    milled = drill(SPOTS[:1], milling(depth=7e-3), peck)
    follows(milled.actions)
    ways = [a for a in milled.actions if isinstance(a, Feed)]
    depths = [way.end[2] for way in ways]
    assert depths[-1] == -7e-3
    assert (np.diff([0.0, *depths]) >= -peck * (1 + 1e-9)).all()
    # it goes rapidly to just above what is left, never into it
    for before, way in zip([0.0, *depths], ways, strict=False):
        assert way.start[2] == pytest.approx(before + 0.5e-3)
    for dialect in DIALECTS.values():
        assert write_checked(milled.actions, dialect)


def test_a_hole_at_the_origin_is_come_to_from_straight_above(milling, follows):
    deep = milling(top=-3e-3)
    first = [(deep.cutter, drill([[0.02, 0.01]], deep))] * 2
    for parts in (first[:0], first):
        actions = joined_program([*parts, (deep.cutter, drill([[0.0, 0.0]], deep))])
        follows(actions)
        text = write_checked(actions, DIALECTS["grbl"]).splitlines()
        for line in text:
            assert not ("Z" in line and ("X" in line or "Y" in line)), line
    # also where the cutter is above the material already
    low = milling(safe=4e-4)
    assert joined_program([(low.cutter, drill([[0.0, 0.0]], low))])


def test_drilling_wants_places(milling):
    with pytest.raises(ValueError, match="points"):
        drill(np.empty((0, 2)), milling())
    with pytest.raises(ValueError, match="peck"):
        drill(SPOTS, milling(), 0.0)


def wires():
    """Give an open wire of a line and an arc, a circle, and an open spline."""
    curve = BSpline(
        np.array([0.0, 0, 0, 0, 1, 1, 1, 1]),
        np.array([[0.05, 0.0], [0.06, 0.02], [0.07, -0.02], [0.08, 0.0]]), 3,
    )  # fmt: skip
    corner = np.array([0.02, 0.0])
    arc = ArcPiece(
        start=corner, end=np.array([0.03, 0.01]), centre=np.array([0.02, 0.01]), turn=pi / 2
    )
    return (
        Wire((LinePiece(np.array([0.01, 0.0]), corner), arc), closed=False),
        Wire((ArcPiece.about(np.array([0.04, 0.03]), 0.005, 0.0, 2 * pi),), closed=True),
        Wire((SplinePiece(curve),), closed=False),
    )


def test_engraving_keeps_lines_arcs_and_splines(milling, follows):
    milled = engrave(wires(), milling(depth=3e-3))
    follows([a for a in milled.actions if not isinstance(a, SplineFeed)][:3])
    kinds = [type(a) for a in milled.actions if isinstance(a, ArcFeed | SplineFeed)]
    # two levels of each
    assert kinds.count(ArcFeed) == 4
    assert kinds.count(SplineFeed) == 2
    place = None
    for action in milled.actions:
        if place is not None:
            np.testing.assert_allclose(action.start, place, atol=1e-15)
        place = action.end
    text = write_checked(milled.actions, DIALECTS["linuxcnc"])
    assert "G5" in text
    assert "G61" in text
    blended = engrave(wires(), milling(depth=3e-3, blend=1e-5))
    assert "G64 P0.01" in write_checked(blended.actions, DIALECTS["linuxcnc"])


def test_engraving_runs_each_wire_from_the_nearer_end(milling):
    far = Wire((LinePiece(np.array([0.05, 0.0]), np.array([0.01, 0.0])),), closed=False)
    milled = engrave([far], milling(depth=1e-3))
    ways = [a for a in milled.actions if isinstance(a, Feed) and a.start[2] == a.end[2]]
    np.testing.assert_array_equal(ways[0].start[:2], [0.01, 0.0])
    with pytest.raises(ValueError, match="wires"):
        engrave([], milling())
