"""Compiled kernels of surfaces give the numbers of plain Python."""

import json
import os
import subprocess
import sys

import numpy as np

KERNELS = """
import json
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
print(json.dumps([np.ravel(a).tolist() for a in found]))
"""


def numbers(**environment):
    result = subprocess.run(
        [sys.executable, "-W", "error", "-c", KERNELS],
        capture_output=True,
        text=True,
        env={**os.environ, **environment},
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return json.loads(result.stdout)


def test_compiled_and_plain_surface_kernels_agree():
    fast, plain = numbers(NUMBA_DISABLE_JIT="0"), numbers(NUMBA_DISABLE_JIT="1")
    assert len(fast) == len(plain) == 28
    for a, b in zip(fast, plain, strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-12 * max(1.0, np.abs(b).max()))
