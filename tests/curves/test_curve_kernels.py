"""Compiled kernels of curves give the numbers of plain Python."""

KERNELS = """
import numpy as np
from splinearm.curves import BSpline, interpolate
from splinearm.curves.removal import reduce_degree, remove_knots

rng = np.random.default_rng(3)
found = []
for degree, weighted in ((1, False), (2, True), (3, False), (5, True)):
    knots = np.concatenate((np.zeros(degree + 1), [0.1, 0.4, 0.4, 0.401][:max(degree, 2)],
        np.ones(degree + 1)))
    if degree == 1:
        knots = np.delete(knots, 2)
    m = len(knots) - degree - 1
    weights = rng.uniform(1.0, 1.1, m) if weighted else None
    curve = BSpline(knots, rng.normal(size=(m, 3)), degree, weights)
    finer = curve.with_knots([0.3, 0.7])
    found += [finer.points, curve.elevated().points, curve.bezier()[1], curve.clamped().points]
    found += [remove_knots(finer, [0.3], 1e-6)[0].points]
    found += [reduce_degree(curve.elevated(), 1e-6)[0].points]
    sampler = curve.sampler()
    found += [sampler.sample(np.linspace(0, 1, 17), order) for order in (0, 2, 4)]
    found += [interpolate(rng.normal(size=(30, 2)), degree=3, ends=e).points
        for e in ("natural", "free", "closed")]
"""


def test_compiled_and_plain_curve_kernels_agree(compiled_as_plain):
    compiled_as_plain(KERNELS, 48)
