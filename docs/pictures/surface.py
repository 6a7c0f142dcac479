"""Surfaces made of curves."""

from math import pi

import numpy as np
from matplotlib.figure import Figure
from style import BLUE, GREY, INK, MM, RED, WIDTH, draw_curve, save, space, styled

from splinearm.curves import BSpline, interpolate
from splinearm.curves.conic import arc, circle
from splinearm.curves.coons import coons
from splinearm.curves.loft import lofted
from splinearm.curves.plane import Plane
from splinearm.curves.surface import BSplineSurface
from splinearm.curves.surface_of_curves import extruded, revolved, ruled
from splinearm.curves.sweep import swept

WAVE = np.array([(0, 0, 0), (25, 12, 0), (50, -8, 0), (80, 0, 0)]) * MM
UP = np.array((0.0, 0.0, 1.0))


def curve_of(*points: tuple[float, float, float]) -> BSpline:
    """Give the curve through points in mm."""
    return interpolate(np.array(points) * MM)


def loft() -> tuple[BSplineSurface, list[BSpline]]:
    """Give a surface through four circles, and these."""
    sections = [
        circle(r * MM, Plane.facing(np.array((x, 0.0, z)) * MM, UP, np.array((1.0, 0.0, 0.0))))
        for r, x, z in ((20, 0, 0), (10, 6, 25), (16, 0, 50), (24, -4, 70))
    ]
    return lofted(sections), sections


def patch() -> tuple[BSplineSurface, list[BSpline]]:
    """Give a surface between four curves, and these."""
    sides = [
        curve_of((0, 0, 0), (30, 0, 18), (80, 0, 0)),
        curve_of((0, 60, 12), (45, 60, -8), (80, 60, 12)),
        curve_of((0, 0, 0), (0, 30, 18), (0, 60, 12)),
        curve_of((80, 0, 0), (80, 30, -12), (80, 60, 12)),
    ]
    return coons(*sides), sides


@styled
def draw() -> Figure:
    """Draw six surfaces with the curves that they were made of."""
    figure = Figure(figsize=(WIDTH, 4.9), layout="constrained")
    wave, upper = BSpline([0, 0, 0, 0, 1, 1, 1, 1], WAVE, 3), curve_of((0, 20, 45), (80, -30, 45))
    vase = curve_of((12, 0, 0), (25, 0, 20), (10, 0, 45), (18, 0, 60))
    bow = arc(45 * MM, 0.0, 0.8 * pi, Plane.facing(np.zeros(3), np.array((0.0, -1.0, 0.3))))
    shown = (
        ("extruded", extruded(wave, np.array((0.0, 25.0, 40.0)) * MM), [wave]),
        ("ruled", ruled(wave, upper), [wave, upper]),
        ("revolved", revolved(vase, np.zeros(3), UP, 1.5 * pi), [vase]),
        ("swept", swept(circle(9 * MM), bow, 1e-5), [bow]),
        ("lofted", *loft()),
        ("coons", *patch()),
    )
    for place, (title, surface, curves) in enumerate(shown, start=1):
        axes = space(figure, 230 + place, title)
        (u0, u1), (v0, v1) = surface.domain
        us, vs = np.linspace(u0, u1, 25), np.linspace(v0, v1, 25)
        net = surface.grid(us, vs)[:, :, 0, 0]
        for i in range(0, 25, 4):
            draw_curve(axes, net[i], color=BLUE if i % 24 == 0 else GREY, linewidth=0.6)
            draw_curve(axes, net[:, i], color=BLUE if i % 24 == 0 else GREY, linewidth=0.6)
        for curve in curves:
            along = curve.at(np.linspace(*curve.domain, 40))
            draw_curve(axes, along, color=RED, linewidth=1.6)
        axes.set_aspect("equal")
        x, _, y, _, z, _ = axes.get_w_lims()
        axes.plot((x, x + 20.0), (y, y), (z, z), color=INK, linewidth=1.0)
        axes.text(x + 8.0, y, z, "20 mm", fontsize=7.0, ha="right", va="top")
        axes.set_axis_off()
        axes.view_init(elev=28, azim=-60)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
