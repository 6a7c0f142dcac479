"""A surface with its principal directions, and another at a distance from it."""

import numpy as np
from matplotlib.figure import Figure
from style import BLUE, GREEN, GREY, MM, RED, WIDTH, draw_curve, save, space, styled

from splinearm.curves.surface import BSplineSurface
from splinearm.curves.surface_offset import OffsetSurface
from splinearm.curves.surface_shape import curvatures

KNOTS = np.array((0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0))
HEIGHTS = np.array([(0, 10, 0, -10), (15, 45, 15, -5), (10, 30, 5, -15), (-5, 0, -20, -25)])
LONG = 5 * MM


@styled
def draw() -> Figure:
    """Draw directions of largest and smallest curvature, and an offset."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    x, y = np.meshgrid(np.linspace(0.0, 100.0, 4), np.linspace(0.0, 75.0, 4), indexing="ij")
    surface = BSplineSurface(KNOTS, KNOTS, np.stack((x, y, HEIGHTS), axis=2) * MM, 3, 3)
    u = np.linspace(0.0, 1.0, 25)
    net = surface.grid(u, u)[:, :, 0, 0]
    moved = OffsetSurface(surface, 12 * MM)
    left = space(figure, 121, "principal directions")
    right = space(figure, 122, "an offset of 12 mm")
    for axes in (left, right):
        for i in range(0, 25, 4):
            draw_curve(axes, net[i], color=GREY, linewidth=0.6)
            draw_curve(axes, net[:, i], color=GREY, linewidth=0.6)
    for i in range(0, 25, 4):
        draw_curve(right, moved.at(np.full(25, u[i]), u), color=BLUE, linewidth=0.9)
        draw_curve(right, moved.at(u, np.full(25, u[i])), color=BLUE, linewidth=0.9)
    a, b = (grid.ravel() for grid in np.meshgrid(np.linspace(0.08, 0.92, 7), u[2::5]))
    found = curvatures(surface, a, b)
    for k, colour in ((0, RED), (1, GREEN)):
        for place, way in zip(surface.at(a, b), found.directions[:, k], strict=True):
            draw_curve(left, (place - LONG * way, place + LONG * way), color=colour, linewidth=1.1)
    for axes in (left, right):
        axes.set_aspect("equal")
        axes.set(xticks=(0, 50, 100), yticks=(0, 50), zticks=(-20, 0, 20))
        axes.view_init(elev=50, azim=-65)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
