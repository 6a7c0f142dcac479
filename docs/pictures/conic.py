"""Conics that are exactly they, with their control points."""

from math import pi

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from style import BLUE, INK, MM, POLYGON, WIDTH, draw_curve, save, sketch, styled

from splinearm.curves import BSpline
from splinearm.curves.conic import circle, conic_piece, elliptic_arc, hyperbola, parabola


def draw_conic(axes: Axes, curve: BSpline, title: str) -> None:
    """Draw a conic and its control points with their weights."""
    draw_curve(axes, curve.points, **POLYGON)
    draw_curve(axes, curve.at(np.linspace(*curve.domain, 120)), color=BLUE)
    weights = np.ones(len(curve.points)) if curve.weights is None else curve.weights
    middle = (curve.points / MM).mean(axis=0)
    last = len(weights) - curve.is_closed()
    for point, weight in zip(curve.points[:last] / MM, weights, strict=False):
        away = (point - middle) / (np.linalg.norm(point - middle) + 1e-9)
        axes.annotate(
            f"{weight:.3g}", point, xytext=tuple((14.0, 10.0) * away), textcoords="offset points",
            ha="center", va="center", fontsize=7, color=INK,
        )  # fmt: skip
    sketch(axes, title, 20.0, margin=0.16)


@styled
def draw() -> Figure:
    """Draw six conics; the numbers are weights."""
    figure = Figure(figsize=(WIDTH, 4.4), layout="constrained")
    axes = figure.subplots(2, 3)
    draw_conic(axes[0, 0], circle(0.04), "circle")
    draw_conic(axes[0, 1], elliptic_arc((0.05, 0.03), 0.0, 1.2 * pi), "elliptic arc")
    draw_conic(axes[0, 2], parabola(0.01, -1.0, 2.5), "parabola")
    draw_conic(axes[1, 0], hyperbola((0.02, 0.015), -1.4, 1.4), "hyperbola, one branch")
    start, corner, end = (np.array(p) * MM for p in ((0, 0), (20, 60), (90, 0)))
    for place, share in ((axes[1, 1], 0.3), (axes[1, 2], 0.7)):
        through = (1.0 - share) * 0.5 * (start + end) + share * corner
        draw_conic(place, conic_piece(start, corner, end, through), "through a point")
        draw_curve(place, through[None], color=INK, marker="o", markersize=4)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
