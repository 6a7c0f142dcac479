"""Paths and motions in time.

Knows orientation curves, ways of the tool and of the joints, time laws within limits, and how
waypoints become a motion. Stands on ``curves``. Knows nothing of servos, files or loops.

From waypoints to a motion: ``place`` sorts waypoints into runs, ``leg`` makes each run a way of the
tool (``path``), ``stretch`` chooses the configuration in which the joints follow it (``resolve``),
``law_choice`` has the quickest time law on it found, by
``timing`` or, where jerk is limited, by ``smooth_timing``, and ``plan`` puts the sections together
to a ``JointTrajectory``. Without a way to follow, ``point_to_point`` makes a motion from state to
state. While it runs, ``pace`` slows it down, hurries it and stops it on its path.
"""

from .limit import MotionLimits as MotionLimits
from .orientation import interpolate_orientations as interpolate_orientations
from .pace import PacedMotion as PacedMotion
from .plan_path import plan_path as plan_path
from .point_to_point import point_to_point as point_to_point
from .profile import JointProfile as JointProfile
from .rotation_bspline import RotationBSpline as RotationBSpline
from .surface_path import surface_path as surface_path
from .trajectory import JointTrajectory as JointTrajectory
from .waypoint import ArcAbout as ArcAbout
from .waypoint import ArcThrough as ArcThrough
from .waypoint import Facing as Facing
from .waypoint import Move as Move
from .waypoint import Waypoint as Waypoint
