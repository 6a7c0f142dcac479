"""Profiles: their sides, leads, tabs, finishing passes and levels."""

import numpy as np
import pytest

from splinearm.errors import GougeError
from splinearm.toolpaths.action import ArcFeed, Feed, Rapid
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.contour_kernel import distances
from splinearm.toolpaths.gcode_check import write_checked
from splinearm.toolpaths.gcode_dialect import DIALECTS
from splinearm.toolpaths.offset import offset
from splinearm.toolpaths.operation import Entry, Side
from splinearm.toolpaths.profile_pass import profile
from splinearm.toolpaths.region import Region
from splinearm.toolpaths.stock import Stock
from splinearm.toolpaths.tab import Tabs
from splinearm.toolpaths.verify import verify
from splinearm.toolpaths.verify_part import Task, Zone

RADIUS = 2e-3
NAMES = ("plate", "islands", "wedge", "bone", "star", "disc")

each_part = pytest.mark.parametrize("name", NAMES)
each_side = pytest.mark.parametrize("side", [Side.OUTSIDE, Side.INSIDE])


def looks(pieces, count=40):
    """Give places along pieces as `arc_kernel` has them."""
    from splinearm.toolpaths.arc_kernel import at_share

    shares = np.linspace(0.0, 1.0, count)
    return np.array([at_share(pieces, i, u) for i in range(len(pieces)) for u in shares])


@each_side
@each_part
@pytest.mark.parametrize("entry", [Entry.PLUNGE, Entry.RAMP])
def test_a_profile_touches_its_part_and_no_more(name, side, entry, parts, milling, checks):
    part = parts[name]
    milled = profile([part], milling(entry=entry, lead=3e-3, depth=3e-3), side)
    checks.follows(milled.actions)
    found = checks.cuts(milled.actions)
    places = looks(found.below(0.0))
    assert part.distance(places).min() >= RADIUS - 1e-10
    assert (part.contains(places) == (side is Side.INSIDE)).all()
    level = looks(found.at(-3e-3))
    touching = part.distance(level) <= RADIUS + 1e-10
    assert touching.mean() > 0.5
    for dialect in DIALECTS.values():
        assert write_checked(milled.actions, dialect)


@each_side
@each_part
def test_all_of_an_edge_is_touched_that_the_cutter_reaches(name, side, parts, milling, cuts):
    part = parts[name]
    milled = profile([part], milling(), side)
    pieces = cuts(milled.actions).at(-2e-3)
    sign = 1.0 if side is Side.INSIDE else -1.0
    for contour in part.contours:
        # beside the middles of segments where a disc of the cutter's size finds room
        middles = looks(contour.packed()[0], 3)[1::3]
        rows = contour.packed()[0]
        chord = rows[:, 2:4] - rows[:, :2]
        normal = np.stack((-chord[:, 1], chord[:, 0]), axis=1)
        normal *= sign / np.linalg.norm(normal, axis=1)[:, None]
        centres = middles + RADIUS * normal
        room = part.distance(centres) >= RADIUS * (1.0 - 1e-9)
        far = np.empty(len(centres))
        distances(pieces, np.ascontiguousarray(centres), far)
        assert room.any()
        assert far[room].max() <= 1e-8


def test_a_cutter_on_the_line_follows_it_in_each_direction(parts, milling, cuts):
    part = parts["islands"]
    for climb in (True, False):
        found = cuts(profile([part], milling(climb=climb), Side.ON).actions)
        assert part.distance(looks(found.at(-2e-3))).max() <= 1e-9
        feeds = {way.feed for way in found.ways if way.start[2] == way.end[2]}
        assert feeds == {0.015}


@each_side
def test_climbing_has_the_part_to_the_right(side, parts, milling):
    (outer,) = (c.outer for c in [parts["plate"]])
    milled = profile([Region(outer)], milling(), side)
    ways = [a for a in milled.actions if isinstance(a, Feed | ArcFeed) and a.start[2] == a.end[2]]
    path = Contour(
        np.array([way.start[:2] for way in ways]),
        np.array([np.tan(0.25 * w.turn) if isinstance(w, ArcFeed) else 0.0 for w in ways]),
    )
    assert (path.area > 0.0) == (side is Side.INSIDE)


def test_openings_are_cut_before_what_holds_them(parts, milling, cuts):
    part = parts["islands"]
    places = looks(cuts(profile([part], milling(), Side.OUTSIDE).actions).at(-2e-3), 3)
    inside = part.outer.contains(places)
    last = np.flatnonzero(inside).max()
    assert inside[: last + 1].all()


def test_tabs_stay(parts, milling, cuts):
    part = parts["plate"]
    tabs = Tabs(count=4, length=4e-3, height=1e-3)
    setting = milling(depth=5e-3, stock=2e-4, finish=True, entry=Entry.RAMP, lead=2e-3)
    milled = profile([part], setting, Side.OUTSIDE, tabs)
    found = cuts(milled.actions)
    low = found.below(-4e-3 - 1e-9)
    # tabs are as long as asked in the middle of the slot, longer at its round ends
    edge = looks(offset(part, RADIUS)[0].outer.packed()[0], 200)
    far = np.empty(len(edge))
    distances(low, edge, far)
    stays = far > RADIUS + 1e-9
    runs = np.flatnonzero(np.diff(np.concatenate(([stays[-1]], stays)).astype(int)) == 1)
    assert len(runs) == 4
    steps = np.hypot(*np.diff(edge, axis=0, append=edge[:1]).T)
    assert float(steps[stays].sum()) == pytest.approx(4 * 4e-3, rel=0.05)
    for way in found.ways:
        if way.start[2] == way.end[2]:
            assert way.end[2] in {-5e-3 / 3, -5e-3 * 2 / 3, -4e-3, -5e-3}
    zone = Zone(regions=(part,), floor=-5e-3, side="outside", cleared=False, tab_height=tabs.height)
    task = Task(Stock.about(part, margin=0.01, thick=0.006), (zone,))
    cutter = setting.cutter
    report = verify(milled.actions, task, cutter)
    assert {fault.kind for fault in report.faults} <= {"step down"}, report.text()


@pytest.mark.parametrize("side", [Side.OUTSIDE, Side.INSIDE])
@pytest.mark.parametrize("turn", [0.1, 0.3, 0.7, 1.1])
def test_tabs_stay_in_the_last_pass_wherever_that_would_begin(side, turn, milling):
    # of sides that are alike rounding says which is the longest, another one in each pass
    angles = 2.0 * np.pi * np.arange(6) / 6 + turn
    part = Region(Contour.polyline(0.03 * np.stack((np.cos(angles), np.sin(angles)), axis=1)))
    setting = milling(stock=2e-4, finish=True, lead=1e-3)
    for count in (1, 3):
        tabs = Tabs(count=count, length=3e-3, height=1e-3)
        milled = profile([part], setting, side, tabs)
        zone = Zone(
            regions=(part,), floor=-2e-3, side=side.value, cleared=False, tab_height=tabs.height
        )
        task = Task(Stock.about(part, margin=0.01, thick=0.006), (zone,))
        report = verify(milled.actions, task, setting.cutter)
        assert report.ok, report.text()


def test_tabs_want_room(parts, milling):
    high = Tabs(count=2, length=2e-3, height=9e-3)
    with pytest.raises(ValueError, match=r"9 mm high in a cut [1-8] mm deep"):
        profile([parts["disc"]], milling(), Side.OUTSIDE, high)
    with pytest.raises(ValueError, match="have no room"):
        profile([parts["disc"]], milling(), Side.OUTSIDE, Tabs(count=9, length=9e-3, height=1e-3))
    for facts in ((0, 1.0, 1.0), (1, 0.0, 1.0), (1, 1.0, -1.0)):
        with pytest.raises(ValueError, match="want"):
            Tabs(count=facts[0], length=facts[1], height=facts[2])


def test_leads_become_smaller_where_there_is_no_room(parts, milling):
    slit = Region(Contour.rectangle([0.0, 0.0], [0.03, 4.4e-3]))
    milled = profile([slit], milling(lead=3e-3), Side.INSIDE)
    assert any("no room for a lead-in of 3 mm" in note for note in milled.notes)
    tight = Region(Contour.rectangle([0.0, 0.0], [0.03, 4.001e-3]))
    assert any("no room" in n for n in profile([tight], milling(lead=3e-3), Side.INSIDE).notes)
    free = profile([parts["plate"]], milling(lead=3e-3), Side.OUTSIDE)
    assert not free.notes


def test_parts_nearer_to_each_other_than_the_cutter_are_refused(parts, milling):
    plate = parts["plate"]
    near = plate.transformed(shift=[0.063, 0.0])
    with pytest.raises(GougeError, match="smaller"):
        profile([plate, near], milling(), Side.OUTSIDE)
    far = plate.transformed(shift=[0.0645, 0.0])
    assert profile([plate, far], milling(), Side.OUTSIDE).actions


def test_openings_too_narrow_are_told(milling):
    part = Region(
        Contour.rectangle([0.0, 0.0], [0.05, 0.03]),
        (Contour.circle([0.01, 0.015], 1.5e-3), Contour.circle([0.03, 0.015], 4e-3)),
    )
    (note,) = profile([part], milling(), Side.OUTSIDE).notes
    assert "(10, 15) mm is too narrow" in note
    (note,) = profile([Region(part.islands[0])], milling(), Side.INSIDE).notes
    assert "too narrow" in note


def test_a_profile_goes_from_level_to_level_without_lifting(parts, milling):
    milled = profile([parts["plate"]], milling(depth=6e-3), Side.OUTSIDE)
    rapids = [a for a in milled.actions if isinstance(a, Rapid)]
    assert len(rapids) == 4  # up, over, down and up again
    with pytest.raises(ValueError, match="parts"):
        profile([], milling(), Side.OUTSIDE)


@pytest.mark.parametrize("radius", [3e-3, 6e-3])
def test_openings_have_as_many_tabs_as_have_room(radius, milling, cuts):
    part = Region(
        Contour.rectangle([0.0, 0.0], [0.06, 0.04], 0.004), (Contour.circle([0.02, 0.02], radius),)
    )
    tabs = Tabs(count=3, length=4e-3, height=1e-3)
    setting = milling(stock=2e-4, finish=True)
    milled = profile([part], setting, Side.OUTSIDE, tabs)
    room = {3e-3: 0, 6e-3: 2}[radius]
    assert milled.notes == (f"the opening at (20, 20) mm has room for {room} of 3 tabs",)
    lifts = [w for w in cuts(milled.actions).ways if w.start[2] == -2e-3 and w.end[2] == -1e-3]
    inner = [np.hypot(*(way.end[:2] - 0.02)) < radius for way in lifts]
    # each in the passes and in the last one along the side
    assert (sum(inner), len(inner)) == (2 * room, 2 * room + 6)
    zone = Zone(regions=(part,), floor=-2e-3, side="outside", cleared=False, tab_height=tabs.height)
    report = verify(
        milled.actions, Task(Stock.about(part, margin=0.01, thick=0.006), (zone,)), setting.cutter
    )
    assert report.ok, report.text()
