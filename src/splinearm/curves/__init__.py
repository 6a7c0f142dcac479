"""Curves and surfaces: geometry without time.

Knows Bezier, B-spline and NURBS curves and conics, how they are made through points, changed
without changing the curve, measured and met. Knows nothing of arms, time or files.
"""

from .arc_length import ArcLength as ArcLength
from .bezier import Bezier as Bezier
from .bspline import BSpline as BSpline
from .conic import arc as arc
from .conic import circle as circle
from .conic import ellipse as ellipse
from .conic import line as line
from .conic_equation import ConicEquation as ConicEquation
from .coons import coons as coons
from .curvature import curvature as curvature
from .curvature import frenet as frenet
from .curvature import torsion as torsion
from .frame import RotationMinimisingFrame as RotationMinimisingFrame
from .interpolation import interpolate as interpolate
from .loft import lofted as lofted
from .natural import NaturalCurve as NaturalCurve
from .plane import Plane as Plane
from .sampler import Sampler as Sampler
from .surface import BSplineSurface as BSplineSurface
from .surface_of_curves import extruded as extruded
from .surface_of_curves import revolved as revolved
from .surface_of_curves import ruled as ruled
from .sweep import swept as swept
