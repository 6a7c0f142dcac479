"""Operations on a drawing: which wires, which cutter, how; carried out one after the other."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import DrawingError

from .action import Action
from .chain import Chaining, chain
from .contour import Contour
from .cutter import Tip
from .drawing import Drawing
from .drill import drill
from .engrave import engrave
from .joining import joined_program
from .nesting import Nested, circles, contour_of, nested
from .operation import Milled, Milling, Side
from .pocket import pocket_within
from .pocket_side import ContourSides, Sides
from .pocket_spline import spline_sides
from .profile_pass import profile
from .profile_spline import keeps_splines, spline_profile
from .region import Region
from .spiral import spiral_within
from .tab import Tabs
from .verify_line import Lines
from .verify_part import Zone
from .wire import Wire
from .zigzag import facing, zigzag_within

_FINE = 1e-2
"""Share of the tolerance within which arcs stand for splines where ways do without them."""


class Kind(StrEnum):
    """What is done."""

    PROFILE = "profile"
    POCKET = "pocket"
    ZIGZAG = "zigzag"
    SPIRAL = "spiral"
    FACING = "facing"
    DRILL = "drill"
    ENGRAVE = "engrave"


@dataclass(frozen=True, slots=True, kw_only=True)
class Work:
    """An operation on a drawing."""

    kind: Kind
    """What is done."""
    milling: Milling
    """The cutter and how it is used."""
    layers: tuple[str, ...] = ()
    """The layers on which it is done; none: all."""
    side: Side = Side.OUTSIDE
    """On which side of contours a profile goes."""
    tabs: Tabs | None = None
    """Where a profile leaves tabs; None: nowhere."""
    angle: float = 0.0
    """The direction of lines to and fro, rad."""
    peck: float | None = None
    """After so much depth a drill comes out, m; None: never."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Exactness:
    """How a drawing is taken."""

    joining: float = 1e-5
    """Ends nearer than this are one place, m."""
    tolerance: float = 1e-5
    """How far ways may be beside what they should be because of splines, m."""
    splines: bool = True
    """Whether the controller has splines."""


@dataclass(frozen=True, slots=True, eq=False)
class Done:
    """An operation that was carried out."""

    work: Work
    """The operation."""
    chaining: Chaining
    """What the drawing had for it."""
    milled: Milled
    """What it gave."""
    aim: Zone | Lines
    """What may be cut, for the verification."""
    slack: float
    """By how much arcs may be beside splines, m."""


def carry_out(
    drawing: Drawing,
    works: Sequence[Work],
    exactness: Exactness | None = None,
    *,
    each: Callable[[Done], None] | None = None,
) -> tuple[tuple[Action, ...], tuple[Done, ...]]:
    """Give the program of operations on a drawing, and what each of them did.

    Args:
        drawing: The drawing.
        works: The operations, in order.
        exactness: How the drawing is taken.
        each: Called after each operation.

    Raises:
        ToolpathError: If a drawing has nothing for an operation, or it cannot be done.
        ValueError: If what is asked for makes no sense.
    """
    exactness = exactness or Exactness()
    done: list[Done] = []
    for work in works:
        one = _carry_out(drawing, work, exactness)
        done.append(one)
        if each is not None:
            each(one)
    actions = joined_program([(one.work.milling.cutter, one.milled) for one in done])
    return actions, tuple(done)


def _carry_out(drawing: Drawing, work: Work, exactness: Exactness) -> Done:
    sheet = drawing.on_layers(*work.layers) if work.layers else drawing
    chaining = chain(sheet.pieces, exactness.joining)
    if work.kind is Kind.ENGRAVE:
        wires = chaining.wires
        if not exactness.splines:
            wires = tuple(_plain(wire, exactness.tolerance) for wire in wires)
        slack = 0.0 if exactness.splines else exactness.tolerance
        aim = _lines(work, chaining.wires, slack)
        return Done(work, chaining, engrave(wires, work.milling), aim, slack)
    if work.kind is Kind.DRILL:
        return _drilled(sheet, work, chaining)
    closed = [wire for wire in chaining.wires if wire.closed]
    if not closed:
        raise DrawingError(
            sheet.file, _named(work), f"needs closed wires; there is none{_open_ends(chaining)}"
        )
    around = nested(closed, exactness.tolerance)
    milled = _told(_milled(work, around, exactness), chaining)
    if _as_splines(work, around, exactness):  # ways that know the splines are measured by them
        around = nested(closed, _FINE * exactness.tolerance)
    return Done(work, chaining, milled, _aim(work, around), around.slack)


def _milled(work: Work, around: Nested, exactness: Exactness) -> Milled:
    milling = _with_slack(work.milling, around.slack)
    match work.kind:
        case Kind.PROFILE if _as_splines(work, around, exactness):
            tolerance = exactness.tolerance
            return spline_profile(around.wires, work.milling, work.side, tolerance, work.tabs)
        case Kind.PROFILE:
            return profile(around.regions, milling, work.side, work.tabs)
        case Kind.FACING:
            return facing(around.regions, milling, work.angle)
        case _:
            return _cleared(work, around, exactness)


def _cleared(work: Work, around: Nested, exactness: Exactness) -> Milled:
    if _as_splines(work, around, exactness):
        parts: Sequence[Sides] = spline_sides(around, exactness.tolerance)
        milling = work.milling
    else:
        parts = [ContourSides(region) for region in around.regions]
        milling = _with_slack(work.milling, around.slack)
    match work.kind:
        case Kind.POCKET:
            return pocket_within(parts, milling)
        case Kind.ZIGZAG:
            return zigzag_within(parts, milling, work.angle)
        case _:
            return spiral_within(parts, milling)


def _as_splines(work: Work, around: Nested, exactness: Exactness) -> bool:
    asked = exactness.splines and work.kind is not Kind.FACING
    return asked and keeps_splines(around.wires)


def _drilled(sheet: Drawing, work: Work, chaining: Chaining) -> Done:
    middles, diameters = circles(chaining.wires)
    if not len(middles):
        raise DrawingError(sheet.file, _named(work), "needs circles; there is none")
    milled = drill(middles, work.milling, work.peck)
    wide = work.milling.cutter.diameter
    notes = list(milled.notes)
    others = sorted({round(d * 1e3, 6) for d in diameters if abs(d - wide) > 1e-6})
    if others:
        drawn = ", ".join(f"{d:g}" for d in others)
        notes.append(f"circles of {drawn} mm are drilled with {wide * 1e3:g} mm")
    holes = tuple(Region(Contour.circle(middle, 0.5 * wide)) for middle in middles)
    flat = work.milling.cutter.tip is Tip.FLAT
    zone = Zone(regions=holes, floor=_floor(work.milling), cleared=flat)
    return Done(work, chaining, Milled(milled.actions, tuple(notes)), zone, 0.0)


def _told(milled: Milled, chaining: Chaining) -> Milled:
    open_ = sum(not wire.closed for wire in chaining.wires)
    if not open_:
        return milled
    note = f"{open_} open wires enclose nothing and are left out{_open_ends(chaining)}"
    return Milled(milled.actions, (*milled.notes, note))


def _aim(work: Work, around: Nested) -> Zone | Lines:
    floor = _floor(work.milling)
    match work.kind:
        case Kind.POCKET | Kind.ZIGZAG | Kind.SPIRAL:
            return Zone(regions=around.regions, floor=floor)
        case Kind.FACING:
            filled = tuple(Region.made(region.outer) for region in around.regions)
            return Zone(regions=filled, floor=floor, open=True)
    tab_height = 0.0 if work.tabs is None else work.tabs.height
    if work.side is Side.ON:
        wires = [wire for one in around.wires for wire in one]
        return _lines(work, wires, around.slack, tab_height)
    return Zone(
        regions=around.regions,
        floor=floor,
        side="outside" if work.side is Side.OUTSIDE else "inside",
        cleared=False,
        tab_height=tab_height,
    )


def _lines(work: Work, wires: Sequence[Wire], slack: float, tab_height: float = 0.0) -> Lines:
    return Lines(
        wires=tuple(wires),
        floor=_floor(work.milling),
        cutter=work.milling.cutter,
        slack=slack,
        tab_height=tab_height,
    )


def _floor(milling: Milling) -> float:
    return milling.top - milling.depth


def _with_slack(milling: Milling, slack: float) -> Milling:
    return replace(milling, slack=milling.slack + slack) if slack else milling


def _plain(wire: Wire, tolerance: float) -> Wire:
    contour = contour_of(wire, tolerance)
    return Wire(contour.pieces(), contour.closed)


def _named(work: Work) -> str:
    on = f" on layer {', '.join(work.layers)}" if work.layers else ""
    return f"{work.kind}{on}"


def _open_ends(chaining: Chaining) -> str:
    ends: Iterable[FloatArray] = chaining.open_ends[:4]
    places = ", ".join("({:.6g}, {:.6g})".format(*(np.asarray(p) * 1e3)) for p in ends)
    return f"; ends are open at {places} mm" if places else ""
