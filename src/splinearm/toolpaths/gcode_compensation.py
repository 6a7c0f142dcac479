"""Cutter compensation: ways with G41 and G42 moved aside by the radius of the tool, as one.

Controllers move each way aside looking at its neighbour only, and gouge where a part is narrower
than that. Here the whole contour is moved aside and trimmed: nothing of it is cut, and what the
tool cannot reach is told.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import GcodeError, GougeError

from .action import Action, ArcFeed, Cutting, Feed, Move, Rapid, SplineFeed
from .contour import Contour
from .gcode_aside import moved_aside
from .piece import ArcPiece, LinePiece

_SAME = 1e-9
"""Places nearer than this are one, m."""

_Way = Feed | ArcFeed

_SHARES = np.linspace(0.05, 0.95, 19)


@dataclass(frozen=True, slots=True, eq=False)
class Unreached:
    """A way that the tool cannot touch without cutting into another."""

    line: int
    """The line of the program."""
    where: tuple[float, float]
    """Its middle, m."""
    left: float
    """How much of the material is left there, m."""


@dataclass(frozen=True, slots=True, eq=False)
class Compensated:
    """What a machine does with the tool beside its ways."""

    actions: tuple[Action, ...]
    """What it does; no way is marked any more."""
    unreached: tuple[Unreached, ...]
    """Ways that the tool cannot touch."""


def compensate(actions: Iterable[Action]) -> Compensated:
    """Move ways that are marked so aside by the radius of the tool.

    The first marked way leads to the contour and the first after the last leads away from it; both
    end at the contour's ends beside it. Ways between stay level, apart from plunges.

    Args:
        actions: What the machine does, as `run_gcode` gives it.

    Raises:
        GcodeError: If marked ways are no contour in the plane.
        GougeError: If the tool does not fit along the contour, or cuts it on the way to it.
    """
    done: list[Action] = []
    unreached: list[Unreached] = []
    marked: list[Cutting] = []
    shift = np.zeros(3)
    for action in actions:
        if isinstance(action, Feed | ArcFeed | SplineFeed) and action.side:
            marked.append(action)
            continue
        if marked:
            ways, lost = _compensated(marked)
            shift = ways[-1].end - marked[-1].end
            done += ways
            unreached += lost
            marked = []
        if isinstance(action, Rapid | Feed | ArcFeed | SplineFeed) and shift.any():
            done.append(_led_away(action, action.start + shift))
            shift = np.zeros(3)
        else:
            done.append(action)
    if marked:
        ways, lost = _compensated(marked)
        done += ways
        unreached += lost
    return Compensated(tuple(done), tuple(unreached))


def _led_away(move: Move, start: FloatArray) -> Move:
    """Give the first way behind a contour, from where the tool is."""
    if not isinstance(move, Rapid | Feed):
        raise GcodeError("program", move.line, "", "a line must lead away from a contour")
    return replace(move, start=start)


def _compensated(marked: Sequence[Cutting]) -> tuple[list[_Way], list[Unreached]]:
    """Give the ways of one contour beside it, with the way to it."""
    entry, ways = marked[0], list(marked[1:])
    if not isinstance(entry, Feed):
        raise GcodeError("program", entry.line, "", "a line must lead to a contour with G41 or G42")
    if not any(_is_level(way) for way in ways):
        raise GcodeError("program", entry.line, "", "no contour follows on G41 or G42 in its plane")
    done: list[_Way] = []
    unreached: list[Unreached] = []
    place = entry.start
    waiting: list[Cutting] = []
    lead: Cutting | None = entry
    for section in _sections(ways):
        if not _is_level(section[0]):
            waiting += section
            continue
        beside, lost = _beside(section)
        unreached += lost
        first = beside[0].start
        if lead is not None:
            target = np.array([first[0], first[1], lead.end[2]])
            _require_clear(_contour(section), place, target, entry)
            done.append(_straight(lead, place, target))
            place = target
            lead = None
        for plunge in waiting:
            target = np.array([place[0], place[1], plunge.end[2]])
            done.append(_straight(plunge, place, target))
            place = target
        waiting = []
        if hypot(*(first - place)[:2]) > _SAME:
            _require_clear(_contour(section), place, first, section[0])
            done.append(_straight(section[0], place, first))
        done += beside
        place = beside[-1].end
    for plunge in waiting:
        target = np.array([place[0], place[1], plunge.end[2]])
        done.append(_straight(plunge, place, target))
        place = target
    return done, unreached


def _is_level(way: Cutting) -> bool:
    return hypot(*(way.end - way.start)[:2]) > _SAME or isinstance(way, ArcFeed | SplineFeed)


def _sections(ways: Sequence[Cutting]) -> list[list[Cutting]]:
    """Give runs of level ways and of plunges in turn."""
    sections: list[list[Cutting]] = []
    for way in ways:
        if sections and _is_level(sections[-1][0]) == _is_level(way):
            sections[-1].append(way)
        else:
            sections.append([way])
    return sections


def _straight(like: Cutting, start: FloatArray, end: FloatArray) -> Feed:
    return Feed(
        line=like.line, start=start, end=end, feed=like.feed, time=like.time, blend=like.blend
    )


def _contour(section: Sequence[Cutting]) -> Contour:
    """Give level ways as a contour."""
    pieces: list[LinePiece | ArcPiece] = []
    for way in section:
        if abs(way.end[2] - way.start[2]) > _SAME:
            reason = "rises beside its contour; with G41 and G42 ways stay level"
            raise GcodeError("program", way.line, "", reason)
        if isinstance(way, ArcFeed) and way.axis == 2:
            start, end = way.start[:2], way.end[:2]
            for k, part in enumerate(_turns(way.turn)):
                middle = end if k == len(_turns(way.turn)) - 1 else start
                pieces.append(ArcPiece(start=start, end=middle, centre=way.centre[:2], turn=part))
        elif isinstance(way, Feed):
            pieces.append(LinePiece(way.start[:2], way.end[:2]))
        else:
            reason = "cannot be beside its contour; with G41 and G42 write lines and arcs of G17"
            raise GcodeError("program", way.line, "", reason)
    return Contour.of_pieces(pieces, closed=False)


def _turns(turn: float) -> list[float]:
    """Give how far an arc turns in full turns and what is left."""
    full = 2.0 * np.pi
    count = int(abs(turn) // full)
    rest = abs(turn) - count * full
    parts = [full] * count + ([rest] if rest > 1e-12 else [])
    return [part if turn > 0.0 else -part for part in parts]


def _beside(section: Sequence[Cutting]) -> tuple[list[_Way], list[Unreached]]:
    """Give level ways beside a contour."""
    contour, like = _contour(section), section[0]
    beside = moved_aside(contour, like.side * like.radius) if like.radius > 0.0 else contour
    owners = [_contour([way]) for way in section]
    ways: list[_Way] = []
    for piece in beside.pieces():
        owner = section[int(np.argmin([own.distance(piece.middle) for own in owners]))]
        start, end = (np.array([*place, like.start[2]]) for place in (piece.start, piece.end))
        if isinstance(piece, LinePiece):
            ways.append(_straight(owner, start, end))
        else:
            ways.append(
                ArcFeed(
                    line=owner.line, start=start, end=end, feed=owner.feed, time=owner.time,
                    blend=owner.blend, centre=np.array([*piece.centre, start[2]]), axis=2,
                    turn=piece.turn,
                )
            )  # fmt: skip
    return ways, _unreached(section, owners, beside, like.radius)


def _unreached(
    section: Sequence[Cutting], owners: Sequence[Contour], beside: Contour, radius: float
) -> list[Unreached]:
    """Give ways no place of which is as near to the tool's way as the radius."""
    found = []
    for way, owner in zip(section, owners, strict=True):
        places = _along(owner)
        gaps = beside.distance(places) - radius
        nearest = int(np.argmin(gaps))
        if gaps[nearest] > 1e-6 * max(radius, 1e-3):
            x, y = places[len(places) // 2].tolist()
            found.append(Unreached(way.line, (x, y), float(gaps.max())))
    return found


def _along(contour: Contour) -> FloatArray:
    """Give places along a contour of one way, from end to end."""
    places = []
    for piece in contour.pieces():
        if isinstance(piece, LinePiece):
            places.append(piece.start + _SHARES[:, None] * (piece.end - piece.start))
        else:
            arm = piece.start - piece.centre
            c, s = np.cos(_SHARES * piece.turn), np.sin(_SHARES * piece.turn)
            turned = np.column_stack((c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]))
            places.append(piece.centre + turned)
    return np.vstack(places)


def _require_clear(contour: Contour, start: FloatArray, end: FloatArray, like: Cutting) -> None:
    """Refuse a straight way to the start of a contour on which the tool cuts what lies behind it.

    The start itself is what the tool comes to: it may come over its edge.
    """
    shares = np.linspace(0.0, 1.0, 513)[:, None]
    places = start[:2] + shares * (end - start)[:2]
    distances = contour.distance(places)
    edge = np.hypot(*(places - contour.vertices[0]).T)
    gaps = np.where(distances < edge - _SAME, distances - like.radius, 0.0)
    worst = int(np.argmin(gaps))
    if gaps[worst] < -1e-6 * like.radius - _SAME:
        x, y = places[worst].tolist()
        remedy = "begin farther off the contour, on the side of the tool"
        raise GougeError((x, y), float(-gaps[worst]), remedy)
