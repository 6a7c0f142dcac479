"""One motion of the joints through waypoints, beside stopping at each of them."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from matplotlib.figure import Figure
from style import BLUE, GIVEN, RED, WIDTH, legend_below, save, styled

from splinearm import load_cell
from splinearm.trajectories.point_to_point import point_to_point
from splinearm.trajectories.through import through

PLACES = np.array([(0.0, 0.0), (0.8, 0.9), (1.2, 0.2), (2.0, 0.8)])


@styled
def draw() -> Figure:
    """Draw the way of two joints, and the speed of the first."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    joints = load_cell("planar_2r").arm.limits
    limits = replace(joints, qddd_max=20.0 * joints.qdd_max)
    motion, passed = through(limits, list(PLACES))
    t = np.linspace(0.0, motion.duration, 250)
    q, qd, _ = motion.sample(t)
    stops = [point_to_point(limits, a, b) for a, b in pairwise(PLACES)]
    begins = np.concatenate(([0.0], np.cumsum([stop.duration for stop in stops])))
    for begin, stop in zip(begins[:-1], stops, strict=True):
        ts = np.linspace(0.0, stop.duration, 80)
        q_stop, qd_stop, _ = stop.sample(ts)
        left.plot(q_stop[:, 0], q_stop[:, 1], color=RED, linewidth=1.0)
        label = f"stopping, {begins[-1]:.2f} s" if begin == 0.0 else None
        right.plot(begin + ts, qd_stop[:, 0], color=RED, linewidth=1.0, label=label)
    left.plot(q[:, 0], q[:, 1], color=BLUE)
    left.plot(PLACES[:, 0], PLACES[:, 1], **GIVEN)
    right.plot(t, qd[:, 0], color=BLUE, label=f"through, {motion.duration:.2f} s")
    right.plot(passed, motion.sample(passed)[1][:, 0], **GIVEN)
    left.set(xlabel="joint 1 / rad", ylabel="joint 2 / rad")
    right.set(xlabel="t / s", ylabel="velocity of joint 1 / (rad/s)")
    legend_below(right, 2)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
