"""Changes that change nothing: knots put in, Bezier pieces; and knots taken out in a tolerance."""

import numpy as np
from matplotlib.figure import Figure
from style import BLUE, MM, POLYGON, RED, WIDTH, draw_curve, save, sketch, styled

from splinearm.curves import BSpline
from splinearm.curves.removal import remove_knots

POINTS = np.array([(0, 0), (10, 50), (45, 60), (60, 5), (95, 5), (110, 55), (150, 45)]) * MM
KNOTS = np.array([0, 0, 0, 0, 1, 2, 3, 4, 4, 4, 4], dtype=np.float64)


@styled
def draw() -> Figure:
    """Draw a cubic in four ways; the last one is another curve."""
    figure = Figure(figsize=(WIDTH, 3.8), layout="constrained")
    axes = figure.subplots(2, 2)
    curve = BSpline(KNOTS, POINTS, 3)
    without, off = remove_knots(curve, [2.0], tolerance=0.02)
    u = np.linspace(0.0, 4.0, 150)
    for place, changed, title in (
        (axes[0, 0], curve, "as it was"),
        (axes[0, 1], curve.with_knots([0.5, 1.5, 2.5, 3.5]), "four knots more"),
        (axes[1, 0], curve.with_knots([1, 1, 2, 2, 3, 3]), "Bezier pieces: knots threefold"),
        (axes[1, 1], without, f"a knot less: at most {off / MM:.1f} mm off"),
    ):
        draw_curve(place, changed.points, **POLYGON)
        if changed is without:
            draw_curve(place, changed.at(u), color=RED)
        draw_curve(place, curve.at(u), color=BLUE, linewidth=0.9 if changed is without else 1.6)
        breaks = changed.at(changed.breaks)
        draw_curve(place, breaks, color=BLUE, marker="|", markersize=8, linestyle="")
        sketch(place, title, 20.0, margin=0.05)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
