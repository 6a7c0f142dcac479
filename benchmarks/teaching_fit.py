"""Control points of motions led by hand, beside scipy's smoothing splines at the same tolerance.

The recordings are those of ``tests/teaching``: strokes, pauses, tremor, encoder steps, and samples
that are wrong. scipy gets them without the wrong ones and without still ends and pauses, and its
smoothing condition is the largest that keeps every sample within 1 mm and 0.5 deg. Run as::

    taskset -c 1 python benchmarks/teaching_fit.py
"""

import datetime
import platform
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from kinematics_forward import imported, processor

from splinearm.config import Cell, load_cell
from splinearm.teaching.fitting import fit_recording
from splinearm.teaching.noise import clean
from splinearm.teaching.recording import Nearness, Recording, Ruler
from splinearm.teaching.rest import RestRule, find_moving

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "teaching"))

_HALVINGS = 22
_SEEDS = range(5)


def scipy_points(
    make: Callable[..., tuple], cell: Cell, t: np.ndarray, q: np.ndarray
) -> tuple[int, float]:
    """Give how many control points scipy needs, and how long one fit takes, s."""
    ruler = Ruler(cell.arm, Nearness())
    free = clean(t, q, ruler.joint)
    q = q.copy()
    q[free.wrong] = free.curve.at(t[free.wrong])
    moving = find_moving(t, q, free.curve, ruler, cell.arm, RestRule())
    u = moving.times(t)
    part = q[moving.ends[0] : moving.ends[1] + 1]
    u, first = np.unique(np.round(u, 4), return_index=True)
    part = part[first]
    low, high, best, lasts = -12.0, 3.0, 0, 0.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        begun = time.perf_counter()
        curve, _ = make(part.T, u=u, s=10.0**middle, k=3)
        lasts = time.perf_counter() - begun
        if ruler.misses(np.asarray(curve(u)).T, part).max() <= 1.0:
            low, best = middle, len(curve.t) - 4
        else:
            high = middle
    return best, lasts


def main() -> None:
    """Print the table."""
    from conftest import Hand

    print(f"{processor()}, Python {platform.python_version()}, {datetime.date.today()}")
    scipy = imported("scipy.interpolate")
    print(f"{'arm':12} {'samples':>8} {'ours':>6} {'s':>6} {'scipy':>6} {'ratio':>6}")
    for name in ("planar_2r", "wx250s"):
        cell = load_cell(name)
        for seed in _SEEDS:
            led = Hand(seconds=20.0, pauses=2, wrong=4).leads(cell, seed)
            recording = Recording(names=cell.arm.joint_names, t=led.t, q=led.q)
            begun = time.perf_counter()
            fitted = fit_recording(recording, cell.arm)
            lasts = time.perf_counter() - begun
            theirs = 0
            if scipy is not None:
                theirs, _ = scipy_points(scipy.make_splprep, cell, led.t, led.q)
            ratio = f"{theirs / fitted.points:.2f}" if theirs else "-"
            line = f"{name:12} {fitted.samples:8} {fitted.points:6} {lasts:6.1f}"
            print(f"{line} {theirs or '-':>6} {ratio:>6}", flush=True)


if __name__ == "__main__":
    main()
