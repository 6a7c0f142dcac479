"""Curvature along a curve, and the places where something happens."""

import numpy as np
from matplotlib.figure import Figure
from style import BLUE, FAINT, GREEN, MM, RED, WIDTH, draw_curve, legend_below, plane, save, styled

from splinearm.curves import interpolate
from splinearm.curves.curvature import curvature, frenet
from splinearm.curves.feature import curvature_extrema, inflections

POINTS = np.array([(0, 0), (15, 40), (50, 45), (65, 10), (100, 0), (125, 30), (110, 60)]) * MM


@styled
def draw() -> Figure:
    """Draw a curve with its curvature as a comb, and the curvature by arc length."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    curve = interpolate(POINTS, degree=5)
    u = np.linspace(*curve.domain, 71)
    places, bend = curve.at(u), curvature(curve, u)
    teeth = places - 3e-4 * bend[:, None] * frenet(curve, u).normal
    for foot, tip in zip(places, teeth, strict=True):
        draw_curve(left, (foot, tip), color=FAINT, linewidth=0.7)
    draw_curve(left, teeth, color=FAINT, linewidth=0.7)
    draw_curve(left, places, color=BLUE)
    right.axhline(0.0, color=FAINT, linewidth=0.8)
    right.plot(u / MM, bend, color=BLUE)
    for found, colour, marker, label in (
        (curvature_extrema(curve).u, RED, "^", "extrema of curvature"),
        (inflections(curve).u, GREEN, "o", "inflections"),
    ):
        look = {"color": colour, "marker": marker, "linestyle": "", "label": label, "zorder": 4}
        draw_curve(left, curve.at(found), **look)
        right.plot(found / MM, curvature(curve, found), **look)
    plane(left, "the comb shows the curvature")
    legend_below(left, 2)
    right.set(xlabel="u / mm (chord lengths)", ylabel="curvature / (1/m)", title="left is positive")
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
