"""Arms and jobs as TOML files: where millimetres, degrees and files end.

Knows the formats, the shipped arms and the units that people write. Knows nothing of ports,
of planning or of what moves. What a file says comes out as the values of the rooms below.
"""

from .cell import Cell as Cell
from .cell import load_cell as load_cell
from .cell import shipped_arms as shipped_arms
from .job import Job as Job
from .job import demo_job as demo_job
from .job import load_job as load_job
from .motion import SavedMotion as SavedMotion
from .motion import load_motion as load_motion
from .motion import save_motion as save_motion
from .piece import GripAction as GripAction
from .piece import Piece as Piece
