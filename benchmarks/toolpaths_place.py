"""Placing toolpaths before an arm: the choice of turns and branches, and planning of programs.

Run with ``python benchmarks/toolpaths_place.py``; ``--quick`` leaves out the longest programs.
"""

import argparse
import time
from collections.abc import Callable
from itertools import pairwise

import numpy as np
from kinematics_forward import processor

from splinearm import load_cell
from splinearm.arrays import FloatArray
from splinearm.toolpaths.action import Feed
from splinearm.toolpaths.placing import place
from splinearm.toolpaths.program import plan_program
from splinearm.toolpaths.setting import standing
from splinearm.toolpaths.turn_search import TurnQuestion, search_turns, solver_of

PLACES, TURNS = 10_000, 72
WANTED_S = 2.0
X, DOWN = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, -1.0])


def figure(count: int, radius: float, swing: float, waves: float) -> FloatArray:
    """Give places of a closed wavy curve on level work, shape (count, 3), m."""
    t = np.linspace(0.0, 2.0 * np.pi, count)
    r = radius + swing * np.cos(waves * t)
    return np.stack((0.25 + r * np.cos(t), r * np.sin(t), np.full(count, 0.08)), axis=1)


def timed(work: Callable[[], object], rounds: int) -> float:
    """Give the shortest time of some rounds, s."""
    found = []
    for _ in range(rounds):
        begin = time.perf_counter()
        work()
        found.append(time.perf_counter() - begin)
    return min(found)


def search() -> None:
    """Measure the choice of turns and branches."""
    cell = load_cell("wx250s")
    p = figure(PLACES, 0.06, 0.02, 9.0)
    s = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))))
    asked = TurnQuestion(p=p, s=s, R=standing(X, DOWN, 0.0), axis=X, turns=TURNS)
    home = cell.poses["home"]
    solve = solver_of(cell.arm, home)
    answer = search_turns(cell.arm, asked, home, solve)  # compiles
    took = timed(lambda: search_turns(cell.arm, asked, home, solve), 5)
    jump = np.degrees(np.abs(np.diff(answer.q, axis=0)).max())
    print(f"{PLACES} places x {TURNS} turns x 8 branches on {cell.arm.name}, six joints:")
    print(f"  {took:.2f} s, wanted {WANTED_S:g} s; {len(answer.q)} places followed; ", end="")
    print(f"largest step of a joint {jump:.2f} deg")
    print("  peer: Descartes (ROS-Industrial) is no Python package: not run here")


def programs(counts: list[int]) -> None:
    """Measure the planning of programs of short lines."""
    cell = load_cell("wx250s")
    print(
        f"{'lines':>7} {'corners':>10} {'mm each':>8} {'place s':>8} {'plan s':>8} {'motion s':>9}"
    )
    work = np.eye(4)
    for count in counts:
        for words, blend in (("0.02 mm", 2e-5), ("exact", None)):
            if blend is None and count > 1000:
                continue
            p = figure(count + 1, 0.03, 0.008, max(3.0, count // 200))
            ways = [
                Feed(line=i + 1, start=a, end=b, feed=0.02, blend=blend)
                for i, (a, b) in enumerate(pairwise(p))
            ]
            begin = time.perf_counter()
            placed = place(ways, work, cell.arm, cell.poses["home"])
            middle = time.perf_counter()
            parts = plan_program(placed)
            end = time.perf_counter()
            motion = parts[0].plan.trajectory.duration
            each = np.linalg.norm(np.diff(p, axis=0), axis=1).mean() * 1e3
            print(
                f"{count:7d} {words:>10} {each:8.3f} {middle - begin:8.2f} {end - middle:8.2f} "
                f"{motion:9.1f}"
            )


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="leave out the longest programs")
    quick = parser.parse_args().quick
    print(f"{processor()}, {time.strftime('%Y-%m-%d')}")
    search()
    programs([100, 1000] if quick else [100, 1000, 5000])


if __name__ == "__main__":
    main()
