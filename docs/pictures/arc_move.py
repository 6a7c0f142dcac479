"""Arcs: through a point, about an axis, and as a helix."""

import numpy as np
from matplotlib.figure import Figure
from motion import track
from style import (
    BLUE,
    GIVEN,
    GREEN,
    INK,
    ORANGE,
    RED,
    WIDTH,
    draw_curve,
    draw_limit,
    save,
    space,
    styled,
)

from splinearm import ArcAbout, ArcThrough, Facing, Move, Waypoint, load_cell, plan

A, B, C, D = np.array([(0.2, -0.1, 0.15), (0.2, 0.1, 0.15), (0.3, 0.1, 0.15), (0.3, 0.1, 0.25)])
VIA = np.array((0.27, 0.0, 0.15))


@styled
def draw() -> Figure:
    """Draw the way of the tool in space, and its speed."""
    figure = Figure(figsize=(WIDTH, 3.1), layout="constrained")
    grid = figure.add_gridspec(1, 2)
    cell = load_cell("wx250s")
    up = np.array((0.0, 0.0, 1.0))
    waypoints = [
        Waypoint(position=A, facing=Facing.KEPT),
        Waypoint(position=B, move=Move.ARC, arc=ArcThrough(VIA), speed=0.2, facing=Facing.KEPT),
        Waypoint(position=C, move=Move.LINE, speed=0.2, facing=Facing.KEPT),
        Waypoint(
            position=D, move=Move.ARC, arc=ArcAbout(0.5 * (B + C), up, turns=2), speed=0.2,
            facing=Facing.KEPT,
        ),
    ]  # fmt: skip
    motion = plan(cell.arm, waypoints, cell.poses["home"])
    tool = track(cell.arm, motion.trajectory, 900)
    axes = space(figure, grid[0])
    right = figure.add_subplot(grid[1])
    ends = [0.0, *motion.waypoint_times]
    looks = ((INK, "B-spline"), (RED, "arc"), (GREEN, "line"), (BLUE, "helix"))
    for i, (colour, label) in enumerate(looks):
        here = (tool.t >= ends[i]) & (tool.t <= ends[i + 1])
        draw_curve(axes, tool.p[here], color=colour, label=label)
        right.plot(tool.t[here], tool.speed[here] * 1e3, color=colour)
    draw_curve(axes, np.array((A, B, C, D)), **GIVEN)
    draw_curve(axes, VIA[None], color=ORANGE, marker="o", linestyle="", label="via")
    axes.set(xticks=(200, 250, 300), zticks=(150, 200, 250))
    axes.set_aspect("equal")
    axes.view_init(elev=30, azim=-125)
    axes.legend(loc="upper left", ncols=2)
    right.set(xlabel="t / s", ylabel="speed of the tool / (mm/s)", ylim=(0.0, 400.0))
    draw_limit(right, 200.0, "200 mm/s")
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
