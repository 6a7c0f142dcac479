"""A B-spline move through waypoints, with and without speeds."""

import numpy as np
from matplotlib.figure import Figure
from motion import draw_flat_arm, draw_speed, track
from style import BLUE, GIVEN, RED, WIDTH, draw_curve, draw_limit, legend_below, plane, save, styled

from splinearm import Waypoint, load_cell, plan

PLACES = [(0.30, 0.05, 0.06), (0.27, 0.20, 0.06), (0.35, 0.28, 0.06), (0.42, 0.18, 0.06)]


@styled
def draw() -> Figure:
    """Draw the way of the tool and its speed."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    cell = load_cell("planar_2r")
    quick = plan(cell.arm, [Waypoint(position=p) for p in PLACES], cell.poses["home"])
    slow = plan(cell.arm, [Waypoint(position=p, speed=0.3) for p in PLACES], cell.poses["home"])
    draw_flat_arm(left, cell.arm, cell.poses["home"])
    draw_curve(left, quick.tool_path.sample(200)[:, :2], color=BLUE)
    start = cell.arm.fk(cell.poses["home"])[:3, 3]
    draw_curve(left, np.array([start, *PLACES])[:, :2], **GIVEN)
    plane(left, "one C2 curve through all waypoints")
    for motion, colour, label in ((quick, BLUE, "as fast as the joints can"), (slow, RED, "")):
        tool = track(cell.arm, motion.trajectory, 300)
        draw_speed(right, tool)
        right.lines[-1].set(color=colour, label=label or "speed=0.3")
        times = motion.waypoint_times[:-1]
        passed = np.interp(times, tool.t, tool.speed) * 1e3
        right.plot(times, passed, **{**GIVEN, "color": colour})
    draw_limit(right, 300.0, "300 mm/s")
    legend_below(right, 2)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
