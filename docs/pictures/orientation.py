"""Curves through orientations: slerps, squad and the cumulative B-spline."""

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from style import (
    BLUE,
    FAINT,
    GIVEN,
    ORANGE,
    RED,
    WIDTH,
    draw_curve,
    legend_below,
    save,
    space,
    styled,
)

from splinearm.kinematics import quaternion
from splinearm.trajectories import interpolate_orientations
from splinearm.trajectories.rotation_polyline import RotationPolyline
from splinearm.trajectories.squad import Squad

U = np.array((0.0, 1.0, 2.5, 3.5, 5.0))
QUATS = quaternion.exp(
    [(0.0, 0.0, 0.0), (0.3, 0.9, 0.2), (1.2, 0.8, 0.9), (0.6, 0.0, 1.7), (-0.4, 0.5, 2.2)]
)


def draw_ball(axes: Axes3D) -> None:
    """Draw some circles of a ball of radius 1."""
    a = np.linspace(0.0, 2.0 * np.pi, 73)
    for height in (-0.5, 0.0, 0.5, 0.85):
        r = np.sqrt(1.0 - height**2)
        axes.plot(r * np.cos(a), r * np.sin(a), np.full(73, height), color=FAINT, linewidth=0.5)
    for turn in np.arange(4) * np.pi / 4:
        x, y = np.cos(a) * np.cos(turn), np.cos(a) * np.sin(turn)
        axes.plot(x, y, np.sin(a), color=FAINT, linewidth=0.5)


@styled
def draw() -> Figure:
    """Draw where an axis of the body points, and angular speed and acceleration."""
    figure = Figure(figsize=(WIDTH, 3.4), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.2))
    ball = space(figure, grid[:, 0], "where the x axis points")
    ball.set_axis_off()
    draw_ball(ball)
    speed, change = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    slerps = RotationPolyline(U, QUATS, np.zeros(len(U)))
    u = np.unique(np.concatenate((np.linspace(0.0, 5.0, 161), U - 1e-9, U + 1e-9)))[1:-1]
    for curve, colour, label in (
        (slerps, ORANGE, "slerps: C0"),
        (Squad(U, QUATS), RED, "squad: C1"),
        (interpolate_orientations(U, QUATS), BLUE, "B-spline: C2"),
    ):
        turning = curve.at(u)
        axis = quaternion.rotate(turning.quat, np.array((1.0, 0.0, 0.0)))
        draw_curve(ball, axis * 1e-3, color=colour, linewidth=1.4)
        look = {"color": colour, "linewidth": 1.3, "label": label}
        speed.plot(u, np.linalg.norm(turning.omega, axis=1), **look)
        change.plot(u, np.linalg.norm(turning.alpha, axis=1), **look)
    given = quaternion.rotate(QUATS, np.array((1.0, 0.0, 0.0)))
    draw_curve(ball, given * 1e-3, **GIVEN)
    ball.set_box_aspect((1.0, 1.0, 1.0), zoom=1.45)
    ball.view_init(elev=20, azim=50)
    speed.set(ylabel="turn rate / (rad/unit)", xticklabels=[])
    change.set(ylabel="its change / (rad/unit²)", xlabel="u")
    for axes in (speed, change):
        axes.set_xticks(U)
    legend_below(change, drop=0.38)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
