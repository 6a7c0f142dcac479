"""Stops along the path, from several moments of one motion."""

from matplotlib.figure import Figure
from motion import track
from style import BLUE, FAINT, GREEN, GREY, ORANGE, RED, WIDTH, draw_curve, plane, save, styled

from splinearm import Waypoint, load_cell, plan

PLACES = [(0.30, 0.05, 0.06), (0.27, 0.20, 0.06), (0.35, 0.28, 0.06), (0.42, 0.18, 0.06)]


@styled
def draw() -> Figure:
    """Draw the speed of the tool with three stops, and where each ends."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    cell = load_cell("planar_2r")
    waypoints = [Waypoint(position=p) for p in PLACES]
    motion = plan(cell.arm, waypoints, cell.poses["home"]).trajectory
    whole = track(cell.arm, motion, 300)
    draw_curve(left, whole.p[:, :2], color=FAINT, linewidth=3.0)
    right.plot(whole.t, whole.speed * 1e3, color=GREY, linewidth=1.2)
    for leave, colour in ((0.15, BLUE), (0.4, GREEN), (0.6, ORANGE), (0.95, RED)):
        stop = track(cell.arm, motion.stop_from(leave), 100)
        draw_curve(left, stop.p[:, :2], color=colour)
        draw_curve(left, stop.p[-1:, :2], color=colour, marker="o")
        right.plot(leave + stop.t, stop.speed * 1e3, color=colour)
    plane(left, "ways from asking to rest")
    right.set(xlabel="t / s", ylabel="speed of the tool / (mm/s)", ylim=(0.0, None))
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
