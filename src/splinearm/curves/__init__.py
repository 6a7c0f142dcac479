"""Curves and surfaces: geometry without time.

Knows Bezier, B-spline and NURBS curves and conics, how they are made through points, changed
without changing the curve, measured and met. Knows nothing of arms, time or files.
"""

from .approximation import approximate as approximate
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
from .fit import fit as fit
from .frame import RotationMinimisingFrame as RotationMinimisingFrame
from .interpolation import interpolate as interpolate
from .loft import lofted as lofted
from .meeting import meet_curves as meet_curves
from .meeting import meet_line as meet_line
from .natural import NaturalCurve as NaturalCurve
from .plane import Plane as Plane
from .projection import nearest_point as nearest_point
from .sampler import Sampler as Sampler
from .smoothing import smooth as smooth
from .surface import BSplineSurface as BSplineSurface
from .surface_of_curves import extruded as extruded
from .surface_of_curves import revolved as revolved
from .surface_of_curves import ruled as ruled
from .sweep import swept as swept
