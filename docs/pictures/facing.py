"""How a tool stands on its way: kept as it is, or turning with the way."""

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from style import BLUE, GREEN, INK, RED, WIDTH, draw_curve, save, space, styled

from splinearm import (
    ArcThrough,
    Arm,
    Facing,
    JointTrajectory,
    Move,
    Pose,
    Waypoint,
    load_cell,
    plan,
)
from splinearm.kinematics import search

START, VIA, END = np.array([(0.22, -0.12, 0.2), (0.32, 0.0, 0.2), (0.22, 0.12, 0.2)])
LONG = 0.03


def draw_frames(axes: Axes3D, arm: Arm, motion: JointTrajectory) -> None:
    """Draw the way of a tool and some of its frames."""
    q = motion.sample(np.linspace(0.0, motion.duration, 200))[0]
    way = arm.fk(q)[:, :3, 3]
    draw_curve(axes, way, color=INK, linewidth=1.8)
    gone = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))))
    even = np.searchsorted(gone, np.linspace(0.0, 0.999 * gone[-1], 9))
    for T in arm.fk(q[even]):
        for column, colour in enumerate((RED, GREEN, BLUE)):
            tip = T[:3, 3] + LONG * T[:3, column]
            draw_curve(axes, (T[:3, 3], tip), color=colour, linewidth=1.3)


@styled
def draw() -> Figure:
    """Draw one arc with a tool that is kept and one that turns with the way."""
    figure = Figure(figsize=(WIDTH, 3.0), layout="constrained")
    arm = load_cell("wx250s").arm
    down = arm.fk(np.zeros(6))
    down[:3, :3] = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
    down[:3, 3] = START
    q_start = search(arm, Pose.from_matrix(down)).q
    for place, facing in ((121, Facing.KEPT), (122, Facing.TANGENT)):
        to = Waypoint(position=END, move=Move.ARC, arc=ArcThrough(VIA), facing=facing)
        axes = space(figure, place, f"facing=Facing.{facing.name}")
        draw_frames(axes, arm, plan(arm, [to], q_start).trajectory)
        axes.set(xlim=(190, 350), ylim=(-135, 150), zlim=(150, 230), zticks=(160, 200))
        axes.set(xticks=(200, 250, 300), yticks=(-100, 0, 100))
        axes.set_aspect("equal")
        axes.view_init(elev=40, azim=-40)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
