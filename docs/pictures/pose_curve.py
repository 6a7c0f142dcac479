"""Two curves of whole poses: the origin on a way of its own, and one screw for both."""

import numpy as np
from matplotlib.figure import Figure
from style import BLUE, GIVEN, INK, RED, WIDTH, draw_curve, plane, save, styled

from splinearm.kinematics import Pose, quaternion
from splinearm.trajectories.pose_curve import interpolate_poses
from splinearm.trajectories.screw_bspline import ScrewBSpline

LONG = 0.012
UP = np.array((0.0, 0.0, 1.0))
POSES = [
    Pose(p=np.array((x, y, 0.0)), quat=quaternion.from_axis_angle(UP, angle))
    for x, y, angle in ((0.0, 0.0, 0.0), (0.1, 0.0, 2.2))
]


@styled
def draw() -> Figure:
    """Draw frames in their plane along both curves."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    apart = interpolate_poses([0.0, 1.0], POSES)
    screw = ScrewBSpline(np.array((0.0, 0.0, 1.0, 1.0)), POSES, 1)
    places = zip(figure.subplots(1, 2), ("PoseCurve", "ScrewBSpline"), (apart, screw), strict=True)
    for axes, title, curve in places:
        draw_curve(axes, curve.at(np.linspace(0.0, 1.0, 60)).p[:, :2], color=INK)
        for T in curve.at(np.linspace(0.0, 1.0, 9)).matrices():
            for column, colour in ((0, RED), (1, BLUE)):
                tip = T[:2, 3] + LONG * T[:2, column]
                draw_curve(axes, (T[:2, 3], tip), color=colour, linewidth=1.3)
        draw_curve(axes, np.array([pose.p[:2] for pose in POSES]), **GIVEN)
        plane(axes, title)
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
