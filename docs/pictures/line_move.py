"""Straight lines: a corner rounded, a corner met exactly."""

import numpy as np
from matplotlib.figure import Figure
from motion import draw_speed, track
from style import BLUE, GIVEN, GREY, INK, WIDTH, draw_curve, plane, save, styled

from splinearm import Move, Waypoint, load_cell, plan

START = np.array((0.39, -0.06, 0.06))
CORNERS = np.array([(0.39, 0.06, 0.06), (0.27, 0.06, 0.06), (0.27, -0.06, 0.06)])


@styled
def draw() -> Figure:
    """Draw the way of the tool and its speed."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    cell = load_cell("planar_2r")
    waypoints = [
        Waypoint(position=CORNERS[0], move=Move.LINE, speed=0.15, blend=0.02, name="rounded"),
        Waypoint(position=CORNERS[1], move=Move.LINE, speed=0.15, name="exact"),
        Waypoint(position=CORNERS[2], move=Move.LINE, speed=0.15, blend=0.04, name="rounder"),
        Waypoint(position=START, move=Move.LINE, speed=0.15, dwell=0.2, name="back"),
    ]
    there = plan(cell.arm, [Waypoint(position=START)], cell.poses["home"]).trajectory.q_goal
    motion = plan(cell.arm, waypoints, there)
    tool = track(cell.arm, motion.trajectory, 500)
    square = np.array([START, *CORNERS, START])[:, :2]
    draw_curve(left, square, color=GREY, linewidth=0.8)
    draw_curve(left, tool.p[:, :2], color=BLUE)
    draw_curve(left, square, **GIVEN)
    plane(left, "blend 20 mm, none, 40 mm")
    draw_speed(right, tool, 0.15)
    top = right.get_ylim()[1]
    for time, waypoint in zip(motion.waypoint_times, waypoints, strict=True):
        right.plot((time, time), (0.0, 0.93 * top), color=GREY, linewidth=0.7, linestyle=":")
        right.annotate(waypoint.name, (time, 0.95 * top), ha="center", fontsize=7, color=INK)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
