import json
from math import cos, pi, sin
from pathlib import Path

import numpy as np
import pytest

from splinearm.kinematics import (
    angle_kernel,
    eigenvalue_kernel,
    general_six_kernel,
    quartic_kernel,
    structure,
    subproblem_kernel,
)
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
    for free in ("nothing", "yaw", "roll", "yaw and roll", "orientation"):
        found = branches(arms["koch"], arms["koch"].fk(q[:5]), q[:5], free=free)
        told[free] = found.q.tolist()
    T = arms["panda"].fk(q)
    for given in ({"joint7": 0.2}, {"swivel": 0.4}):
        told[str(given)] = branches(arms["panda"], T, q, given=given).q.tolist()
    # two ways that serve this arm: to choose them takes plain Python a minute
    any_six = arms["meeting wrist, oblique"]
    rows = np.zeros((2, 6))
    rows[:, :4] = (1, 1, 0, 1), (4, 0, 1, 2)
    packed = np.concatenate((structure.find(any_six.packed).packed, rows))
    found, _ = general_six_kernel.solve(packed, any_six.fk(q[:6]), np.zeros(6))
    told["any"] = found.tolist()
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


def test_compiled_and_plain_kernels_agree(closed_arms, request, python):
    files = request.path.with_name("conftest.py"), request.path
    told = json.loads(python(SCRIPT, *map(str, files), NUMBA_DISABLE_JIT="1"))
    wanted = answers(closed_arms)
    assert told.keys() == wanted.keys()
    for name, value in wanted.items():
        if name in ("puma", "ur5", "oblique wrist", "base 23", "quartic"):
            for one, other in zip(told[name], value, strict=True):
                np.testing.assert_allclose(one, other, rtol=0, atol=1e-12)
        else:
            assert len(value), name
            np.testing.assert_allclose(told[name], value, rtol=0, atol=1e-12)


def test_kernels_do_without_a_library_for_linear_algebra():
    """Compiled linear algebra of numpy would want scipy, which is not there at run time."""
    files = list(Path(eigenvalue_kernel.__file__).parent.glob("*_kernel.py"))
    assert len(files) > 15
    assert [file.name for file in files if "linalg" in file.read_text(encoding="utf-8")] == []


@pytest.mark.property
def test_eigenvalues_are_those_of_the_library():
    rng = np.random.default_rng(3)
    for n in (1, 2, 3, 5, 9, 24):
        for _ in range(4):
            A = rng.normal(size=(n, n)) * 10.0 ** rng.uniform(-2, 2, (n, 1))
            real, imaginary = np.empty(n), np.empty(n)
            assert eigenvalue_kernel.eigenvalues(A.copy(), real, imaginary)
            wanted, found = np.linalg.eigvals(A), real + 1j * imaginary
            apart = np.abs(found[:, None] - wanted).min(axis=0)
            assert apart.max() < 1e-11 * np.abs(wanted).max()
    real, imaginary = np.empty(4), np.empty(4)
    assert eigenvalue_kernel.eigenvalues(np.zeros((4, 4)), real, imaginary)
    np.testing.assert_array_equal(real, 0.0)


@pytest.mark.property
def test_triangles_and_solutions_are_those_of_their_matrices():
    rng = np.random.default_rng(4)
    for _ in range(10):
        A, Q, order = rng.normal(size=(7, 4)), np.empty((7, 7)), np.empty(4)
        A[:, 2] = A[:, 1]
        R = A.copy()
        eigenvalue_kernel.triangulate(R, Q, order)
        np.testing.assert_allclose(Q @ R, A[:, order.astype(int)], atol=1e-13)
        np.testing.assert_allclose(Q.T @ Q, np.eye(7), atol=1e-13)
        assert abs(R[3, 3]) < 1e-13
        B, C = rng.normal(size=(5, 5)), rng.normal(size=(5, 2))
        X = C.copy()
        assert 0.0 < eigenvalue_kernel.eliminate(B.copy(), X) <= 1.0
        np.testing.assert_allclose(B @ X, C, atol=1e-9)
    assert eigenvalue_kernel.eliminate(np.zeros((2, 2)), np.ones((2, 1))) == 0.0
