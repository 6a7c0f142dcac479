"""Pockets and faces cleared by straight ways to and fro."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np

from splinearm.arrays import FloatArray

from .clearance import Wall
from .clearing import clear
from .contour import Contour
from .lead_in import with_leads
from .mill import Mill
from .offset import offset
from .operation import Milled, Milling, Run, Track
from .pocket_side import ContourSides, Sides, along_walls
from .region import Region
from .stretch import along_of, stretch

_NUDGE = 1e-7
"""A line that would touch a corner is moved by this share of the step."""
_SHORT = 1e-6
"""A line shorter than this share of the step is left to the way along the wall."""
_FAR = 4.0
"""Ways to the next line longer than this many steps are flown."""


def zigzag(parts: Sequence[Region], setting: Milling, angle: float = 0.0) -> Milled:
    """Clear regions to and fro, then along their walls; islands are left standing.

    With steps up to the cutter's diameter nothing stays that the cutter reaches.

    Args:
        parts: What is cleared.
        setting: The cutter and how it is used.
        angle: The direction of the lines, rad against the x axis.

    Raises:
        GougeError: If a way would come nearer to a part than the cutter's radius.
        ValueError: If there are no parts.
    """
    return zigzag_within([ContourSides(part) for part in parts], setting, angle)


def zigzag_within(parts: Sequence[Sides], setting: Milling, angle: float = 0.0) -> Milled:
    """Clear what lies within sides to and fro, then along them: see `zigzag`."""

    def runs_within(sides: Sides, mill: Mill) -> list[Run]:
        distance = sides.reach(setting)
        rooms = sides.offsets.at(-distance)
        if not rooms:
            return []
        wall = Wall.of(sides.part.contours, distance)
        step = min(setting.over, setting.cutter.diameter - 2.0 * sides.spare)
        runs = [run for room in rooms for run in lines_within(room, step, angle, wall)]
        ways = along_walls(sides, setting, mill.notes)
        sides.require_clear([*(track for run in runs for track in run.tracks), *ways], setting)
        return runs + [with_leads(way, mill.wall, setting.lead, mill.notes) for way in ways]

    return clear(parts, setting, runs_within)


def facing(parts: Sequence[Region], setting: Milling, angle: float = 0.0) -> Milled:
    """Make all that outer contours enclose level, to and fro and beyond their edges.

    Args:
        parts: What becomes level; islands count as enclosed.
        setting: The cutter and how it is used.
        angle: The direction of the lines, rad against the x axis.
    """
    if not parts:
        raise ValueError("parts: want at least one")
    mill = Mill(setting)
    for part in parts:
        for room in offset(part.outer, setting.cutter.radius):
            plain = Region.made(room.outer)
            mill.cut(lines_within(plain, setting.over, angle, None), setting.levels)
    return mill.milled()


@dataclass(frozen=True, slots=True, eq=False)
class _Line:
    """A straight way across a region: its ends, and where on its contours they are."""

    ends: FloatArray
    """Shape (2, 2), from left to right."""
    contours: tuple[int, int]
    segments: tuple[int, int]


def lines_within(room: Region, step: float, angle: float, wall: Wall | None) -> list[Run]:
    """Give lines across a region, to and fro, joined where that is clear.

    Args:
        room: Where the cutter's middle may be.
        step: How far lines may be apart, m.
        angle: Their direction, rad.
        wall: What the ways between them keep away from; None: all within the region is clear.
    """
    turned = room.transformed(angle=-angle)
    rows = _rows(turned, step)
    c, s = np.cos(angle), np.sin(angle)
    back = np.array([[c, s], [-s, c]])
    runs: list[Run] = []
    left = {(i, k) for i, row in enumerate(rows) for k in range(len(row))}
    while left:
        i, k = min(left)
        tracks: list[Track] = []
        rightward = True
        at: tuple[_Line, int] | None = None
        while True:
            left.discard((i, k))
            line = rows[i][k]
            ends = line.ends if rightward else line.ends[::-1]
            if at is not None:
                link = _link(room, at, (line, 0 if rightward else 1), back, wall, step)
                if link is None:
                    runs.append(Run(tuple(tracks)))
                    tracks = []
                else:
                    tracks.append(Track(link, link=True))
            path = Contour.made(ends @ back, np.zeros(1), closed=False)
            tracks.append(Track(path))
            at = line, 1 if rightward else 0
            following = [
                n
                for n in range(len(rows[i + 1]) if i + 1 < len(rows) else 0)
                if (i + 1, n) in left and _overlap(rows[i + 1][n], line)
            ]
            if not following:
                break
            x = ends[1, 0]
            k = min(following, key=lambda n: float(np.abs(rows[i + 1][n].ends[:, 0] - x).min()))
            i += 1
            rightward = not rightward
        runs.append(Run(tuple(tracks)))
    return runs


def _overlap(a: _Line, b: _Line) -> bool:
    return bool(a.ends[0, 0] < b.ends[1, 0] and b.ends[0, 0] < a.ends[1, 0])


def _link(
    room: Region,
    last: tuple[_Line, int],
    following: tuple[_Line, int],
    back: FloatArray,
    wall: Wall | None,
    step: float,
) -> Contour | None:
    """Give the way from the end of a line to the begin of the next: straight, or by the wall."""
    (one, a), (two, b) = last, following
    start, end = one.ends[a] @ back, two.ends[b] @ back
    straight = float(np.hypot(*(end - start)))
    if wall is not None and straight <= _FAR * step and wall.is_clear(start, end):
        return Contour.made(np.array([start, end]), np.zeros(1), closed=False)
    if one.contours[a] != two.contours[b]:
        return None
    contour = room.contours[one.contours[a]]
    whole = contour.length
    first = along_of(contour, one.segments[a], start)
    final = along_of(contour, two.segments[b], end)
    ahead, behind = (final - first) % whole, (first - final) % whole
    if min(ahead, behind) > _FAR * step or min(ahead, behind) <= 1e-9 * whole:
        return None
    if ahead <= behind:
        path = stretch(contour, first, first + ahead)
    else:
        path = stretch(contour, final, final + behind).reversed()
    vertices = np.array(path.vertices)
    vertices[0], vertices[-1] = start, end
    return Contour.made(vertices, np.array(path.bulges), closed=False)


def _rows(room: Region, step: float) -> list[list[_Line]]:
    """Give the level lines across a region, row after row from below."""
    packed = [contour.packed() for contour in room.contours]
    P = np.concatenate([rows for rows, _ in packed])
    segment = np.concatenate([rows for _, rows in packed]).astype(int)
    whose = np.concatenate([np.full(len(rows), i) for i, (rows, _) in enumerate(packed)])
    _, low, _, high = room.bounds
    count = max(1, ceil((high - low) / step - 1e-9))
    apart = (high - low) / count
    corners = np.sort(np.concatenate([contour.vertices[:, 1] for contour in room.contours]))
    rows: list[list[_Line]] = []
    for k in range(count):
        y = low + (k + 0.5) * apart
        while np.abs(corners - y).min() < 0.1 * _NUDGE * step:
            y += _NUDGE * step
        x, piece = _crossings(P, y)
        middles = np.stack((0.5 * (x[1:] + x[:-1]), np.full(max(0, len(x) - 1), y)), axis=1)
        inside = room.contains(middles) if len(middles) else np.zeros(0, dtype=bool)
        row = [
            _Line(
                np.array([[x[i], y], [x[i + 1], y]]),
                (int(whose[piece[i]]), int(whose[piece[i + 1]])),
                (int(segment[piece[i]]), int(segment[piece[i + 1]])),
            )
            for i in np.flatnonzero(inside)
            if x[i + 1] - x[i] > _SHORT * step
        ]
        rows.append(row)
    return rows


def _crossings(P: FloatArray, y: float) -> tuple[FloatArray, "np.typing.NDArray[np.intp]"]:
    """Give where a level line crosses pieces, from left to right, and the piece of each."""
    ax, ay, bx, by, k = P[:, 0], P[:, 1], P[:, 2], P[:, 3], P[:, 4]
    straight = k == 0.0
    across = straight & ((ay > y) != (by > y))
    i = np.flatnonzero(across)
    xs = [ax[i] + (y - ay[i]) / (by[i] - ay[i]) * (bx[i] - ax[i])]
    pieces = [i]
    arcs = np.flatnonzero(~straight)
    cx, cy = ax[arcs] + P[arcs, 5] / k[arcs], ay[arcs] + P[arcs, 6] / k[arcs]
    half2 = 1.0 / k[arcs] ** 2 - (y - cy) ** 2
    meets = half2 > 0.0
    arcs, cx, half = arcs[meets], cx[meets], np.sqrt(half2[meets])
    for sign in (-1.0, 1.0):
        x = cx + sign * half
        ahead = (x - ax[arcs]) * P[arcs, 6] - (y - ay[arcs]) * P[arcs, 5] >= 0.0
        behind = (x - bx[arcs]) * P[arcs, 8] - (y - by[arcs]) * P[arcs, 7] <= 0.0
        on = ahead & behind
        xs.append(x[on])
        pieces.append(arcs[on])
    x, piece = np.concatenate(xs), np.concatenate(pieces)
    order = np.argsort(x, kind="stable")
    return x[order], piece[order]
