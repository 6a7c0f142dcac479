"""Compiled kernels of fitting and of nearest places give the numbers of plain Python."""

KERNELS = """
import numpy as np
from splinearm.curves.conic import ellipse
from splinearm.curves.fit import fit
from splinearm.curves.interpolation import interpolate
from splinearm.curves.projection import nearest_point
from splinearm.curves.smoothing import choose_stiffness, smooth

rng = np.random.default_rng(5)
points = np.cumsum(rng.normal(size=(25, 2)), axis=0)
found = [fit(points, 9, degree=d, ends=e).points
    for d, e in ((3, "kept"), (2, "free"), (3, "closed"), (4, "closed"))]
found += [smooth(points, 0.5, closed=c).points for c in (False, True)]
found += [np.log([choose_stiffness(points + np.sin(7.0 * points), closed=True)]) * 1e-9]
for curve in (interpolate(points), ellipse(2.0, 1.0), interpolate(points, degree=1)):
    near = nearest_point(curve, points[::3] * 0.7 + 0.1)
    found += [near.u, near.points, near.distance]
"""


def test_compiled_and_plain_kernels_of_fitting_agree(compiled_as_plain):
    compiled_as_plain(KERNELS, 16)
