"""Offsets of lines and arcs beside shapely, Clipper1 (pyclipper) and Clipper2 (pyclipr).

Run it on one core, for example ``taskset -c 1 python benchmarks/toolpaths_offset.py``. Pockets are
star-shaped, of radius 100 mm, every second segment an arc. Ours is exact, its check included;
peers take and give lines, of chords within the tolerance, and none of them checks. Each figure is
the best of several calls, the first left out; what counts is the ratio within one run.
"""

import argparse
import datetime
import os
import platform
from collections.abc import Callable

import numpy as np
from kinematics_forward import imported, processor, shortest

from splinearm.errors import ContourError
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.offset import Offsets, offset, rings
from splinearm.toolpaths.region import Region

TOLERANCE = 1e-6
"""What peers may be off by, m."""

Work = Callable[[Region, float], Callable[[], object]]


def star(n: int, seed: int = 0, radius: float = 0.1) -> Region:
    """Give a valid pocket of n segments."""
    rng = np.random.default_rng(seed)
    angle = 2.0 * np.pi * (np.arange(n) + rng.uniform(-0.3, 0.3, n)) / n
    far = np.ones(n)
    for k in range(2, 9):
        far += 0.25 / k * rng.uniform(-1, 1) * np.cos(k * angle + rng.uniform(0.0, 6.3))
    far *= radius * (1.0 + min(0.25, 4.0 * np.pi / n) * rng.uniform(-1, 1, n))
    points = far[:, None] * np.stack((np.cos(angle), np.sin(angle)), axis=1)
    bulges = np.where(np.arange(n) % 2, 0.0, rng.uniform(-0.4, 0.4, n))
    while True:
        try:
            return Region(Contour(points, bulges))
        except ContourError:
            bulges = 0.7 * bulges


def islands() -> Region:
    """Give a pocket of 200 x 120 mm with six islands, 17 rings of a cutter of 2 mm radius."""
    outer = Contour.rectangle([0.0, 0.0], [0.2, 0.12], 0.0)
    circles = [((0.108, 0.04), 0.011), ((0.074, 0.045), 0.008), ((0.148, 0.027), 0.008)]
    rectangles = [
        ((0.067, 0.066), (0.03, 0.031), 0.005),
        ((0.031, 0.036), (0.028, 0.029), 0.005),
        ((0.157, 0.06), (0.018, 0.019), 0),
    ]
    round_ones = [Contour.circle(spot, radius) for spot, radius in circles]
    square = [Contour.rectangle(spot, size, radius) for spot, size, radius in rectangles]
    return Region(outer, (*round_ones, *square))


def by_shapely() -> Work | None:
    """Give the same by shapely, or nothing."""
    if imported("shapely") is None:
        return None
    import shapely

    def work(part: Region, d: float) -> Callable[[], object]:
        chords = [contour.flattened(0.5 * TOLERANCE) for contour in part.contours]
        polygon = shapely.Polygon(chords[0], chords[1:])
        step = 2.0 * np.arccos(1.0 - 0.5 * TOLERANCE / abs(d))
        turns = max(1, int(np.ceil(0.5 * np.pi / step)))
        return lambda: shapely.buffer(polygon, d, quad_segs=turns)

    return work


def by_pyclipper() -> Work | None:
    """Give the same by Clipper1, or nothing."""
    if imported("pyclipper") is None:
        return None
    import pyclipper

    def work(part: Region, d: float) -> Callable[[], object]:
        chords = [contour.flattened(0.5 * TOLERANCE) * 1e9 for contour in part.contours]
        paths = [chord.round().astype(np.int64).tolist() for chord in chords]

        def run() -> object:
            maker = pyclipper.PyclipperOffset(2.0, 0.5 * TOLERANCE * 1e9)
            maker.AddPaths(paths, pyclipper.JT_ROUND, pyclipper.ET_CLOSEDPOLYGON)
            return maker.Execute(d * 1e9)

        return run

    return work


def by_pyclipr() -> Work | None:
    """Give the same by Clipper2, or nothing."""
    if imported("pyclipr") is None:
        return None
    import pyclipr

    def work(part: Region, d: float) -> Callable[[], object]:
        chords = [contour.flattened(0.5 * TOLERANCE) for contour in part.contours]

        def run() -> object:
            maker = pyclipr.ClipperOffset()
            maker.scaleFactor = int(1e9)
            maker.arcTolerance = 0.5 * TOLERANCE * 1e9
            maker.addPaths(chords, pyclipr.JoinType.Round, pyclipr.EndType.Polygon)
            return maker.execute(d)

        return run

    return work


def ours(part: Region, d: float) -> Callable[[], object]:
    """Give our offset with all it needs made anew, and checked."""
    return lambda: Offsets(part).at(d)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--largest", type=int, default=10000, help="segments of the largest pocket")
    largest = parser.parse_args().largest
    print(f"{processor()}, Python {platform.python_version()}, {datetime.date.today()}")
    print(f"{os.cpu_count()} processors; tolerance of peers {TOLERANCE * 1e3} mm")
    makers = {"shapely": by_shapely(), "pyclipper": by_pyclipper(), "pyclipr": by_pyclipr()}
    peers = {name: work for name, work in makers.items() if work is not None}
    offset(Contour.circle([0.0, 0.0], 1.0), -0.1)
    print(f"{'segments':>9} {'mm':>5} {'ours ms':>9} {'pieces':>7}", end="")
    print("".join(f" {name + ' ms':>14} {'ratio':>7}" for name in peers))
    sizes = [(50, 5), (1000, 1), (1000, 5), (10000, 1), (10000, 5), (30000, 1), (30000, 5)]
    for n, d_mm in sizes:
        if n > largest:
            continue
        part, d = star(n), -1e-3 * d_mm
        run = ours(part, d)
        works = [run, *(work(part, d) for work in peers.values())]
        best, *times = shortest(*works, number=20 if n < 100 else 1, rounds=5)
        pieces = sum(len(c.vertices) for region in run() for c in region.contours)
        print(f"{n:9d} {d_mm:5d} {1e3 * best:9.3f} {pieces:7d}", end="")
        print("".join(f" {1e3 * time:14.2f} {time / best:7.1f}" for time in times), flush=True)
    part = islands()
    steps = [-1e-3 * (2.0 + 1.8 * k) for k in range(60)]
    found = rings(part, steps)
    steps = [d for d, regions in zip(steps, found, strict=True) if regions]
    chains = [[work(part, d) for d in steps] for work in peers.values()]
    works = [lambda runs=runs: [run() for run in runs] for runs in chains]
    best, *times = shortest(lambda: rings(part, steps), *works, number=1, rounds=5)
    loops = [c for regions in found for region in regions for c in region.contours]
    pieces = sum(len(loop.vertices) for loop in loops)
    print(f"pocket with 6 islands: {len(steps)} rings, {len(loops)} loops, {pieces} lines and arcs")
    print(f"{'ours':>12} {1e3 * best:9.2f} ms")
    for name, time in zip(peers, times, strict=True):
        print(f"{name:>12} {1e3 * time:9.2f} ms, {time / best:.1f} times ours")


if __name__ == "__main__":
    main()
