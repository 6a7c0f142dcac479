"""An equation of second degree: what it is, what meets it, what touches it."""

import numpy as np
from matplotlib.figure import Figure
from style import BLUE, GREEN, GREY, INK, MM, RED, WIDTH, draw_curve, plane, save, styled

from splinearm.curves.conic_equation import ConicEquation


@styled
def draw() -> Figure:
    """Draw an ellipse and a hyperbola from their equations in mm."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    ellipse = ConicEquation([5.0, 4.0, 8.0, -320.0, -560.0, 8000.0])
    form = ellipse.form()
    draw_curve(left, form.curve().at(np.linspace(0.0, 1.0, 150)) * MM, color=BLUE)
    for end in form.plane.points([(form.a, 0.0), (0.0, form.b)]):
        axis = np.array((end, 2.0 * form.centre - end)) * MM
        draw_curve(left, axis, color=GREY, linewidth=0.8, linestyle="--")
    draw_curve(left, form.foci * MM, color=INK, marker="+", linestyle="", markersize=7)
    outside = np.array((75.0, 30.0))
    for touched in ellipse.tangents_from(outside):
        draw_curve(left, np.array((outside, touched)) * MM, color=GREEN, linewidth=1.1)
        draw_curve(left, touched[None] * MM, color=GREEN, marker="o")
    met = ellipse.meet_line([0.0, 20.0], [1.0, 0.35]).points
    line = np.array([(-15.0, 20.0 - 15.0 * 0.35), (70.0, 20.0 + 70.0 * 0.35)])
    draw_curve(left, line * MM, color=RED, linewidth=1.1)
    draw_curve(left, met * MM, color=RED, marker="o", linestyle="")
    plane(left, "axes, foci, tangents, a line")
    hyperbola = ConicEquation([1.0, -3.0, -1.0, 0.0, 0.0, -400.0]).form()
    for branch in (1, -1):
        draw_curve(right, hyperbola.curve(-1.6, 1.6, branch).at(np.linspace(0, 1, 60)) * MM)
        right.lines[-1].set_color(BLUE)
    for point, direction in hyperbola.lines:
        ends = np.array((point - 55.0 * direction, point + 55.0 * direction)) * MM
        draw_curve(right, ends, color=GREY, linewidth=0.8, linestyle="--")
    draw_curve(right, hyperbola.foci * MM, color=INK, marker="+", linestyle="", markersize=7)
    plane(right, f"{hyperbola.kind.value}: asymptotes, foci")
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
