"""A joint move beside a straight line of the tool."""

import numpy as np
from matplotlib.figure import Figure
from motion import draw_flat_arm, track
from style import BLUE, GIVEN, RED, WIDTH, draw_curve, legend_below, plane, save, styled

from splinearm import Move, Waypoint, load_cell, plan

GOAL = np.array((0.12, 0.38, 0.06))


@styled
def draw() -> Figure:
    """Draw both ways of the tool, and of the joints."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    cell = load_cell("planar_2r")
    start = cell.poses["home"]
    for move, colour, label in ((Move.JOINT, BLUE, "joint move"), (Move.LINE, RED, "line")):
        motion = plan(cell.arm, [Waypoint(position=GOAL, move=move)], start).trajectory
        tool = track(cell.arm, motion, 150)
        q = np.degrees(motion.sample(tool.t)[0])
        name = f"{label}, {motion.duration:.2f} s"
        draw_curve(left, tool.p[:, :2], color=colour, label=name)
        right.plot(q[:, 0], q[:, 1], color=colour)
        right.plot(q[[0, -1], 0], q[[0, -1], 1], **GIVEN)
        draw_curve(left, tool.p[[0, -1], :2], **GIVEN)
        for q_shown in (start, motion.q_goal):
            draw_flat_arm(left, cell.arm, q_shown)
    plane(left, "the tool")
    legend_below(left, 2)
    right.set(xlabel="joint 1 / deg", ylabel="joint 2 / deg", title="the joints")
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
