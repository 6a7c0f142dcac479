"""Curves through points: what parametrisation and ends do."""

import numpy as np
from matplotlib.figure import Figure
from style import BLUE, GIVEN, GREEN, MM, RED, WIDTH, draw_curve, legend_below, plane, save, styled

from splinearm.curves import interpolate
from splinearm.curves.interpolation import EndDerivatives

POINTS = np.array([(0, 0), (20, 55), (30, 58), (40, 20), (90, 25), (95, 60), (130, 40)]) * MM


@styled
def draw() -> Figure:
    """Draw the same points with three parametrisations, and with three kinds of ends."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    for kind, colour in (("chord", BLUE), ("centripetal", GREEN), ("uniform", RED)):
        curve = interpolate(POINTS, parameters=kind)
        u = np.linspace(*curve.domain, 200)
        draw_curve(left, curve.at(u), color=colour, label=kind)
    plane(left, "parameters")
    east, south = np.array([[1.0, 0.0]]), np.array([[0.0, -1.0]])
    for ends, label, colour in (
        ("natural", "natural", BLUE),
        (EndDerivatives(east, south), "first derivatives given", GREEN),
        ("closed", "closed", RED),
    ):
        curve = interpolate(POINTS, ends=ends)
        draw_curve(right, curve.at(np.linspace(*curve.domain, 250)), color=colour, label=label)
    plane(right, "ends")
    for axes in (left, right):
        draw_curve(axes, POINTS, **GIVEN)
        legend_below(axes)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
