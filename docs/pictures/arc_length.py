"""Even steps of a curve's parameter beside even steps of its arc length."""

import numpy as np
from matplotlib.figure import Figure
from style import BLUE, MM, RED, SKY, WIDTH, draw_curve, legend_below, plane, save, styled

from splinearm.curves import BSpline
from splinearm.curves.natural import NaturalCurve

POINTS = np.array([(0, 0), (5, 5), (10, 60), (45, 60), (60, 5), (125, 5), (110, 50)]) * MM
KNOTS = np.array([0, 0, 0, 0, 1, 2, 3, 4, 4, 4, 4], dtype=np.float64)


@styled
def draw() -> Figure:
    """Draw marks at even steps, and the speed by either parameter."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    curve = BSpline(KNOTS, POINTS, 3)
    natural = NaturalCurve(curve)
    u, s = np.linspace(0.0, 4.0, 150), np.linspace(0.0, natural.length, 150)
    draw_curve(left, curve.at(u), color=SKY, linewidth=1.0)
    for points, colour, marker, label in (
        (curve.at(np.linspace(0.0, 4.0, 25)), RED, "x", "25 even steps of u"),
        (natural.at(np.linspace(0.0, natural.length, 25)), BLUE, "o", "25 even steps of s"),
    ):
        draw_curve(left, points, color=colour, marker=marker, linestyle="", label=label)
    plane(left)
    legend_below(left, 2)
    share = u / u[-1]
    by_u = np.linalg.norm(curve.at(u, 1), axis=1) * u[-1] / natural.length
    by_s = np.linalg.norm(natural.at(s, 1), axis=1)
    right.plot(share, by_u, color=RED, label="by u")
    right.plot(share, by_s, color=BLUE, label="by s")
    right.set(xlabel="share of the domain", ylabel="speed / mean speed", ylim=(0.0, None))
    legend_below(right, 2)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
