"""Mass matrix, forward dynamics, Coriolis matrix and the Jacobian's rate beside Pinocchio.

Inverse dynamics stand in ``kinematics_forward.py``; run this in the same way. No figure is wanted
here: the ratios say where one stands.
"""

import datetime
import os
import platform

import numpy as np
from kinematics_forward import MODELS, arm_of, imported, pinocchio_of, processor, shortest

from splinearm.kinematics import Arm
from splinearm.kinematics.differential import jacobian_rate
from splinearm.kinematics.dynamics import Dynamics


def compare(pin: object, arm: Arm, m: int) -> None:
    """Print batches of ours beside loops over Pinocchio, in us a state."""
    Q, Qd, Tau = np.random.default_rng(1).uniform(-3, 3, (3, m, arm.n))
    dynamics = Dynamics(arm.compiled())
    model, tool = pinocchio_of(pin, arm)
    data = model.createData()
    few = m // 10
    states = list(zip(Q[:few], Qd[:few], Tau[:few], strict=True))
    C = pin.computeCoriolisMatrix(model, data, Q[0], Qd[0])
    np.testing.assert_allclose(dynamics.coriolis_matrix(Q[0], Qd[0]) @ Qd[0], C @ Qd[0], atol=1e-10)
    qdd = pin.aba(model, data, Q[0], Qd[0], Tau[0])
    np.testing.assert_allclose(dynamics.forward(Q[0], Qd[0], Tau[0]), qdd, rtol=1e-8)
    aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED

    def rate(q: np.ndarray, qd: np.ndarray) -> object:
        pin.computeJointJacobiansTimeVariation(model, data, q, qd)
        return pin.getFrameJacobianTimeVariation(model, data, tool, aligned)

    for what, ours, single, theirs in (
        (
            "mass matrix",
            lambda: dynamics.mass_matrix(Q),
            lambda: [dynamics.mass_matrix(q) for q in Q[:few]],
            lambda: [pin.crba(model, data, q) for q in Q[:few]],
        ),
        (
            "forward dynamics",
            lambda: dynamics.forward(Q, Qd, Tau),
            lambda: [dynamics.forward(*state) for state in states],
            lambda: [pin.aba(model, data, *state) for state in states],
        ),
        (
            "Coriolis matrix",
            lambda: dynamics.coriolis_matrix(Q, Qd),
            lambda: [dynamics.coriolis_matrix(q, qd) for q, qd, _ in states],
            lambda: [pin.computeCoriolisMatrix(model, data, q, qd) for q, qd, _ in states],
        ),
        (
            "Jacobian's rate",
            lambda: jacobian_rate(arm, Q, Qd),
            lambda: [jacobian_rate(arm, q, qd) for q, qd, _ in states],
            lambda: [rate(q, qd) for q, qd, _ in states],
        ),
    ):
        times = shortest(ours, single, theirs, number=1, rounds=7)
        batch, looped, peer = (1e6 * t / k for t, k in zip(times, (m, few, few), strict=True))
        print(
            f"{arm.name + ': ' + what:28} batch {batch:6.2f} us ({batch / peer:5.2f}x)  one call "
            f"{looped:6.2f} us ({looped / peer:5.2f}x)  Pinocchio {peer:6.2f} us"
        )


def main() -> None:
    """Print where and when, then a table for each arm."""
    print(f"{datetime.datetime.now(tz=datetime.UTC):%Y-%m-%d %H:%M} UTC, {platform.platform()}")
    print(f"{processor()}, cores {sorted(os.sched_getaffinity(0))}, numpy {np.__version__}")
    pin = imported("pinocchio")
    if pin is None:
        return
    for name in MODELS:
        compare(pin, arm_of(name), 10_000)


if __name__ == "__main__":
    main()
