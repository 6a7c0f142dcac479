"""Curves and surfaces: geometry without time.

Knows Bezier, B-spline and NURBS curves, how they are made through points, changed without changing
the curve, measured and met. Knows nothing of arms, time or files.
"""

from .bspline import BSpline as BSpline
from .interpolation import interpolate as interpolate
