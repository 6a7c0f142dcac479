"""Pockets along splines: rings that are splines, no gouge, nothing uncut, written as such."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from splinearm.curves.bspline import BSpline
from splinearm.toolpaths.action import ArcFeed, Feed, Rapid, SplineFeed
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.drawing import Drawing, Drawn
from splinearm.toolpaths.operation import Entry
from splinearm.toolpaths.piece import SplinePiece
from splinearm.toolpaths.shape import ellipse_piece
from splinearm.toolpaths.work import Exactness, Kind, Work, carry_out

TOLERANCE = 1e-5
RADIUS = 2e-3
KINDS = (Kind.POCKET, Kind.ZIGZAG, Kind.SPIRAL)


def ring(radius, count):
    a = 2.0 * pi * np.arange(count) / count
    points = 1e-3 * radius(a)[:, None] * np.stack((np.cos(a), np.sin(a)), axis=1)
    return SplinePiece(BSpline.closed(np.linspace(0.0, 1.0, count + 1), points, 3))


def oval(size):
    middle = np.array([0.03, 0.02])
    axes = np.array([size, 0.0]), np.array([0.0, 0.667 * size])
    return ellipse_piece(middle, *axes, 0.0, 2.0 * pi)


def drawing(*pieces):
    drawn = tuple(Drawn(piece, "cut") for piece in pieces)
    return Drawing(file="part.dxf", unit="mm", drawn=drawn, left_out={})


DRAWINGS = {
    "oval": drawing(oval(0.018)),
    "island": drawing(oval(0.018), oval(0.006)),
    "clover": drawing(ring(lambda a: 14.0 + 6.0 * np.cos(3.0 * a), 12)),
}


def cleared(drawn, milling, kind, splines=True):
    work = Work(kind=kind, milling=milling, angle=0.3)
    return carry_out(drawn, [work], Exactness(tolerance=TOLERANCE, splines=splines))


def gap(places, drawn):
    curves = [each.piece.curve for each in drawn.drawn]
    looks = np.vstack([curve.at(np.linspace(*curve.domain, 4001)) for curve in curves])
    return np.array([np.hypot(*(looks - place).T).min() for place in places])


WIDE = {"step_over": 2.0 * RADIUS, "climb": False, "entry": Entry.RAMP}
SHORT = {("oval", Kind.SPIRAL, 0), ("island", Kind.POCKET, 1), ("clover", Kind.ZIGZAG, 1)}


@pytest.mark.parametrize(
    ("name", "kind", "changes"),
    [
        pytest.param(
            name, kind, changes, marks=() if (name, kind, k) in SHORT else pytest.mark.slow
        )
        for name in DRAWINGS
        for kind in KINDS
        for k, changes in enumerate(({}, WIDE))
    ],
)
def test_it_is_cleared_along_splines_and_not_gouged(name, kind, changes, milling, proven):
    actions, done = cleared(DRAWINGS[name], milling(**changes), kind)
    assert done[0].slack <= 0.01 * TOLERANCE
    proven(actions, done, TOLERANCE)
    assert not any("arcs" in note for note in done[0].milled.notes)
    places = np.vstack(
        [
            action.curve.at(np.linspace(*action.curve.domain, 30))[:, :2]
            for action in actions
            if isinstance(action, SplineFeed)
        ]
    )
    far = gap(places, DRAWINGS[name])
    # looks are up to 0.03 mm apart: that is up to 0.06 um too far
    assert RADIUS - 1e-9 <= far.min() <= RADIUS + TOLERANCE + 1e-7


def test_all_that_is_level_is_splines_and_links(milling):
    actions, _ = cleared(DRAWINGS["oval"], milling(), Kind.POCKET)
    arcs, _ = cleared(DRAWINGS["oval"], milling(), Kind.POCKET, splines=False)
    assert not any(isinstance(action, ArcFeed) for action in actions)
    cuts = [a for a in actions if isinstance(a, SplineFeed | Feed)]
    assert len(cuts) < 0.4 * sum(isinstance(a, ArcFeed | Feed) for a in arcs)
    lengths = [sum(a.length for a in own if not isinstance(a, Rapid) and hasattr(a, "length"))
               for own in (actions, arcs)]  # fmt: skip
    assert lengths[0] == pytest.approx(lengths[1], rel=1e-3)


@pytest.mark.parametrize(
    "kind", [Kind.ZIGZAG, *(pytest.param(k, marks=pytest.mark.slow) for k in KINDS[::2])]
)
def test_stock_is_taken_off_along_the_splines(kind, milling, proven):
    setting = milling(depth=4e-3, stock=3e-4, finish=True, lead=1e-3, entry=Entry.HELIX)
    drawn = DRAWINGS["island"]
    actions, done = cleared(drawn, setting, kind)
    assert done[0].slack <= 0.01 * TOLERANCE
    proven(actions, done, TOLERANCE)
    ways = [a for a in actions if isinstance(a, SplineFeed)]
    rough = [w for w in ways if w.start[2] == -2e-3]
    nearest = [
        gap(np.vstack([w.curve.at(np.linspace(*w.curve.domain, 30))[:, :2] for w in own]), drawn)
        for own in (rough, ways)
    ]
    assert nearest[0].min() == pytest.approx(RADIUS + 3e-4, abs=2e-5)
    assert nearest[1].min() == pytest.approx(RADIUS, abs=2e-5)
    assert actions[-3].end[2] > 0.0


def test_what_has_no_splines_is_as_exact_as_ever(milling, proven):
    square = Contour.rectangle([0.06, 0.0], [0.02, 0.02]).pieces()
    drawn = drawing(oval(0.018), *square)
    actions, done = cleared(drawn, milling(), Kind.POCKET)
    assert done[0].slack <= 0.01 * TOLERANCE
    proven(actions, done, TOLERANCE)
    x = [a.end[0] for a in actions if isinstance(a, Feed) and a.end[0] > 0.055]
    # lines beside lines are not moved by what is allowed for splines
    assert min(x) == pytest.approx(0.062, abs=1e-12)
    assert max(x) == pytest.approx(0.078, abs=1e-12)


@pytest.mark.parametrize(
    "kind", [Kind.POCKET, *(pytest.param(k, marks=pytest.mark.slow) for k in KINDS[1:])]
)
def test_where_no_way_along_splines_is_proven_arcs_are_taken(kind, milling, proven):
    # the neck lets the cutter pass by less than the tolerance: rings may join there or not
    bone = ring(lambda a: 8.0 + 5.0 * np.cos(2.0 * a), 16).curve
    looks = bone.at(np.linspace(*bone.domain, 20_001))
    size = (RADIUS + 0.4 * TOLERANCE) / float(np.hypot(*looks.T).min())
    drawn = drawing(SplinePiece(replace(bone, points=bone.points * size)))
    actions, done = cleared(drawn, milling(), kind)
    assert done[0].slack <= 0.01 * TOLERANCE
    proven(actions, done, TOLERANCE)
    assert not any(isinstance(action, SplineFeed) for action in actions)
    assert any("arcs are taken" in note for note in done[0].milled.notes)


def test_what_is_too_narrow_is_told(milling):
    drawn = drawing(oval(0.018), replace(oval(2.5e-3), curve=moved(oval(2.5e-3).curve)))
    for kind in KINDS:
        _, done = cleared(drawn, milling(), kind)
        assert any("too narrow" in note for note in done[0].milled.notes)


def moved(curve):
    return replace(curve, points=curve.points + np.array([0.06, 0.0]))


def test_linuxcnc_takes_pockets_along_splines(milling, tmp_path, rs274, proven):
    setting = milling(depth=3e-3, entry=Entry.HELIX, lead=1e-3, stock=2e-4, finish=True)
    actions, done = cleared(DRAWINGS["clover"], setting, Kind.POCKET)
    assert done[0].slack <= 0.01 * TOLERANCE
    text = proven(actions, done, TOLERANCE)
    file = tmp_path / "part.ngc"
    file.write_text(text)
    told = rs274(file)
    count = told.stdout.count("NURBS_G5_FEED") + told.stdout.count("NURBS_FEED")
    assert count >= text.count("G5 ") > 10
