"""Weights: what one of them does to a curve, and a projective map of a circle."""

import numpy as np
from matplotlib.figure import Figure
from style import (
    BLUE,
    GREEN,
    MM,
    POLYGON,
    RED,
    WIDTH,
    draw_curve,
    legend_below,
    plane,
    save,
    styled,
)

from splinearm.curves import BSpline
from splinearm.curves.conic import circle

POINTS = np.array([(0, 0), (15, 45), (55, 55), (80, -10), (120, 20)]) * MM
KNOTS = np.array([0, 0, 0, 0, 1, 2, 2, 2, 2], dtype=np.float64)


@styled
def draw() -> Figure:
    """Draw a curve with three weights of one point, and a circle seen in perspective."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    draw_curve(left, POINTS, **POLYGON)
    for weight, colour in ((0.3, GREEN), (1.0, BLUE), (4.0, RED)):
        curve = BSpline(KNOTS, POINTS, 3, np.array([1.0, 1.0, weight, 1.0, 1.0]))
        places = curve.at(np.linspace(0.0, 2.0, 150))
        draw_curve(left, places, color=colour, label=f"weight {weight:g}")
    plane(left, "the weight of the third point")
    legend_below(left)
    ring = circle(0.03)
    seen = ring.mapped([[1.0, 0.3, 0.07], [0.0, 0.8, 0.02], [4.0, 6.0, 1.0]])
    for curve, colour, label in ((ring, BLUE, "circle"), (seen, RED, "its projection")):
        draw_curve(right, curve.points, **POLYGON)
        draw_curve(right, curve.at(np.linspace(0.0, 1.0, 150)), color=colour, label=label)
    plane(right, "a projective map: exact, weights change")
    legend_below(right, 2)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
