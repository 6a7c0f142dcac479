"""Where curves meet each other and themselves, and the nearest places to points."""

import numpy as np
from matplotlib.figure import Figure
from style import BLUE, GREEN, INK, MM, RED, WIDTH, draw_curve, plane, save, styled

from splinearm.curves import BSpline, interpolate
from splinearm.curves.conic import ellipse
from splinearm.curves.meeting import meet_curves, meet_itself
from splinearm.curves.plane import Plane
from splinearm.curves.projection import nearest_point

LOOP = np.array([(0, 0), (60, 35), (70, 60), (45, 65), (40, 40), (75, 10), (115, 30)]) * MM


def places(curve: BSpline) -> np.ndarray:
    """Give places along a curve."""
    return curve.at(np.linspace(*curve.domain, 150))


@styled
def draw() -> Figure:
    """Draw a curve with a loop, an ellipse that it crosses, and ways to nearest places."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    curve = interpolate(LOOP)
    ring = ellipse(0.05, 0.018, Plane.turned(np.array((60.0, 30.0)) * MM, 0.35))
    draw_curve(left, places(ring), color=GREEN, linewidth=1.2)
    draw_curve(left, places(curve), color=BLUE)
    for found, colour, marker in (
        (meet_curves(curve, ring).points, RED, "o"),
        (meet_itself(curve).points, INK, "s"),
    ):
        draw_curve(left, found, color=colour, marker=marker, linestyle="", zorder=5)
    plane(left, "meetings of two curves; of one with itself")
    asked = np.array([(x, y) for x in range(0, 121, 20) for y in range(0, 61, 20)]) * MM
    found = nearest_point(curve, asked)
    for point, foot in zip(asked, found.points, strict=True):
        draw_curve(right, (point, foot), color=RED, linewidth=0.8)
    draw_curve(right, places(curve), color=BLUE)
    draw_curve(right, asked, color=INK, marker=".", linestyle="")
    plane(right, "nearest places")
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
