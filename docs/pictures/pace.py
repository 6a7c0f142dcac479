"""A motion slowed down, paused, resumed and hurried while it runs."""

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure
from style import BLUE, GREY, INK, RED, SKY, WIDTH, draw_limit, legend_below, save, styled

from splinearm import JointTrajectory, load_cell
from splinearm.curves import interpolate
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.pace import PacedMotion
from splinearm.trajectories.section import Section
from splinearm.trajectories.smooth_timing import quickest_smooth

PLACES = np.array([(0.0, 0.0), (0.5, -0.3), (0.9, 0.6), (1.6, 0.4), (2.0, 1.2)])
PERIOD = 0.005
ASKED = ((0.0, 1.0), (0.5, 0.4), (1.5, 0.0), (2.0, 1.5))


@styled
def draw() -> Figure:
    """Draw the pace that was asked for and that was taken, and what limits that used."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    cell = load_cell("planar_2r")
    limits = replace(cell.arm.limits, qddd_max=20.0 * cell.arm.limits.qdd_max)
    path = JointPath(interpolate(PLACES, degree=5))
    section = Section(path, quickest_smooth(path, limits))
    motion = JointTrajectory((section,), PLACES[0], limits).scaled(0.6)
    paced = PacedMotion(motion, PERIOD)
    pending = list(ASKED)
    rows = []
    while not paced.finished:
        if pending and paced.elapsed >= pending[0][0]:
            paced.ask(pending.pop(0)[1])
        setpoint = paced.step()
        use = (setpoint.qd / limits.qd_max, setpoint.qdd / limits.qdd_max)
        rows.append((paced.elapsed, paced.pace, paced.motion_t, *(abs(x).max() for x in use)))
    t, pace, tau, velocity, acceleration = np.array(rows)[::3].T
    times, wanted = np.array([*ASKED, (t[-1], ASKED[-1][1])]).T
    left.step(times, wanted, where="post", color=GREY, linewidth=1.0, label="asked")
    left.plot(t, pace, color=BLUE, label="taken")
    left.plot(t, tau / motion.duration, color=INK, linewidth=1.0, label="share of its time")
    left.set(xlabel="t / s", ylabel="pace")
    legend_below(left)
    right.plot(t, 100.0 * acceleration, color=SKY, linewidth=1.1, label="acceleration")
    right.plot(t, 100.0 * velocity, color=RED, label="velocity")
    right.set(xlabel="t / s", ylabel="worst joint / % of its limit", ylim=(0.0, 118.0))
    draw_limit(right, 100.0, "")
    legend_below(right)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
