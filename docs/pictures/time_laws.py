"""Three time laws on one path: quickest, quickest with limited jerk, least jerk."""

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure
from style import BLUE, GREEN, RED, WIDTH, draw_limit, save, styled

from splinearm import load_cell
from splinearm.curves import interpolate
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.min_jerk import minimum_jerk, shortest_duration
from splinearm.trajectories.section import Section
from splinearm.trajectories.smooth_timing import quickest_smooth
from splinearm.trajectories.timing import quickest

PLACES = np.array([(0.0, 0.0), (0.5, -0.3), (0.9, 0.6), (1.6, 0.4), (2.0, 1.2)])
COUNT = 140


@styled
def draw() -> Figure:
    """Draw path speed, and the largest share of the joints' limits."""
    figure = Figure(figsize=(WIDTH, 4.6), layout="constrained")
    (speed, velocity), (acceleration, jerk) = figure.subplots(2, 2)
    path = JointPath(interpolate(PLACES, degree=5))
    joints = load_cell("planar_2r").arm.limits
    limits = replace(joints, qddd_max=10.0 * joints.qdd_max)
    laws = (
        ("quickest", RED, quickest(path, limits)),
        ("quickest_smooth", BLUE, quickest_smooth(path, limits)),
        ("minimum_jerk", GREEN, minimum_jerk(path, limits, shortest_duration(path, limits))),
    )
    for label, colour, law in laws:
        section = Section(path, law)
        t = np.linspace(0.0, law.duration, COUNT)
        _, qd, qdd = section.sample(t)
        look = {"color": colour, "linewidth": 1.3, "label": f"{label}, {law.duration:.2f} s"}
        speed.plot(t, law.sample(t)[1], **look)
        velocity.plot(t, 100.0 * np.abs(qd / limits.qd_max).max(axis=1), **look)
        acceleration.plot(t, 100.0 * np.abs(qdd / limits.qdd_max).max(axis=1), **look)
        if label == "quickest":
            continue
        jerk.plot(t, 100.0 * np.abs(section.jerk(t) / limits.qddd_max).max(axis=1), **look)
    speed.set(ylabel="ds/dt / (rad/s)")
    for axes, what in ((velocity, "velocity"), (acceleration, "acceleration"), (jerk, "jerk")):
        axes.set(ylabel=f"worst joint's {what} / %", ylim=(0.0, 118.0))
        draw_limit(axes, 100.0, "")
        axes.set_yticks((0, 50, 100))
    for axes in (speed, velocity, acceleration, jerk):
        axes.locator_params(axis="x", nbins=4)
    acceleration.set(xlabel="t / s")
    jerk.set(xlabel="t / s")
    figure.legend(*speed.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
