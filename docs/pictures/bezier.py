"""De Casteljau's construction: a point of a Bezier curve, and its two halves."""

import numpy as np
from matplotlib.figure import Figure
from style import (
    BLUE,
    FAINT,
    GREEN,
    GREY,
    INK,
    MM,
    POLYGON,
    RED,
    WIDTH,
    draw_curve,
    plane,
    save,
    styled,
)

from splinearm.curves.bezier import Bezier

POINTS = np.array([(0, 0), (15, 55), (75, 65), (100, 5)]) * MM
SHARE = 0.4


@styled
def draw() -> Figure:
    """Draw the construction at one parameter, and the curve with one control point more."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    curve = Bezier(POINTS)
    u = np.linspace(0.0, 1.0, 80)
    draw_curve(left, POINTS, **POLYGON)
    level = POINTS
    while len(level) > 1:
        level = (1.0 - SHARE) * level[:-1] + SHARE * level[1:]
        draw_curve(left, level, color=GREY, linewidth=0.8, marker="o", markersize=3)
    for half, colour in zip(curve.split(SHARE), (BLUE, RED), strict=True):
        draw_curve(left, half.at(u), color=colour, linewidth=2.0)
        draw_curve(left, half.points, color=colour, linestyle="", marker="s", markersize=3.5)
    draw_curve(left, level, color=INK, linestyle="", marker="o", markersize=5)
    plane(left, f"split at u = {SHARE:g}: both halves' points")
    for times, colour in ((0, FAINT), (1, GREEN), (5, RED)):
        points = curve.elevated(times).points
        draw_curve(
            right, points, color=GREY if times == 0 else colour, marker="o", markersize=3.5,
            linewidth=0.8, label=f"degree {3 + times}",
        )  # fmt: skip
    draw_curve(right, curve.at(u), color=BLUE)
    plane(right, "the same curve in higher degrees")
    right.legend(loc="lower center")
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
