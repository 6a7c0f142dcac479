"""Paths and motions in time.

Knows orientation curves, ways of the tool and of the joints, time laws within limits, and how
waypoints become a motion. Stands on ``curves``. Knows nothing of servos, files or loops.

From waypoints to a motion: ``place`` sorts waypoints into runs, ``leg`` makes each run a way of the
tool (``path``) and of the joints (``resolve``), ``timing`` finds the quickest time law on it, and
``plan`` puts the sections together to a ``JointTrajectory``.
"""

from .orientation import interpolate_orientations as interpolate_orientations
from .trajectory import JointTrajectory as JointTrajectory
from .waypoint import Move as Move
from .waypoint import Waypoint as Waypoint
