"""Compiled kernels: the same numbers as plain Python, said once, fresh when a source changes."""

import numpy as np
import pytest

from splinearm import compiled

# every kernel on small, hard cases: turning and sliding joints, large angles, a half-full block
ALL_KERNELS = """
import numpy as np
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.dh import DHConvention, DHLink
from splinearm.kinematics.differential import jacobian_rate, manipulability_gradient
from splinearm.kinematics.dynamics import Drives, Dynamics
from splinearm.kinematics.link import Inertia

rng = np.random.default_rng(7)
found = []
for n, slides in ((2, False), (3, True), (6, False), (7, True)):
    kinds = [JointKind.PRISMATIC if slides and k % 3 == 1 else JointKind.REVOLUTE for k in range(n)]
    rows = [DHLink(f"j{k}", *rng.normal(size=4), kind) for k, kind in enumerate(kinds)]
    ones = np.ones(n)
    limits = JointLimits(names=tuple(r.name for r in rows), kinds=tuple(kinds), q_min=-ones,
        q_max=ones, qd_max=ones, qdd_max=ones)
    roots = rng.normal(size=(n, 3, 3))
    inertias = [Inertia(1.0 + k, rng.normal(size=3), root @ root.T) for k, root in enumerate(roots)]
    arm = Arm.from_dh("arm", rows, DHConvention.STANDARD, limits, inertias=inertias).compiled()
    motion = Dynamics(arm, drives=Drives(rotor_inertia=ones, viscous=ones, coulomb=ones))
    q, qd, qdd = rng.uniform(-3, 3, (3, 70, n))
    q[3] *= np.where([kind is JointKind.REVOLUTE for kind in kinds], 1e7, 1.0)
    found += [arm.fk(q), arm.frames(q), arm.jacobian(q), motion.inverse(q, qd, qdd)]
    found += [arm.fk(q[0]), arm.jacobian(q[0]), motion.inverse(q[0], qd[0], qdd[0])]
    found += [motion.mass_matrix(q[:9]), motion.coriolis_matrix(q[:9], qd[:9])]
    found += [motion.forward(q[:9], qd[:9], qdd[:9]), motion.forward(q[0], qd[0], qdd[0])]
    found += [motion.mass_matrix(q[0]), motion.coriolis_matrix(q[0], qd[0])]
    found += [jacobian_rate(arm, q[0], qd[0]), manipulability_gradient(arm, q[0])]
"""


def test_compiled_and_plain_kernels_agree(compiled_as_plain):
    compiled_as_plain(ALL_KERNELS, 60)


def test_the_first_compile_is_said_once(tmp_path, python):
    code = """
import logging, numpy as np
said = []
class Keep(logging.Handler):
    def emit(self, record): said.append((record.levelname, record.getMessage()))
log = logging.getLogger("splinearm")
log.addHandler(Keep()); log.setLevel(logging.INFO)
from splinearm.kinematics.sine_kernel import sincos
from splinearm.kinematics.dynamics_kernel import cross
sincos(1.0), cross(1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
print(said)
"""
    wanted = "[('INFO', 'compiling numeric kernels, once; later runs load them from disk')]"
    environment = {"NUMBA_CACHE_DIR": str(tmp_path), "NUMBA_DISABLE_JIT": "0"}
    assert python(code, **environment).strip() == wanted
    assert python(code, **environment).strip() == "[]"


def test_a_kernel_is_stale_when_a_file_it_imports_from_changes(tmp_path):
    (tmp_path / "a_kernel.py").write_text("from .b_kernel import f\n")
    (tmp_path / "b_kernel.py").write_text("from .c import N\nfrom .a_kernel import g\n")
    (tmp_path / "c.py").write_text("N = 1\n")
    (tmp_path / "other.py").write_text("N = 1\n")

    def stamp():
        compiled._stamp.cache_clear()
        return compiled._stamp(tmp_path / "a_kernel.py")

    before = stamp()
    (tmp_path / "other.py").write_text("N = 12345\n")
    assert stamp() == before
    (tmp_path / "c.py").write_text("N = 12345\n")
    assert stamp() != before


def test_an_entry_refuses_what_it_is_not_compiled_for():
    from splinearm.compiled import entry, inputs, kernel, outputs

    both = entry(kernel(_copy), *inputs(1), *outputs(1))
    out = np.zeros(2)
    frozen = np.ones(2)
    frozen.flags.writeable = False
    both(frozen, out)
    assert out.tolist() == [1.0, 1.0]
    both(np.full(2, 3.0), out)
    assert out.tolist() == [3.0, 3.0]
    for wrong in (np.ones(2, dtype=int), np.ones((2, 2)), np.ones(4)[::2]):
        with pytest.raises(TypeError, match="No matching definition"):
            both(wrong, out)
    with pytest.raises(TypeError, match="No matching definition"):
        both(out, frozen)


def _copy(a, b):
    b[:] = a
