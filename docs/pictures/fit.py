"""Curves near many points: few control points within a tolerance, and smoothing of noise."""

import numpy as np
from matplotlib.figure import Figure
from style import (
    BLUE,
    GREY,
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

from splinearm.curves import interpolate
from splinearm.curves.approximation import approximate
from splinearm.curves.smoothing import smooth


@styled
def draw() -> Figure:
    """Draw an approximation of exact points and a smoothing spline of noisy ones."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    a = np.linspace(0.0, 2.0, 241)
    exact = np.stack((45.0 * a, 35.0 * np.sin(6.0 * a**1.5) * np.exp(-0.5 * a)), axis=1) * MM
    curve, off = approximate(exact, 0.5 * MM)
    draw_curve(left, exact[::4], color=GREY, marker=".", markersize=2.5, linestyle="")
    draw_curve(left, curve.points, **POLYGON)
    draw_curve(left, curve.at(np.linspace(*curve.domain, 200)), color=BLUE)
    count = len(curve.points)
    plane(left, f"{len(exact)} points, {count} control points: {off / MM:.2f} mm off")
    noise = np.random.default_rng(1).normal(0.0, 2.0 * MM, (61, 2))
    noisy = exact[::4] + noise * (0.2, 1.0)
    draw_curve(right, noisy, color=GREY, marker=".", markersize=3.5, linestyle="")
    for made, colour, label, width in (
        (interpolate(noisy), RED, "interpolate", 0.8),
        (smooth(noisy), BLUE, "smooth", 1.6),
    ):
        places = made.at(np.linspace(*made.domain, 400))
        draw_curve(right, places, color=colour, linewidth=width, label=label)
    plane(right, "noisy points")
    legend_below(right)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
