"""Maps of where an arm reaches, as files and as pictures."""

import csv
from pathlib import Path
from typing import Any

import numpy as np

from splinearm.kinematics.reach import ReachMap
from splinearm.units import MM

_VIEWS = ((0, 1), (0, 2), (1, 2))


def write_reach(file: Path, reached: ReachMap) -> None:
    """Write a map to a file: numpy arrays (.npz, SI) or a table (.csv, mm), by its name's end."""
    if file.suffix == ".npz":
        np.savez_compressed(
            file,
            points=reached.points,
            quats=reached.quats,
            reached=reached.reached,
            fraction=reached.fraction,
            manipulability=reached.manipulability,
            spacing=reached.spacing,
            arm=reached.arm,
        )
        return
    with file.open("w", encoding="utf-8", newline="") as stream:
        rows = csv.writer(stream)
        rows.writerow(("x_mm", "y_mm", "z_mm", "reached", "fraction", "manipulability"))
        for p, met, fraction, value in zip(
            reached.points,
            reached.reached,
            reached.fraction,
            reached.manipulability,
            strict=True,
        ):
            share = "" if np.isnan(fraction) else f"{fraction:.6g}"
            rows.writerow((*(f"{x:.6g}" for x in p / MM), int(met), share, f"{value:.6g}"))


def plot_reach(file: Path, reached: ReachMap) -> None:
    """Draw a map from above, from the front and from the side, in the best of each line of sight.

    Colours show the share of orientations that can be had, or, if none were tried, the
    manipulability as a share of the best.
    """
    from matplotlib.figure import Figure

    shown, label = _shown(reached)
    figure = Figure(figsize=(14.0, 5.0), layout="constrained")
    figure.suptitle(f"Where {reached.arm} reaches")
    image: Any = None
    # squares that touch: a panel is about 240 points wide
    widest = float(np.ptp(reached.points, axis=0).max()) + reached.spacing
    size = (240.0 * reached.spacing / widest) ** 2 if widest > 0.0 else 14.0
    for place, (i, j) in enumerate(_VIEWS, start=1):
        axes: Any = figure.add_subplot(1, 3, place)
        across, up, best = _seen(reached, shown, i, j)
        image = axes.scatter(
            across / MM, up / MM, c=best, s=size, marker="s", cmap="viridis", vmin=0.0, vmax=1.0
        )
        axes.plot([0.0], [0.0], "k+", markersize=12.0)
        axes.set(xlabel=f"{'xyz'[i]} / mm", ylabel=f"{'xyz'[j]} / mm", aspect="equal")
    figure.colorbar(image, ax=figure.axes, label=label, shrink=0.8)
    figure.savefig(file, dpi=130)


def _shown(reached: ReachMap) -> "tuple[np.ndarray[Any, Any], str]":
    if len(reached.quats):
        return reached.fraction, f"share of {len(reached.quats)} orientations"
    best = float(reached.manipulability.max(initial=0.0))
    return reached.manipulability / (best or 1.0), "manipulability / best"


def _seen(
    reached: ReachMap, shown: "np.ndarray[Any, Any]", i: int, j: int
) -> "tuple[np.ndarray[Any, Any], ...]":
    """Give the reached points along two axes, and the best of each line of sight."""
    points = reached.points[reached.reached][:, (i, j)]
    cells, where = np.unique(np.round(points, 9), axis=0, return_inverse=True)
    best = np.zeros(len(cells))
    np.maximum.at(best, where.ravel(), shown[reached.reached])
    return cells[:, 0], cells[:, 1], best
