"""Toolpaths as pictures: seen from above, coloured by feed and by pass."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.toolpaths.action import Action, ArcFeed, Cutting, Feed, Rapid, SplineFeed
from splinearm.units import MM

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_CHORDS = 48
_RAPID: dict[str, Any] = {"color": "0.75", "linewidth": 0.6, "linestyle": (0, (4, 3)), "zorder": 1}


def plot_toolpath(file: Path, actions: Iterable[Action], title: str) -> None:
    """Draw a toolpath twice, by feed and by depth, with its rapid ways, as PNG, SVG or PDF."""
    from matplotlib.figure import Figure

    known = tuple(actions)
    figure = Figure(figsize=(12.0, 6.0), layout="constrained")
    figure.suptitle(title)
    left, right = figure.subplots(1, 2)
    draw_toolpath(left, known, by="feed")
    draw_toolpath(right, known, by="depth")
    figure.savefig(file, dpi=150)


def draw_toolpath(axes: "Axes", actions: Iterable[Action], *, by: str) -> None:
    """Draw a toolpath from above, coloured by "feed" or "depth".

    Args:
        axes: Where it is drawn, in mm.
        actions: The toolpath.
        by: What the colours say.

    Raises:
        ValueError: If they are to say something else.
    """
    from matplotlib.collections import LineCollection

    if by not in ("feed", "depth"):
        raise ValueError(f"by: want 'feed' or 'depth', got {by!r}")
    lines: list[FloatArray] = []
    values: list[float] = []
    for action in actions:
        if isinstance(action, Rapid):
            places = np.array([action.start, action.end]) / MM
            axes.plot(places[:, 0], places[:, 1], **_RAPID)
        elif isinstance(action, Feed | ArcFeed | SplineFeed):
            places = _places(action)
            lines.append(places[:, :2] / MM)
            values.append(_feed(action) if by == "feed" else float(places[:, 2].min()) / MM)
    # deep passes lie on those above them
    drawn = LineCollection(
        [lines[i] for i in np.argsort(values)[::-1]] if by == "depth" else lines,
        array=np.sort(values)[::-1] if by == "depth" else np.array(values),
        cmap="viridis",
        linewidths=1.1,
        zorder=2,
    )
    axes.add_collection(drawn)
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    label = "feed / mm/min" if by == "feed" else "depth / mm"
    axes.set(xlabel="x / mm", ylabel="y / mm")
    axes.figure.colorbar(drawn, ax=axes, label=label, shrink=0.8)


def _feed(way: Cutting) -> float:
    return (way.feed or 0.0) * 60.0 / MM


def _places(way: "Feed | ArcFeed | SplineFeed") -> FloatArray:
    """Give places along a way, shape (k, 3), m."""
    match way:
        case ArcFeed():
            count = max(2, int(np.ceil(abs(way.turn) / (2.0 * np.pi) * _CHORDS)) + 1)
            return way.at(np.linspace(0.0, 1.0, count))
        case SplineFeed():
            first, last = way.curve.domain
            points: FloatArray = way.curve.at(np.linspace(first, last, _CHORDS))
            return points
        case _:
            return np.array([way.start, way.end])
