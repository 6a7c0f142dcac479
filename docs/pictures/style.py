"""The look that all pictures of the pages share, and how they are written."""

import re
from collections.abc import Callable
from functools import wraps
from io import StringIO
from pathlib import Path
from typing import Any, cast

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import ArrayLike

MM = 1e-3

WIDTH = 7.2
"""Width of every picture, inches."""

# told apart with any kind of colour vision: Okabe and Ito, Color universal design, 2008
INK, GREY, FAINT = "#222222", "#8a8a8a", "#d5d5d5"
BLUE, ORANGE, GREEN, RED, PURPLE, SKY = (
    "#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9"
)  # fmt: skip
COLOURS = (BLUE, RED, GREEN, ORANGE, PURPLE, SKY, INK)

STYLE: dict[str, Any] = {
    "axes.axisbelow": True,
    "axes.edgecolor": GREY,
    "axes.grid": True,
    "axes.labelcolor": INK,
    "axes.prop_cycle": mpl.cycler(color=COLOURS),
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 9.5,
    "figure.facecolor": "white",
    "font.family": "DejaVu Sans",
    "font.size": 8.5,
    "grid.color": "#eeeeee",
    "grid.linewidth": 0.7,
    "legend.fontsize": 8.0,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "lines.linewidth": 1.6,
    "lines.markersize": 4.5,
    "path.simplify_threshold": 0.2,
    # the same picture is the same file, and needs no font where it is looked at
    "svg.fonttype": "path",
    "svg.hashsalt": "splinearm",
    "text.color": INK,
    "xtick.color": GREY,
    "xtick.labelcolor": INK,
    "ytick.color": GREY,
    "ytick.labelcolor": INK,
}

POLYGON: dict[str, Any] = {
    "color": GREY, "linewidth": 0.8, "marker": "o", "markersize": 3.5, "linestyle": "--"
}  # fmt: skip
"""How control points are drawn."""

GIVEN: dict[str, Any] = {
    "color": INK, "linestyle": "none", "marker": "o", "markersize": 4.5, "zorder": 5
}  # fmt: skip
"""How points are drawn that were asked for."""


def styled(draw: Callable[[], Figure]) -> Callable[[], Figure]:
    """Let a function draw in this look, whatever the caller's is."""

    @wraps(draw)
    def drawn() -> Figure:
        with mpl.rc_context({**mpl.rcParamsDefault, **STYLE, "backend": "agg"}):
            return draw()

    return drawn


def save(figure: Figure, script: str, folder: Path | None = None) -> Path:
    """Write a picture beside its script, or into a folder, under the script's name."""
    file = Path(script).with_suffix(".svg")
    if folder is not None:
        file = folder / file.name
    text = StringIO()
    with mpl.rc_context(STYLE):
        figure.draw_without_rendering()  # labels find their places in the second drawing
        figure.savefig(text, format="svg", metadata={"Date": None})
    # a hundredth of a point is finer than any screen: half the file is digits beyond it
    short = re.sub(r"(\d\d\.\d\d)\d+", r"\1", text.getvalue())
    file.write_text(re.sub(r"^ +| +$|<!--.*?-->\n", "", short, flags=re.MULTILINE), "utf-8")
    return file


def plane(axes: Axes, title: str = "") -> Axes:
    """Make axes those of a drawing to scale."""
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x / mm", ylabel="y / mm", title=title)
    return axes


def sketch(axes: Axes, title: str, bar_mm: float, margin: float = 0.12) -> Axes:
    """Make axes those of a small drawing to scale, with a bar that says how large it is."""
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(margin)
    axes.set_title(title)
    axes.axis("off")
    left, low = axes.dataLim.x0, axes.dataLim.y0
    drop = low - 0.22 * axes.dataLim.height
    axes.plot((left, left + bar_mm), (drop, drop), color=INK, linewidth=1.0, marker="|")
    axes.annotate(
        f"{bar_mm:g} mm", (left + bar_mm, drop), xytext=(5, 0), textcoords="offset points",
        va="center", fontsize=7.0,
    )  # fmt: skip
    return axes


def space(figure: Figure, place: int | SubplotSpec, title: str = "") -> Axes3D:
    """Give axes for a drawing in space."""
    axes = cast(Axes3D, figure.add_subplot(place, projection="3d"))
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.pane.set(facecolor="#fafafa", edgecolor=FAINT)
        axis.line.set_color(GREY)
    axes.set(xlabel="x / mm", ylabel="y / mm", zlabel="z / mm")
    axes.text2D(0.02, 0.97, title, transform=axes.transAxes, fontsize=9.5)
    axes.tick_params(labelsize=7.0, pad=0)
    return axes


def draw_curve(axes: Axes, points: ArrayLike, **look: object) -> None:
    """Draw points in m, shape (m, dim), as a line in mm."""
    axes.plot(*(np.asarray(points, dtype=np.float64).T / MM), **look)


def draw_limit(axes: Axes, value: float, label: str) -> None:
    """Draw a limit and write what it is at its right end."""
    axes.axhline(value, color=RED, linewidth=0.9, linestyle=(0, (4, 3)), zorder=1)
    axes.annotate(
        label, (1.0, value), xycoords=("axes fraction", "data"), xytext=(0, 2.5),
        textcoords="offset points", ha="right", va="bottom", color=RED, fontsize=7.5,
    )  # fmt: skip


def legend_below(axes: Axes, columns: int = 3, drop: float = 0.2) -> None:
    """Put the names of what is drawn below the axes, where they hide nothing."""
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -drop), ncols=columns, columnspacing=1.2)
