"""What is right is not refused: narrow ends, ways that just touch, the same curve in parts."""

from dataclasses import replace

import numpy as np
import pytest

from splinearm.curves.bspline import BSpline
from splinearm.curves.interpolation import interpolate
from splinearm.toolpaths.action import ArcFeed, Feed, SplineFeed
from splinearm.toolpaths.checking import verified
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.drawing import Drawing, Drawn
from splinearm.toolpaths.operation import Entry
from splinearm.toolpaths.piece import LinePiece, SplinePiece
from splinearm.toolpaths.tab import Tabs
from splinearm.toolpaths.work import Exactness, Kind, Work, carry_out

MM = 1e-3
TOLERANCE = 1e-5


def drawing(*pieces):
    drawn = tuple(Drawn(piece, "cut") for piece in pieces)
    return Drawing(file="part.dxf", unit="mm", drawn=drawn, left_out={})


@pytest.fixture(scope="module")
def wing():
    """Give the section of a wing: a spline with a narrow end that a line closes."""
    x = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, 40)))
    thick = 0.3 * (0.2969 * x**0.5 - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1015 * x**4)
    bent = 5.0 / 120.0 * np.sin(np.pi * x)
    up, low = (np.stack((x, bent + side * thick), axis=1) * 0.12 for side in (1.0, -1.0))
    curve = interpolate(np.vstack((up[::-1], low[1:])))
    assert isinstance(curve, BSpline)
    return drawing(SplinePiece(curve), LinePiece(curve.points[-1], curve.points[0]))


@pytest.mark.parametrize(
    ("kind", "changes", "splines"),
    [
        (Kind.POCKET, {"depth": 3 * MM}, True),
        (Kind.POCKET, {"stock": 0.2 * MM}, False),
        pytest.param(Kind.ZIGZAG, {"stock": 0.2 * MM}, False, marks=pytest.mark.slow),
        pytest.param(Kind.SPIRAL, {"step_over": 4 * MM}, True, marks=pytest.mark.slow),
    ],
)
def test_what_a_cutter_reaches_only_nearer_to_walls_than_asked_may_stay(
    kind, changes, splines, wing, milling
):
    # where it is as wide as the cutter, a ring a micrometre farther in ends much earlier
    work = Work(kind=kind, milling=milling(**changes))
    actions, done = carry_out(wing, [work], Exactness(tolerance=TOLERANCE, splines=splines))
    report = verified(actions, done, TOLERANCE)
    assert report.ok, report.text()
    assert report.unreachable > 10 * MM
    gone = [
        a for a in actions if not (isinstance(a, SplineFeed | ArcFeed | Feed) and a.end[0] < 0.05)
    ]
    assert {fault.kind for fault in verified(gone, done, TOLERANCE).faults} >= {"left over"}


def test_a_curve_in_parts_cuts_no_deeper_than_the_whole(wing, milling):
    work = Work(
        kind=Kind.PROFILE,
        milling=milling(depth=3 * MM, entry=Entry.RAMP, lead=2 * MM),
        tabs=Tabs(count=3, length=5 * MM, height=1 * MM),
    )
    actions, done = carry_out(wing, [work], Exactness(tolerance=TOLERANCE))
    report = verified(actions, done, TOLERANCE)
    assert report.ok, report.text()
    # without the first pass the second takes all at once
    deep = [a for a in actions if not (isinstance(a, SplineFeed) and a.start[2] == -1.5 * MM)]
    kinds = {fault.kind for fault in verified(deep, done, TOLERANCE).faults}
    assert "step down" in kinds


def test_ways_that_just_touch_leave_nothing_between_them(milling):
    slots = [Contour.rectangle([k * 25 * MM, 0.0], [20 * MM, 8 * MM], 4 * MM) for k in range(3)]
    disc = Contour.circle([30 * MM, 40 * MM], 18 * MM)
    drawn = drawing(*(piece for c in (*slots, disc) for piece in c.pieces()))
    work = Work(kind=Kind.POCKET, milling=milling(depth=3 * MM, step_over=4 * MM))
    actions, done = carry_out(drawn, [work])
    report = verified(actions, done, TOLERANCE)
    assert report.ok, report.text()
    # what is left standing is found as before
    less = [a for a in actions if not isinstance(a, ArcFeed)]
    assert "standing" in {fault.kind for fault in verified(less, done, TOLERANCE).faults}


def test_a_hole_is_drilled_deeper_than_a_pass_may_be(milling):
    drawn = drawing(*Contour.circle([0.0, 0.0], 2 * MM).pieces())
    own = milling(depth=6 * MM)
    actions, done = carry_out(drawn, [Work(kind=Kind.DRILL, milling=own)])
    report = verified(actions, done, TOLERANCE)
    assert report.ok, report.text()
    quicker = [replace(a, feed=2.0 * a.feed) if isinstance(a, Feed) else a for a in actions]
    assert {fault.kind for fault in verified(quicker, done, TOLERANCE).faults} == {"plunge"}
