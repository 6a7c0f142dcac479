"""A pocket with six islands cleared by parallel contours, beside shapely and Clipper2 (pyclipr).

Run it on one core, for example ``taskset -c 1 python benchmarks/toolpaths_pocket.py``. Peers give
rings only, of lines within the tolerance; ours are exact, checked, begun where they are nearest to
each other, linked where that is clear of the walls, and written as what a machine does. What stays
uncut is measured for all by the same look at random points. Each time is the best of several calls,
the first left out; what counts is the ratio within one run.
"""

import argparse
import datetime
import os
import platform

import numpy as np
from kinematics_forward import processor, shortest
from toolpaths_offset import TOLERANCE, by_pyclipr, by_shapely, islands

from splinearm.arrays import FloatArray
from splinearm.toolpaths.action import ArcFeed, Feed, Rapid
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.cutter import Cutter
from splinearm.toolpaths.offset import offset, rings
from splinearm.toolpaths.operation import Milling, Notes
from splinearm.toolpaths.pocket import pocket, pocket_runs
from splinearm.toolpaths.pocket_side import ContourSides
from splinearm.toolpaths.region import Region
from splinearm.toolpaths.spiral import spiral
from splinearm.toolpaths.zigzag import zigzag

RADIUS, STEP = 2e-3, 1.8e-3


def milling(step: float) -> Milling:
    """Give how the cutter is used."""
    cutter = Cutter(
        number=1, name="end mill", diameter=2.0 * RADIUS, feed=0.015, plunge=0.005,
        step_down=2e-3, step_over=step,
    )  # fmt: skip
    return Milling(cutter=cutter, depth=2e-3)


def uncut(part: Region, ways: list[Contour], looks: int = 200_000) -> float:
    """Give the area that the cutter reaches and leaves, mm2, by random looks."""
    from splinearm.toolpaths.contour_kernel import distances

    rng = np.random.default_rng(0)
    x0, y0, x1, y1 = part.bounds
    points = rng.uniform([x0, y0], [x1, y1], (looks, 2))
    points = points[part.contains(points)]
    reached = np.zeros(len(points), dtype=bool)
    for room in offset(part, -RADIUS):
        reached |= room.contains(points) | (room.distance(points) <= RADIUS * (1.0 - 1e-9))
    points = points[reached]
    pieces = np.ascontiguousarray(np.concatenate([way.packed()[0] for way in ways]))
    found: FloatArray = np.empty(len(points))
    distances(pieces, points, found)
    left = int((found > RADIUS * (1.0 + 1e-9)).sum())
    return left / looks * (x1 - x0) * (y1 - y0) * 1e6


def main() -> None:
    """Print the tables."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    print(f"{processor()}, Python {platform.python_version()}, {datetime.date.today()}")
    print(f"{os.cpu_count()} processors; tolerance of peers {TOLERANCE * 1e3} mm")
    part, setting = islands(), milling(STEP)
    steps = [-(RADIUS + k * STEP) for k in range(60)]
    steps = [d for d, found in zip(steps, rings(part, steps), strict=True) if found]
    makers = {"shapely": by_shapely(), "pyclipr": by_pyclipr()}
    peers = {name: work for name, work in makers.items() if work is not None}
    chains = [[work(part, d) for d in steps] for work in peers.values()]
    works = [
        lambda: rings(part, [*steps, steps[-1] - STEP]),
        lambda: pocket_runs(ContourSides(part), setting, Notes()),
        lambda: pocket([part], setting),
        *(lambda runs=runs: [run() for run in runs] for runs in chains),
    ]
    times = shortest(*works, number=1, rounds=15)
    found = [c for ring in rings(part, steps) for region in ring for c in region.contours]
    runs = pocket_runs(ContourSides(part), setting, Notes())
    links = sum(track.link for run in runs for track in run.tracks)
    print(
        f"{len(steps)} rings, {len(found)} loops of {sum(len(c.bulges) for c in found)} lines and "
        f"arcs; {links} links, {len(runs)} ways down; "
        f"uncut {uncut(part, [t.path for run in runs for t in run.tracks]):.3f} mm2"
    )
    names = ("our rings", "linked", "as what a machine does", *peers)
    for name, time in zip(names, times, strict=True):
        print(f"{name:>24} {1e3 * time:9.2f} ms, {time / times[2]:6.1f} of the whole of ours")
    print(f"\n{'':>12} {'step mm':>8} {'ms':>8} {'cut mm':>9} {'lifts':>6} {'uncut mm2':>10}")
    for name, kind in (("pocket", pocket), ("zigzag", zigzag), ("spiral", spiral)):
        for step in (1.8e-3, 2.8e-3, 4.0e-3):
            own = milling(step)
            (time,) = shortest(lambda: kind([part], own), number=1, rounds=3)  # noqa: B023
            actions = kind([part], own).actions
            cuts = [a for a in actions if isinstance(a, Feed | ArcFeed) and a.end[2] == a.start[2]]
            ways = [
                Contour(
                    np.array([a.start[:2], a.end[:2]]),
                    np.array([np.tan(0.25 * a.turn) if isinstance(a, ArcFeed) else 0.0]),
                    closed=False,
                )
                for a in cuts
            ]
            lifts = sum(isinstance(a, Rapid) and a.end[2] > a.start[2] for a in actions)
            print(
                f"{name:>12} {step * 1e3:8.1f} {1e3 * time:8.1f} "
                f"{1e3 * sum(a.length for a in cuts):9.0f} {lifts:6d} {uncut(part, ways):10.3f}"
            )


if __name__ == "__main__":
    main()
