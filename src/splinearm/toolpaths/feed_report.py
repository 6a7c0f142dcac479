"""How well a planned program keeps the feeds that it asks for."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.trajectories.section import Section

from .placing import Placed
from .program import Part

KEPT = 0.99
"""From this share of it on a feed is kept."""

_STEP = 2e-3
"""Time between looks, s."""

_LEAST = 50


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FeedReport:
    """How well feeds are kept."""

    length: float
    """How long all cuts are, m."""
    kept: float
    """Share of that on which the tool has its feed, to 1 %; on the rest it is slower: to begin and
    end at rest, in corners, and where joints are at a limit."""
    slow: tuple[tuple[str, float], ...]
    """Ways on which it never has its feed, and the share of it that is reached there."""
    highest: float
    """Largest share of a feed that is reached; 1, but for rounding."""

    @property
    def words(self) -> str:
        """Say it."""
        text = f"feed: as programmed over {100.0 * self.kept:.0f} % of {self.length * 1e3:.0f} mm"
        if not self.slow:
            return text
        name, share = min(self.slow, key=lambda one: one[1])
        several = f"{len(self.slow)} ways are" if len(self.slow) > 1 else "one way is"
        return (
            f"{text}; {several} too short or bent for it, {name} gets {100.0 * share:.0f} % of it"
        )


def report_feeds(placed: Placed, parts: Iterable[Part]) -> FeedReport:
    """Give how well a planned program keeps its feeds."""
    stages = placed.itinerary.stages
    edges = np.concatenate([stage.edges[:-1] for stage in stages])
    names = [name for stage in stages for name in stage.names]
    looks = [
        _looks(section)
        for part in parts
        for section in part.plan.trajectory.sections
        if section.cap is not None
    ]
    if not looks:
        return FeedReport(length=0.0, kept=1.0, slow=(), highest=0.0)
    s, share, way = (np.concatenate(column) for column in zip(*looks, strict=True))
    owner = np.clip(np.searchsorted(edges, s, side="right") - 1, 0, len(edges) - 1)
    best = np.zeros(len(edges))
    np.maximum.at(best, owner, share)
    cut = np.unique(owner)
    return FeedReport(
        length=float(way.sum()),
        kept=float(way[share >= KEPT].sum() / way.sum()),
        slow=tuple((names[k], float(best[k])) for k in cut if best[k] < KEPT),
        highest=float(share.max()),
    )


def _looks(section: Section) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give places, shares of the feed there, and lengths that they stand for, each (k,)."""
    cap, law = section.cap, section.law
    count = max(_LEAST, int(law.duration / _STEP))
    t = (np.arange(count) + 0.5) * law.duration / count
    s, speed, _ = law.sample(t)
    if cap is None:
        return s, np.zeros(count), np.zeros(count)
    v = cap.rate(s) * speed
    return s, v / cap.at(s), v * law.duration / count
