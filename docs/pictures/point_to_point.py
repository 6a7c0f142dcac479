"""Point to point with limited jerk: synchronised in time, and a new goal taken up in motion."""

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure
from style import BLUE, GREY, RED, WIDTH, save, styled

from splinearm import load_cell
from splinearm.trajectories.point_to_point import point_to_point, retarget

LEAVE = 0.35


@styled
def draw() -> Figure:
    """Draw position, velocity and acceleration of two joints, at rest and on the move."""
    figure = Figure(figsize=(WIDTH, 4.6), layout="constrained")
    axes = figure.subplots(3, 2, sharex="col", sharey="row")
    joints = load_cell("planar_2r").arm.limits
    limits = replace(joints, qddd_max=20.0 * joints.qdd_max)
    first = point_to_point(limits, [0.0, 0.0], [1.0, -0.4])
    second = retarget(first, LEAVE, [0.2, 0.6])
    before = first.sample(np.linspace(0.0, LEAVE, 40, endpoint=False))
    after = second.sample(np.linspace(0.0, second.duration, 90))
    t_left = np.linspace(0.0, first.duration, 100)
    t_right = np.concatenate(
        (np.linspace(0.0, LEAVE, 40, endpoint=False), LEAVE + np.linspace(0, second.duration, 90))
    )
    left = first.sample(t_left)
    right = [np.concatenate(pair) for pair in zip(before, after, strict=True)]
    for row, name in enumerate(("q / rad", "velocity / (rad/s)", "accel. / (rad/s²)")):
        for joint, colour in enumerate((BLUE, RED)):
            look = {"color": colour, "label": f"joint {joint + 1}", "linewidth": 1.4}
            axes[row, 0].plot(t_left, left[row][:, joint], **look)
            axes[row, 1].plot(t_right, right[row][:, joint], **look)
        axes[row, 1].axvline(LEAVE, color=GREY, linewidth=0.9, linestyle=":")
        axes[row, 0].set_ylabel(name)
    axes[0, 0].set_title("both end together")
    axes[0, 1].set_title(f"a new goal at {LEAVE:g} s")
    for place in axes[:, 0]:
        place.locator_params(nbins=4)
    for place in axes[2]:
        place.set_xlabel("t / s")
    figure.legend(*axes[2, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
