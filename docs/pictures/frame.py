"""Frames along a curve in space: that of Frenet beside the rotation-minimising one."""

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import NDArray
from style import BLUE, INK, RED, WIDTH, draw_curve, save, space, styled

from splinearm.curves import interpolate
from splinearm.curves.curvature import frenet
from splinearm.curves.frame import RotationMinimisingFrame

POINTS = [
    (0.0, 0.0, 0.0), (0.03, 0.02, 0.0), (0.06, -0.01, 0.01),
    (0.09, 0.01, 0.03), (0.12, 0.03, 0.02), (0.15, 0.0, 0.0),
]  # fmt: skip
LONG = 0.02


def draw_normals(axes: Axes3D, p: NDArray[np.float64], normal: NDArray[np.float64], c: str) -> None:
    """Draw a ribbon from a curve along its normals."""
    tips = p + LONG * normal
    for foot, tip in zip(p[::3], tips[::3], strict=True):
        draw_curve(axes, (foot, tip), color=c, linewidth=0.8)
    draw_curve(axes, tips, color=c, linewidth=0.8)
    draw_curve(axes, p, color=INK, linewidth=1.8)


@styled
def draw() -> Figure:
    """Draw the first normal of both frames along one curve."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    curve = interpolate(POINTS, degree=5)
    u = np.linspace(*curve.domain, 103)[1:-1]
    p = curve.at(u)
    minimal = RotationMinimisingFrame(curve, normal=np.array([0.0, 0.0, 1.0]))
    for place, normal, colour, title in (
        (121, frenet(curve, u).normal, RED, "Frenet: turns over at inflections"),
        (122, minimal.at(u)[..., 1], BLUE, "rotation-minimising"),
    ):
        axes = space(figure, place, title)
        draw_normals(axes, p, normal, colour)
        axes.set(xlim=(0, 150), ylim=(-35, 45), zlim=(-25, 55), xticks=(0, 50, 100, 150), ylabel="")
        axes.set(yticks=(-20, 0, 20, 40), zticks=(-20, 0, 20, 40))
        axes.set_box_aspect((150, 80, 80), zoom=1.1)
        axes.view_init(elev=28, azim=-70)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
