"""From joint positions to poses and back, and to torques.

Knows homogeneous transforms of the plane and of space, quaternions, rigid motions, poses, links,
arms from Denavit-Hartenberg tables, frames, screws, URDF or MJCF, Jacobians, inverse kinematics
in closed form and by search, and rigid-body dynamics. Knows no time, no servo and no file of this
project. Matrices act on column vectors; quaternions are w x y z; lengths in m, angles in rad.

Values that are checked once (``Arm``, ``Link``, ``Pose`` ...) stand above modules of functions on
bare arrays; what is hot stands in modules named ``..._kernel``, which numba compiles on first use.
Importing this room loads no numba.
"""

from .arm import Arm as Arm
from .batch_search import IKBatch as IKBatch
from .batch_search import search_batch as search_batch
from .closed_form import ArmClass as ArmClass
from .closed_form import Branches as Branches
from .closed_form import ClosedForm as ClosedForm
from .closed_form import branches as branches
from .dh import DHConvention as DHConvention
from .dh import DHLink as DHLink
from .dynamics import Drives as Drives
from .dynamics import Dynamics as Dynamics
from .ik import IKResult as IKResult
from .ik import IKStatus as IKStatus
from .ik import search as search
from .ik import solve as solve
from .link import Inertia as Inertia
from .link import Link as Link
from .nearest import NearestPose as NearestPose
from .nearest import nearest_pose as nearest_pose
from .objective import AwayFromLimits as AwayFromLimits
from .objective import Manipulability as Manipulability
from .objective import NearPosture as NearPosture
from .path_search import PathResult as PathResult
from .path_search import PathStatus as PathStatus
from .path_search import search_path as search_path
from .path_search import solve_path as solve_path
from .planar import Elbow as Elbow
from .planar import Elbows as Elbows
from .planar import Planar2R as Planar2R
from .planar import solve_elbows as solve_elbows
from .pose import Pose as Pose
from .self_motion import improve as improve
from .self_motion import search_best as search_best
from .singularity import Singularity as Singularity
from .singularity import nearest_singularity as nearest_singularity
from .solver import prepare as prepare
