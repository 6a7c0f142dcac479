"""Toolpaths: contours in the work plane, their offsets, what a cutter makes of them, and G-code.

Knows curves and motions, nothing of servos, simulators or arm files. Lengths are in m here too;
files say what unit they speak.
"""

from .contour import Contour as Contour
from .offset import Offsets as Offsets
from .offset import offset as offset
from .offset import offset_path as offset_path
from .offset import rings as rings
from .offset import widened as widened
from .piece import ArcPiece as ArcPiece
from .piece import LinePiece as LinePiece
from .region import Region as Region
