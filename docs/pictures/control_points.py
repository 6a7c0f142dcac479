"""A B-spline, its control points, its basis functions, and what one point moves."""

import numpy as np
from matplotlib.figure import Figure
from style import BLUE, GREY, MM, POLYGON, RED, WIDTH, draw_curve, plane, save, styled

from splinearm.curves import BSpline
from splinearm.curves.box import convex_hull

POINTS = np.array([(0, 0), (10, 50), (45, 60), (60, 5), (95, 5), (110, 55), (150, 45)]) * MM
KNOTS = np.array([0, 0, 0, 0, 1, 2, 3, 4, 4, 4, 4], dtype=np.float64)
MOVED = 3


@styled
def draw() -> Figure:
    """Draw a cubic with one point moved, and its basis functions."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    curve = BSpline(KNOTS, POINTS, 3)
    points = POINTS.copy()
    points[MOVED] += np.array((0, -30)) * MM
    u = np.linspace(0.0, 4.0, 200)
    hull = convex_hull(curve)
    left.fill(*(hull / MM).T, color="#f4f4f4", zorder=0)
    draw_curve(left, BSpline(KNOTS, points, 3).at(u), color=RED, linewidth=1.1)
    draw_curve(left, POINTS, **POLYGON)
    draw_curve(left, points[[MOVED]], color=RED, marker="o", markersize=4)
    draw_curve(left, curve.at(u), color=BLUE)
    draw_curve(left, curve.at(curve.breaks), color=BLUE, marker="|", markersize=9, linestyle="")
    plane(left, "curve, control points, hull; one point moved")
    basis = BSpline(KNOTS, np.eye(7), 3).at(u)
    for i in range(7):
        chosen = i == MOVED
        right.plot(u, basis[:, i], color=RED if chosen else GREY, linewidth=2 if chosen else 1)
    right.set(xlabel="u", ylabel="weight of each control point", title="basis functions, degree 3")
    right.set_xticks(range(5))
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
