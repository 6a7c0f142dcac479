"""Compiled kernels of surfaces give the numbers of plain Python."""

KERNELS = """
import numpy as np
from splinearm.curves.surface import BSplineSurface

rng = np.random.default_rng(3)
found = []
for p, q, weighted in ((0, 1, False), (1, 2, True), (3, 2, False), (2, 5, True)):
    knots = [np.r_[np.zeros(d + 1), [0.3] * min(2, d), 0.7, np.ones(d + 1)] for d in (p, q)]
    m, n = (len(k) - d - 1 for k, d in zip(knots, (p, q)))
    weights = rng.uniform(0.5, 2.0, (m, n)) if weighted else None
    surface = BSplineSurface(*knots, rng.normal(size=(m, n, 3)), p, q, weights)
    us, vs = np.linspace(0, 1, 11), np.linspace(0, 1, 11)[::-1]
    found += [surface.jet(us, vs, order) for order in (0, 1, 3)]
    found += [surface.grid(us, vs, order) for order in (0, 1, 3)]
    found += [surface.at(0.3, 0.7, 2, 0)]
"""


def test_compiled_and_plain_surface_kernels_agree(compiled_as_plain):
    compiled_as_plain(KERNELS, 28)
