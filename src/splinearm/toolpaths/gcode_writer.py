"""NC programs out of what a machine shall do.

Words that hold already are left out. Arcs stay arcs; splines are written as G5 where they are cubic
and as G5.2 where they are rational, piece by piece, for controllers that know them.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from math import hypot, inf, isfinite, pi

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.bezier import Bezier, bezier_curves
from splinearm.errors import GcodeError

from .action import (
    Action,
    ArcFeed,
    Cutting,
    Dwell,
    Feed,
    Message,
    Pause,
    Rapid,
    Spindle,
    SplineFeed,
    Switch,
    ToolChange,
)  # fmt: skip
from .gcode_dialect import Dialect
from .gcode_state import AXES, MM, OFFSET_LETTERS

_PLANES = {2: "G17", 1: "G18", 0: "G19"}


def write_gcode(actions: Iterable[Action], dialect: Dialect, title: str = "") -> str:
    """Give the program that lets a machine do something.

    Args:
        actions: What it shall do, in machine coordinates of G54.
        dialect: What the controller takes.
        title: What the program says of itself in its first lines.

    Raises:
        GcodeError: If the controller cannot be told something.
    """
    writer = _Writer(dialect)
    lines = list(writer.program(actions, title))
    for number, line in enumerate(lines, start=1):
        if len(line) > dialect.longest_line:
            raise GcodeError(
                "program",
                number,
                "",
                f"is {len(line)} characters long; {dialect.name} takes {dialect.longest_line}",
            )
    return "\n".join(lines) + "\n"


@dataclass(slots=True, eq=False)
class _Writer:
    dialect: Dialect
    place: FloatArray | None = None
    """Where the tool is, mm, as it was written; None: nobody knows."""
    holding: dict[str, str] = field(default_factory=dict)
    """Modal words in force by group."""
    feed: str = ""
    rises: bool = False
    """Whether a rapid way only leads up, from wherever the tool is."""

    def program(self, actions: Iterable[Action], title: str) -> Iterator[str]:
        if self.dialect.program_marks:
            yield "%"
        for line in title.splitlines():
            yield self.comment(line)
        yield "G17 G21 G40 G49 G54 G80 G90 G94" if self.dialect.tool_changes else "G17 G21 G90 G94"
        self.holding["plane"] = "G17"
        ended = False
        several = tuple(actions)
        for i, action in enumerate(several):
            self.rises = self.place is None and _rises(several[i:])
            yield from self.lines(action)
            ended = isinstance(action, Pause) and action.code in ("M2", "M30")
        if not ended:
            yield "M2"
        if self.dialect.program_marks:
            yield "%"

    def comment(self, text: str) -> str:
        """Give a comment; brackets within it would end it."""
        plain = text.translate({ord("("): "[", ord(")"): "]", ord(";"): ","})
        room = self.dialect.longest_line - 2
        return f"({plain.encode('ascii', 'replace').decode()[:room]})"

    def lines(self, action: Action) -> Iterator[str]:
        """Give the lines of one action."""
        match action:
            case Rapid():
                words = self.up(action) if self.rises else self.ends(action.end)
                if words:
                    yield self.joined(self.hold("motion", "G0"), words)
            case Feed():
                yield from self.straight(action)
            case ArcFeed():
                yield from self.arc(action)
            case SplineFeed():
                yield from self.spline(action)
            case _:
                yield from self.switched(action)

    def switched(
        self, action: Dwell | Spindle | ToolChange | Switch | Pause | Message
    ) -> Iterator[str]:
        """Give the lines of what is no way."""
        match action:
            case Dwell():
                yield f"G4 P{self.number(action.time, 3)}"
            case Spindle():
                yield self.spindle(action.speed)
            case ToolChange():
                yield from self.tool(action.tool)
            case Message():
                yield f"(MSG, {self.comment(action.text)[1:-1]})"
            case _:
                yield action.code

    def straight(self, way: Feed) -> Iterator[str]:
        words = self.ends(way.end)
        if words:
            yield from self.blending(way)
            yield self.joined(self.hold("motion", "G1"), words, self.feed_word(way))

    def arc(self, way: ArcFeed) -> Iterator[str]:
        """Write an arc, in half turns where one line cannot say how far it turns."""
        yield from self.blending(way)
        start = self.known(way)
        for part in _parts(way):
            end, centre = self.rounded(part.end), part.centre / MM
            if abs(part.turn) < pi and (end == start).all():
                continue  # written as an arc it would be a full circle
            a, b = (way.axis + 1) % 3, (way.axis + 2) % 3
            arm = np.zeros(3)
            arm[[a, b]] = self.rounded_array((centre - start)[[a, b]])
            first = hypot(arm[a], arm[b])
            last = hypot(*(end - start - arm)[[a, b]])
            slack = max(self.dialect.arc_slack / MM, self.dialect.arc_share * first)
            if (
                first == 0.0
                or abs(first - last) > slack
                or first * MM > self.dialect.largest_radius
            ):
                yield from self.as_line(part)
            else:
                letters = "".join(
                    f"{OFFSET_LETTERS[i].upper()}{self.number(arm[i])}" for i in sorted((a, b))
                )
                yield self.joined(
                    self.hold("plane", _PLANES[way.axis]),
                    self.hold("motion", "G3" if part.turn > 0.0 else "G2"),
                    self.ends(part.end, always=(a, b)),
                    letters,
                    self.feed_word(way),
                )
            start = end

    def as_line(self, arc: ArcFeed) -> Iterator[str]:
        """Write an arc as a line, if nobody could tell the difference."""
        chord = hypot(*(arc.end - arc.start))
        height = 0.5 * chord * abs(np.tan(0.25 * arc.turn))
        if height > 2.0 * self.dialect.resolution:
            raise GcodeError(
                "program",
                arc.line,
                "",
                f"an arc of {arc.radius_at_start / MM:.6g} mm that bends by {height / MM:.3g} mm "
                f"cannot be written for {self.dialect.name}; make lines of it",
            )
        words = self.ends(arc.end)
        if words:
            yield self.joined(self.hold("motion", "G1"), words, self.feed_word(arc))

    def spline(self, way: SplineFeed) -> Iterator[str]:
        points = way.curve.points
        if not self.dialect.splines:
            raise GcodeError(
                "program", way.line, "", f"{self.dialect.name} has no splines; make arcs of them"
            )
        if np.ptp(points[:, 2]) > self.dialect.resolution:
            raise GcodeError("program", way.line, "", "a spline must stay level; make lines of it")
        yield from self.blending(way)
        for piece in bezier_curves(way.curve):
            if piece.weights is None and piece.degree == 3:
                yield self.cubic(way, piece)
            else:
                yield from self.nurbs(way, piece)

    def cubic(self, way: SplineFeed, piece: Bezier) -> str:
        start = self.known(way)
        points = piece.points / MM
        end = self.rounded(piece.points[3])
        i, j = self.rounded_array(points[1, :2] - start[:2])
        p, q = self.rounded_array(points[2, :2] - end[:2])
        handles = zip("IJPQ", (i, j, p, q), strict=True)
        self.holding.pop("motion", None)  # LinuxCNC 2.9 forgets G5 at the end of its line
        return self.joined(
            self.hold("plane", "G17"),
            "G5",
            self.ends(piece.points[3], always=(0, 1), level=True),
            "".join(f"{letter}{self.number(value)}" for letter, value in handles),
            self.feed_word(way),
        )

    def nurbs(self, way: SplineFeed, piece: Bezier) -> Iterator[str]:
        self.known(way)
        weights = np.ones(len(piece.points)) if piece.weights is None else piece.weights
        digits = 9
        yield self.joined(
            self.hold("plane", "G17"),
            f"G5.2 P{self.number(weights[0], digits)} L{piece.degree + 1}",
            self.feed_word(way),
        )
        for point, weight in zip(piece.points[1:], weights[1:], strict=True):
            words = self.ends(point, always=(0, 1), level=True)
            yield f"{words} P{self.number(weight, digits)}"
        self.holding.pop("motion", None)
        yield "G5.3"

    def spindle(self, speed: float) -> str:
        if speed == 0.0:
            return "M5"
        turns = abs(speed) * 60.0 / (2.0 * pi)
        return f"S{self.number(turns, 1)} {'M3' if speed > 0.0 else 'M4'}"

    def tool(self, number: int) -> Iterator[str]:
        if self.dialect.tool_changes:
            yield f"T{number} M6"
            yield f"G43 H{number}" if number else "G49"
        else:
            yield "M5"
            yield self.comment(f"change to tool {number}")
            yield "M0"
        self.place = None

    def blending(self, way: Cutting) -> Iterator[str]:
        """Say how far corners may be cut, where the controller takes that."""
        if not self.dialect.blends:
            return
        if way.blend is None:
            word = "G61"
        else:
            word = "G64" if way.blend == inf else f"G64 P{self.number(way.blend / MM)}"
        if self.hold("path", word):
            yield word

    def feed_word(self, way: Cutting) -> str:
        if way.feed is None or not (isfinite(way.feed) and way.feed > 0.0):
            raise GcodeError("program", way.line, "F", f"want a feed above 0, got {way.feed} m/s")
        word = f"F{self.number(way.feed * 60.0 / MM, 2)}"
        if word == "F0":
            raise GcodeError(
                "program", way.line, "F", f"{way.feed:g} m/s is too slow to be written"
            )
        if word == self.feed:
            return ""
        self.feed = word
        return word

    def hold(self, group: str, word: str) -> str:
        """Give a modal word, or nothing if it holds already."""
        if self.holding.get(group) == word:
            return ""
        self.holding[group] = word
        return word

    def ends(self, end: FloatArray, always: tuple[int, ...] = (), *, level: bool = False) -> str:
        """Give the axis words that lead to an end."""
        target, words = self.rounded(end), []
        for axis in range(2 if level else 3):
            moved = self.place is None or target[axis] != self.place[axis]
            if moved or axis in always:
                words.append(f"{AXES[axis].upper()}{self.number(target[axis])}")
        if level and self.place is not None:
            target[2] = self.place[2]
        self.place = target
        return " ".join(words)

    def up(self, way: Rapid) -> str:
        """Give the word that leads up from wherever the tool is."""
        z = self.rounded(way.end)[2]
        self.place = np.array([np.nan, np.nan, z])
        return f"{AXES[2].upper()}{self.number(z)}"

    def known(self, way: Cutting) -> FloatArray:
        """Give where the tool is, mm: where it was sent, which is where the way begins."""
        if self.place is None:
            raise GcodeError("program", way.line, "", "a program begins with a line, not with this")
        return self.place

    def rounded(self, place: FloatArray) -> FloatArray:
        if not np.isfinite(place).all():
            raise GcodeError("program", 0, "", f"a place is not finite: {place.tolist()}")
        return self.rounded_array(place / MM)

    def rounded_array(self, values: FloatArray) -> FloatArray:
        rounded: FloatArray = np.round(values, self.dialect.decimals) + 0.0
        return rounded

    def number(self, value: float, decimals: int | None = None) -> str:
        """Write a number with as few digits as it needs."""
        text = f"{value:.{self.dialect.decimals if decimals is None else decimals}f}"
        text = text.rstrip("0").rstrip(".")
        return "0" if text in ("-0", "") else text

    @staticmethod
    def joined(*words: str) -> str:
        return " ".join(word for word in words if word)


def _rises(actions: tuple[Action, ...]) -> bool:
    """Say whether actions begin with a rapid way straight up and go on with another."""
    first = actions[0]
    if not isinstance(first, Rapid) or (first.start[:2] != first.end[:2]).any():
        return False
    moves = (action for action in actions[1:] if isinstance(action, Rapid | Cutting))
    return isinstance(next(moves, None), Rapid)


def _parts(way: ArcFeed) -> list[ArcFeed]:
    """Give an arc in pieces that end where they do not begin: a full circle in two halves."""
    count = max(1, int(np.ceil(abs(way.turn) / (1.5 * pi))))
    if count == 1:
        return [way]
    places = way.at(np.linspace(0.0, 1.0, count + 1))
    places[0], places[-1] = way.start, way.end
    parts = []
    for i in range(count):
        centre = way.centre.copy()
        centre[way.axis] = places[i][way.axis]
        part = replace(
            way, start=places[i], end=places[i + 1], centre=centre, turn=way.turn / count
        )
        parts.append(part)
    return parts
