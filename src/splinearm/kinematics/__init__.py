"""From joint positions to poses and back.

Knows homogeneous transforms of the plane and of space, quaternions, poses, links, arms from
Denavit-Hartenberg tables or frames, Jacobians and inverse kinematics. Knows no time, no file and
no servo. Matrices act on column vectors; quaternions are w x y z; lengths in m, angles in rad.

Values that are checked once (``Arm``, ``Link``, ``Pose`` ...) stand above modules of functions on
bare arrays: ``plane``, ``space``, ``homogeneous``, ``quaternion``, ``chain``, ``descent``.
"""

from .arm import Arm as Arm
from .dh import DHConvention as DHConvention
from .dh import DHLink as DHLink
from .ik import IKResult as IKResult
from .ik import IKStatus as IKStatus
from .ik import search as search
from .ik import solve as solve
from .link import Inertia as Inertia
from .link import Link as Link
from .planar import Elbow as Elbow
from .planar import Elbows as Elbows
from .planar import Planar2R as Planar2R
from .planar import solve_elbows as solve_elbows
from .pose import Pose as Pose
