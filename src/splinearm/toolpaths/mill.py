"""A cutter on its way: ways in the plane become what the machine does, level by level."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.bspline import BSpline

from .action import Action, ArcFeed, Feed, Rapid, SplineFeed
from .contour import Contour
from .edge_feed import feeds_along, spline_feeds
from .operation import Barrier, Milled, Milling, Notes, Run, Track
from .piece import Piece, SplinePiece
from .spline_leg import pieces_between
from .stretch import stretch

_STRAIGHT = 1e-9
"""An arc that turns less than this, rad, is a line."""


@dataclass(frozen=True, slots=True, eq=False)
class _Way:
    """A way in the plane with what its lines and arcs are made of."""

    vertices: FloatArray
    centres: FloatArray
    lengths: FloatArray
    turns: list[float]
    feeds: list[float]


@dataclass(slots=True, eq=False)
class Mill:
    """What a cutter has done so far, and where it is."""

    setting: Milling
    """The cutter and how it is used."""
    wall: Barrier | None = None
    """What its middle keeps away from; None: nothing."""
    actions: list[Action] = field(default_factory=list)
    """What it has done."""
    notes: Notes = field(default_factory=Notes)
    """What there is to be told."""
    place: FloatArray | None = None
    """Where its tip is, shape (3,), m."""

    def milled(self) -> Milled:
        """Lift the cutter and give what it has done."""
        self.lift()
        return Milled(tuple(self.actions), self.notes.given())

    def lift(self) -> None:
        """Go up to where rapid ways are safe."""
        if self.place is not None and self.place[2] != self.setting.safe:
            self.rapid(np.array([self.place[0], self.place[1], self.setting.safe]))

    @property
    def known(self) -> FloatArray:
        """Where its tip is, shape (3,), m.

        Raises:
            ValueError: If it has gone nowhere yet.
        """
        if self.place is None:
            raise ValueError("place: nobody knows where the cutter is; go above first")
        return self.place

    def above(self, spot: FloatArray) -> None:
        """Go over a place of the plane, at the safe height."""
        over = np.array([spot[0], spot[1], self.setting.safe])
        if self.place is None:
            # where the machine is nobody knows: it goes up before it goes anywhere, and then over,
            # even if that is the origin, from which the way up begins for want of a better place
            up = np.array([0.0, 0.0, self.setting.safe])
            self.actions += [Rapid(start=np.zeros(3), end=up), Rapid(start=up, end=over)]
            self.place = over
        self.lift()
        self.rapid(over)

    def rapid(self, end: FloatArray) -> None:
        """Go straight and quickly."""
        if (end != self.known).any():
            self.actions.append(Rapid(start=self.known, end=end))
            self.place = end

    def straight(self, end: FloatArray, feed: float) -> None:
        """Cut straight to a place."""
        if (end != self.known).any():
            self.actions.append(
                Feed(start=self.known, end=end, feed=feed, blend=self.setting.blend)
            )
            self.place = end

    def drop(self, z: float) -> None:
        """Go straight down (or up) at the feed for that."""
        self.straight(np.array([*self.known[:2], z]), self.setting.cutter.plunge)

    def down_to(self, surface: float) -> None:
        """Go quickly down to just above material that begins at a height."""
        height = min(surface + self.setting.gap, self.setting.safe)
        if self.known[2] > height:
            self.rapid(np.array([*self.known[:2], height]))

    def follow(self, track: Track, z: float, feed: float | None = None) -> None:
        """Cut along a way that begins where the cutter is, ending at a height."""
        way = self._way((track,))
        if feed is not None:
            way = replace(way, feeds=[feed] * len(way.feeds))
        self._along(way, z)

    def _way(self, tracks: Sequence[Track]) -> "_Way":
        """Give ways one after the other as one, with the feeds along it."""
        cutter = self.setting.cutter
        vertices = np.concatenate(
            [tracks[0].path.vertices[:1], *(track.path.vertices[1:] for track in tracks)]
        )
        bulges = np.concatenate([track.path.bulges for track in tracks])
        walls = np.repeat([t.wall for t in tracks], [len(t.path.bulges) for t in tracks])
        path = Contour.made(vertices, bulges, closed=False)
        lengths, turns = path.lengths, path.turns
        feeds = feeds_along(lengths, turns, walls, cutter.feed, cutter.radius)
        way = np.diff(vertices, axis=0)
        safe = np.where(np.abs(turns) < _STRAIGHT, 1.0, bulges)
        off = 0.25 * (1.0 / safe - safe)[:, None]
        across = np.stack((-way[:, 1], way[:, 0]), axis=1)
        centres = 0.5 * (vertices[1:] + vertices[:-1]) + off * across
        return _Way(vertices, centres, lengths, turns.tolist(), feeds.tolist())

    def _along(self, way: "_Way", z: float) -> None:
        places = np.empty((len(way.vertices), 3))
        places[:, :2] = way.vertices
        places[:, 2] = z
        height = self.known[2]
        if height != z:
            shares = np.cumsum(way.lengths[:-1]) / way.lengths.sum()
            places[1:-1, 2] = height + shares * (z - height)
        places[0] = self.known
        centres = np.empty((len(way.centres), 3))
        centres[:, :2] = way.centres
        centres[:, 2] = places[:-1, 2]
        at = list(places)
        add, blend = self.actions.append, self.setting.blend
        for k, (turn, feed, length) in enumerate(
            zip(way.turns, way.feeds, way.lengths.tolist(), strict=True)
        ):
            if length == 0.0:
                continue
            start, end = at[k], at[k + 1]
            if -_STRAIGHT < turn < _STRAIGHT:
                add(Feed(start=start, end=end, feed=feed, blend=blend))
            else:
                arc = ArcFeed(
                    start=start,
                    end=end,
                    feed=feed,
                    blend=blend,
                    centre=centres[k],
                    axis=2,
                    turn=turn,
                )
                add(arc)
        self.place = at[-1]

    def follow_level(self, track: Track, z: float) -> None:
        """Cut along a way at the height at which the cutter is; splines stay splines."""
        if track.legs:
            self.follow_pieces([leg.piece for leg in track.legs], track.wall, z)
        else:
            self.follow(track, z)

    def follow_over(self, track: Track, z: float, over: float) -> None:
        """Cut along a way, lifted to a height where tabs stay."""
        size, at = track.path.length, 0.0
        for begin, end in track.lifted:
            self._follow_part(track, (at, begin), z)
            self.drop(over)
            self._follow_part(track, (begin, end), over)
            self.drop(z)
            at = end
        self._follow_part(track, (at, size), z)

    def _follow_part(self, track: Track, part: tuple[float, float], z: float) -> None:
        if part[0] == part[1]:
            return
        if track.legs:
            self.follow_pieces(pieces_between(track.legs, *part), track.wall, z)
        else:
            self.follow(replace(track, path=stretch(track.path, *part)), z)

    def follow_pieces(self, pieces: Sequence[Piece], wall: int, z: float) -> None:
        """Cut along pieces at the height at which the cutter is; the wall is to one side."""
        cutter = self.setting.cutter
        for piece in pieces:
            if not isinstance(piece, SplinePiece):
                path = Contour.of_pieces([piece], closed=False)
                self.follow(Track(path, wall), z)
                continue
            for curve, feed in spline_feeds(piece.curve, wall, cutter.feed, cutter.radius):
                self.spline(curve, z, feed)

    def spline(self, curve: BSpline, z: float, feed: float) -> None:
        """Cut along a spline of the plane at the height at which the cutter is."""
        raised = np.column_stack((curve.points, np.full(len(curve.points), z)))
        raised[0] = self.known
        self.actions.append(
            SplineFeed(
                start=self.known,
                end=raised[-1],
                feed=feed,
                blend=self.setting.blend,
                curve=BSpline(curve.knots, raised, curve.degree, curve.weights),
            )
        )
        self.place = raised[-1]

    def cut(
        self,
        runs: Iterable[Run],
        levels: Sequence[float],
        *,
        whole: bool = False,
        over: float | None = None,
    ) -> None:
        """Cut runs at all levels.

        Args:
            runs: What is cut.
            levels: Heights, falling.
            whole: Whether each run is cut to the end before the next; else level by level.
            over: To which height the cutter is lifted over tabs, m.
        """
        from .entry import enter

        several = tuple(runs)
        surfaces = (self.setting.top, *levels[:-1])
        passes = list(zip(levels, surfaces, strict=True))
        if whole:
            plan = [(run, level) for run in several for level in passes]
        else:
            plan = [(run, level) for level in passes for run in several]
        ways = {
            id(run): self._way(run.tracks)
            for run in several
            if not any(track.legs for track in run.tracks)
        }
        for run, (z, surface) in plan:
            enter(self, run, z, surface)
            low = over is not None and z < over
            if id(run) in ways and not (low and any(track.lifted for track in run.tracks)):
                self._along(ways[id(run)], z)
                continue
            for track in run.tracks:
                if over is not None and low and track.lifted:
                    self.follow_over(track, z, over)
                else:
                    self.follow_level(track, z)
