import json
import os
import subprocess
import sys
from math import cos, pi, sin

import numpy as np
import pytest

from splinearm.kinematics import angle_kernel, quartic_kernel, subproblem_kernel
from splinearm.kinematics.closed_form import ClosedForm, branches

pytestmark = pytest.mark.kernel


@pytest.mark.property
def test_circle_gives_both_roots():
    rng = np.random.default_rng(0)
    for _ in range(300):
        a, b, angle = rng.normal(), rng.normal(), rng.uniform(-pi, pi)
        c = a * cos(angle) + b * sin(angle)
        n, *roots = subproblem_kernel.circle(a, b, c, 1.0, 0.0)
        assert n == 2
        for cosine, sine in (roots[:2], roots[2:]):
            assert abs(a * cosine + b * sine - c) < 1e-12
            assert abs(cosine**2 + sine**2 - 1.0) < 1e-12
        assert min(abs(roots[0] - cos(angle)), abs(roots[2] - cos(angle))) < 1e-9


def test_circle_has_one_root_at_its_edge_none_beyond_and_the_seed_where_it_is_free():
    assert subproblem_kernel.circle(0.0, 2.0, 2.0, 1.0, 0.0)[:3] == (1, 0.0, 1.0)
    assert subproblem_kernel.circle(0.0, 2.0, -2.0, 1.0, 0.0)[:3] == (1, 0.0, -1.0)
    assert subproblem_kernel.circle(0.0, 2.0, 2.1, 1.0, 0.0)[0] == 0
    assert subproblem_kernel.circle(0.0, 0.0, 0.0, 1.0, 0.7)[:3] == (1, cos(0.7), sin(0.7))
    assert subproblem_kernel.circle(0.0, 0.0, 0.1, 1.0, 0.7)[0] == 0


def test_turn_brings_one_direction_to_another():
    c, s = subproblem_kernel.turn(2.0, 0.0, 0.0, 3.0, 1.0, 0.0)
    np.testing.assert_allclose((c, s), (0.0, 1.0), atol=1e-15)
    c, s = subproblem_kernel.turn(0.0, 0.0, 0.0, 3.0, 1.0, 0.4)
    np.testing.assert_allclose((c, s), (cos(0.4), sin(0.4)), atol=1e-15)


def test_the_angle_of_a_direction_is_that_of_the_library():
    rng = np.random.default_rng(1)
    x, y = rng.normal(size=(2, 2000)) * 10.0 ** rng.uniform(-9, 3, (2, 2000))
    edges = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0), (1.0, 1.0), (-1.0, -1e-17)]
    for a, b in [*zip(x, y, strict=True), *edges]:
        assert abs(angle_kernel.arctan2(float(b), float(a)) - np.arctan2(b, a)) < 1e-15


def test_all_zeros_of_a_trigonometric_polynomial_are_found():
    rng = np.random.default_rng(2)
    out = np.empty(4)
    fine = np.linspace(-pi, pi, 20001)
    for _ in range(100):
        f0, a1, b1, a2, b2 = rng.normal(size=5)
        values = f0 + a1 * np.cos(fine) + b1 * np.sin(fine)
        values += a2 * np.cos(2 * fine) + b2 * np.sin(2 * fine)
        crossings = int((values[:-1] * values[1:] < 0.0).sum())
        n = quartic_kernel.trig_roots(f0, a1, b1, a2, b2, out)
        assert n == crossings
        x = out[:n]
        left = f0 + a1 * np.cos(x) + b1 * np.sin(x) + a2 * np.cos(2 * x) + b2 * np.sin(2 * x)
        assert np.abs(left).max(initial=0.0) < 1e-10
    assert quartic_kernel.trig_roots(-0.5, 1.0, 0.0, 0.0, 0.0, out) == 2
    assert quartic_kernel.trig_roots(1.0, 0.0, 0.0, 0.0, 0.0, out) == 0


def answers(arms):
    """Give what the closed forms of some arms answer, as lists."""
    told = {}
    q = np.array((0.3, -0.4, 0.9, 0.5, 1.1, -0.7, 0.2))
    for name in ("puma", "ur5", "oblique wrist", "base 23", "quartic"):
        form = ClosedForm.of(arms[name])
        T = arms[name].fk(np.array([q[:6], 0.5 * q[:6], np.zeros(6)]))
        batch, count = form.solve_batch(T, np.zeros(6))
        told[name] = [
            np.sort(b[: int(c)], axis=0).tolist() for b, c in zip(batch, count, strict=True)
        ]
        told[name].append(form.solve(T[0], np.zeros(6))[0].tolist())
    for free in ("nothing", "yaw", "roll", "yaw and roll"):
        told[free] = branches(arms["koch"], arms["koch"].fk(q[:5]), free=free).q.tolist()
    told["panda"] = branches(arms["panda"], arms["panda"].fk(q), given={"joint7": 0.2}).q.tolist()
    return told


SCRIPT = """
import importlib.util, json, sys
def load(name, path):
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
arms = load("conftest", sys.argv[1]).make_closed_arms()
print(json.dumps(load("kernels", sys.argv[2]).answers(arms)))
"""


def test_compiled_and_plain_kernels_agree(closed_arms, request):
    here = request.path.parent
    plain = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(here / "conftest.py"), str(request.path)],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        check=True,
        text=True,
    )
    told, wanted = json.loads(plain.stdout), answers(closed_arms)
    assert told.keys() == wanted.keys()
    for name, value in wanted.items():
        if name in ("puma", "ur5", "oblique wrist", "base 23", "quartic"):
            for one, other in zip(told[name], value, strict=True):
                np.testing.assert_allclose(one, other, atol=1e-11)
        else:
            np.testing.assert_allclose(told[name], value, atol=1e-11)
