"""Time laws beside copp, toppra and Drake: what they take, how quick they are, what they break.

Run it on one core, for example ``taskset -c 1 python benchmarks/trajectories_timing.py``. Times are
the best of several rounds in which all take turns, meant over seven paths. Every law is looked at
ten times between its nodes; ``T/T*`` is its duration, once slowed until no limit is broken there,
over that of a law of ours on 50 000 cells. A peer that is not installed is left out, with its
reason.
"""

import datetime
import logging
import os
import platform
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from types import ModuleType

import numpy as np
from kinematics_forward import imported, processor, shortest

from splinearm.arrays import ArrayInput
from splinearm.curves.interpolation import interpolate
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics import Arm, DHConvention, DHLink, Inertia
from splinearm.kinematics.dynamics import Dynamics
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.limit import MotionLimits
from splinearm.trajectories.time_law import TimeLaw
from splinearm.trajectories.timing import quickest

PANDA = ([2.175] * 4 + [2.61] * 3, [15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0])
"""Franka Emika: velocities and accelerations of the Panda."""

UR5 = [
    (0.0, np.pi / 2, 0.089159, 3.7),
    (-0.425, 0.0, 0.0, 8.393),
    (-0.39225, 0.0, 0.0, 2.275),
    (0.0, np.pi / 2, 0.10915, 1.219),
    (0.0, -np.pi / 2, 0.09465, 1.219),
    (0.0, 0.0, 0.0823, 0.1879),
]
"""Universal Robots: a, alpha, d and mass of the UR5; bodies are taken as even rods."""

TORQUES = [150.0, 150.0, 150.0, 28.0, 28.0, 28.0]
SEEDS = range(7)
QUICK = ("splinearm quickest", "copp topp2_ra (samples given)")
"""Who takes little: they take turns two calls at a time."""


@dataclass(frozen=True, eq=False)
class Task:
    """A path, its limits and a grid for those who want one."""

    path: JointPath
    limits: JointLimits
    s: np.ndarray
    dynamics: Dynamics | None = None

    @property
    def wanted(self) -> JointLimits | MotionLimits:
        """What ``quickest`` takes."""
        if self.dynamics is None:
            return self.limits
        return MotionLimits(joints=self.limits, dynamics=self.dynamics)


def joint_limits(
    qd_max: ArrayInput, qdd_max: ArrayInput, torque_max: ArrayInput | None = None
) -> JointLimits:
    """Give limits of turning joints."""
    n = np.size(qd_max)
    return JointLimits(
        names=tuple(f"joint{i + 1}" for i in range(n)),
        kinds=(JointKind.REVOLUTE,) * n,
        q_min=np.full(n, -1e9),
        q_max=np.full(n, 1e9),
        qd_max=qd_max,
        qdd_max=qdd_max,
        torque_max=torque_max,
    )


def way(seed: int, n: int, length: float = 1.0) -> JointPath:
    """Give a quintic path through eight random places."""
    points = np.random.default_rng(seed).uniform(-2.0, 2.0, (8, n)) * length
    return JointPath(interpolate(points, degree=5, parameters="uniform"))


def ur5_size() -> tuple[Dynamics, JointLimits]:
    """Give the dynamics of an arm of the UR5's size, and its limits."""
    limits = joint_limits([3.15] * 6, [20.0] * 6, torque_max=TORQUES)
    links = [DHLink(f"joint{i + 1}", a, alpha, d, 0.0) for i, (a, alpha, d, _) in enumerate(UR5)]
    bodies = [
        Inertia(m, np.array([-0.5 * a, 0.0, -0.5 * d]), m * (0.01 + a * a / 12.0) * np.eye(3))
        for a, _, d, m in UR5
    ]
    arm = Arm.from_dh("UR5 size", links, DHConvention.STANDARD, limits, inertias=bodies)
    return Dynamics(arm), limits


def ours(task: Task) -> TimeLaw:
    """Give our law."""
    return quickest(task.path, task.wanted, cells=len(task.s) - 1)


def copp_of(copp: ModuleType) -> Callable[[Task], TimeLaw]:
    """Give copp's TOPP2-RA; it is handed the path's derivatives, not timed."""
    sampled: dict[Task, tuple[np.ndarray, ...]] = {}

    def law(task: Task) -> TimeLaw:
        m, n = len(task.s), task.path.n
        if task not in sampled:
            sampled[task] = task.path.sample(task.s)
        if task.dynamics is None:
            robot = copp.Robot(n, capacity=m)
        else:
            bare, out = task.dynamics.bare_inverse(), np.empty(n)

            def inverse(q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
                bare(
                    np.ascontiguousarray(q),
                    np.ascontiguousarray(qd),
                    np.ascontiguousarray(qdd),
                    out,
                )
                return out

            robot = copp.Robot(n, capacity=m, inverse_dynamics=inverse)
        robot.append_s(task.s)
        robot.set_q(*sampled[task], 0)
        most = task.limits
        robot.add_velocity_limits(most.qd_max, -most.qd_max, start_idx_s=0, length=m)
        robot.add_acceleration_limits(most.qdd_max, -most.qdd_max, start_idx_s=0, length=m)
        if task.dynamics is not None:
            full = most.torque_max
            robot.add_torque_limits(full, -full, start_idx_s=0, length=m)
        module = copp.solver.topp2_ra
        problem = module.Problem(
            robot.constraints, idx_s_interval=(0, m - 1), a_boundary=(0.0, 0.0)
        )
        return TimeLaw(task.s, np.asarray(module.solve(problem, module.Options())))

    return law


def toppra_of(ta: ModuleType) -> Callable[[Task], TimeLaw]:
    """Give toppra with its usual solver and the interpolation scheme."""
    from toppra import algorithm, constraint

    ta.setup_logging("CRITICAL")

    class Way(ta.interpolator.AbstractGeometricPath):
        def __init__(self, path: JointPath) -> None:
            self.path = path

        @property
        def dof(self) -> int:
            return self.path.n

        @property
        def path_interval(self) -> np.ndarray:
            return np.array(self.path.domain)

        def __call__(self, s: np.ndarray, order: int = 0) -> np.ndarray:
            at = np.atleast_1d(np.asarray(s, dtype=float))
            values = self.path.sample(at)[order]
            return values if np.ndim(s) else values[0]

    def law(task: Task) -> TimeLaw:
        most = task.limits
        scheme = constraint.DiscretizationType.Interpolation

        def both(v: np.ndarray) -> np.ndarray:
            return np.stack((-v, v), axis=1)

        rows = [
            constraint.JointVelocityConstraint(both(most.qd_max)),
            constraint.JointAccelerationConstraint(
                both(most.qdd_max), discretization_scheme=scheme
            ),
        ]
        if task.dynamics is not None:
            bare, n = task.dynamics.bare_inverse(), task.path.n

            def inverse(q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
                out = np.empty(n)
                bare(*(np.ascontiguousarray(v) for v in (q, qd, qdd)), out)
                return out

            rows.append(
                constraint.JointTorqueConstraint(
                    inverse, both(most.torque_max), np.zeros(n), discretization_scheme=scheme
                )
            )
        solver = algorithm.TOPPRA(rows, Way(task.path), gridpoints=task.s, solver_wrapper="seidel")
        _, speed, _ = solver.compute_parameterization(0.0, 0.0)
        if speed is None or not np.isfinite(speed).all():
            raise RuntimeError("no solution")
        return TimeLaw(task.s, np.square(speed))

    return law


def drake_of(drake: ModuleType) -> Callable[[Task], TimeLaw]:
    """Give Drake's Toppra with the interpolation scheme; velocity and acceleration only."""
    from pydrake.math import BsplineBasis
    from pydrake.multibody.optimization import Toppra
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import RevoluteJoint, SpatialInertia
    from pydrake.trajectories import BsplineTrajectory

    def plant_of(n: int) -> object:
        plant = MultibodyPlant(0.0)
        parent = plant.world_body()
        for i in range(n):
            body = plant.AddRigidBody(f"b{i}", SpatialInertia.SolidSphereWithMass(1.0, 0.1))
            plant.AddJoint(
                RevoluteJoint(f"j{i}", parent.body_frame(), body.body_frame(), [0.0, 0.0, 1.0])
            )
            parent = body
        plant.Finalize()
        return plant

    logging.getLogger("drake").setLevel(logging.CRITICAL)  # it answers None as well
    plants: dict[int, object] = {}

    def law(task: Task) -> TimeLaw:
        curve = task.path.curve
        plant = plants.setdefault(task.path.n, None) or plant_of(task.path.n)
        plants[task.path.n] = plant
        basis = BsplineBasis(curve.degree + 1, curve.knots.tolist())
        path = BsplineTrajectory(basis, [p[:, None] for p in curve.points])
        problem = Toppra(path, plant, task.s)
        problem.AddJointVelocityLimit(-task.limits.qd_max, task.limits.qd_max)
        problem.AddJointAccelerationLimit(-task.limits.qdd_max, task.limits.qdd_max)
        found = problem.SolvePathParameterization()
        if found is None:
            raise RuntimeError("no solution")
        t = np.array(found.get_segment_times())
        speed = np.array([found.EvalDerivative(v, 1)[0, 0] for v in t])
        s = np.array([found.value(v)[0, 0] for v in t])
        return TimeLaw(s, np.square(speed))

    return law


def uses(task: Task, law: TimeLaw) -> dict[str, float]:
    """Give the largest share of each kind of limit, at ten places between nodes."""
    shares = np.linspace(0.0, 1.0, 11)
    s = (law.s[:-1, None] + np.diff(law.s)[:, None] * shares).ravel()
    x = (law.x[:-1, None] * (1.0 - shares) + law.x[1:, None] * shares).ravel()
    q, slope, bend = task.path.sample(s)
    qd = slope * np.sqrt(x)[:, None]
    qdd = slope * np.repeat(law.acceleration, len(shares))[:, None] + bend * x[:, None]
    found = {
        "velocity": np.abs(qd) / task.limits.qd_max,
        "acceleration": np.abs(qdd) / task.limits.qdd_max,
    }
    if task.dynamics is not None:
        found["torque"] = np.abs(task.dynamics.inverse(q, qd, qdd)) / task.limits.torque_max
    return {name: float(values.max()) for name, values in found.items()}


def slowed(task: Task, law: TimeLaw) -> float:
    """Give the duration of a law once it is slowed until it keeps all limits."""
    low, high = 0.5, 1.0
    if max(uses(task, law).values()) <= 1.0 + 1e-6:
        return law.duration
    for _ in range(30):
        share = 0.5 * (low + high)
        fits = max(uses(task, law.slower(share)).values()) <= 1.0 + 1e-6
        low, high = (share, high) if fits else (low, share)
    return law.duration / low


def compare(title: str, tasks: list[Task], peers: dict[str, Callable[[Task], TimeLaw]]) -> None:
    """Print a table of ours and the peers on some tasks."""
    print(f"\n{title}")
    best = [quickest(task.path, task.wanted, cells=50_000).duration for task in tasks]
    quick = {name: solve for name, solve in peers.items() if name in QUICK}
    slow = {name: solve for name, solve in peers.items() if name not in QUICK}
    took = {}
    for some, number, rounds in ((quick, 2, 60), (slow, 1, 5)):
        each = [
            shortest(
                *(partial(solve, task) for solve in some.values()), number=number, rounds=rounds
            )
            for task in tasks
        ]
        took.update(zip(some, np.mean(each, axis=0), strict=True))
    times = [took[name] for name in peers]
    for (name, solve), time in zip(peers.items(), times, strict=True):
        laws = [solve(task) for task in tasks]
        worst: dict[str, float] = {}
        for task, law in zip(tasks, laws, strict=True):
            for kind, share in uses(task, law).items():
                worst[kind] = max(worst.get(kind, 0.0), share)
        ratios = [slowed(t, law) / b for t, law, b in zip(tasks, laws, best, strict=True)]
        broken = "  ".join(f"{kind} {share - 1.0:+.1e}" for kind, share in worst.items())
        print(
            f"{name:30} {1e3 * time:8.3f} ms ({time / times[0]:6.1f}x)  "
            f"T/T* mean {np.mean(ratios):.5f} worst {max(ratios):.5f}  broken by {broken}"
        )


def in_units(peers: dict[str, Callable[[Task], TimeLaw]]) -> None:
    """Print who solves the same problem in other units."""
    print("\nthe same three problems (7 joints, N = 500) in other units: solved, worst error of T")
    cases = [(1e-7, 1.0), (1e-3, 1.0), (1e6, 1.0), (1.0, 1e-4), (1.0, 1e3), (1.0, 1e4)]
    print(f"{'lengths x, times x':30} " + " ".join(f"{a:g}, {b:g}".rjust(16) for a, b in cases))
    s = np.linspace(0.0, 7.0, 501)
    for name, solve in peers.items():
        words = []
        for length, time in cases:
            solved, error = 0, 0.0
            for seed in range(3):
                want = solve(Task(way(seed, 7), joint_limits(*PANDA), s)).duration
                qd_max, qdd_max = (np.array(v) * length for v in PANDA)
                other = joint_limits(qd_max / time, qdd_max / time**2)
                try:
                    law = solve(Task(way(seed, 7, length), other, s))
                except (RuntimeError, ValueError, AttributeError, TypeError):
                    continue
                if np.isfinite(law.duration) and abs(law.duration / (want * time) - 1.0) < 0.1:
                    solved += 1
                    error = max(error, abs(law.duration / (want * time) - 1.0))
            words.append(f"{solved}/3 {error:.0e}".rjust(16))
        print(f"{name:30} " + " ".join(words))


def main() -> None:
    """Print where and when, then the tables."""
    print(f"{datetime.datetime.now(tz=datetime.UTC):%Y-%m-%d %H:%M} UTC, {platform.platform()}")
    print(f"{processor()}, cores {sorted(os.sched_getaffinity(0))}, numpy {np.__version__}")
    peers: dict[str, Callable[[Task], TimeLaw]] = {QUICK[0]: ours}
    for module, name, make in (
        ("copp_py", QUICK[1], copp_of),
        ("toppra", "toppra (Python, seidel)", toppra_of),
        ("pydrake", "Drake Toppra", drake_of),
    ):
        found = imported(module)
        if found is not None:
            peers[name] = make(found)
    for cells in (300, 1000):
        s = np.linspace(0.0, 7.0, cells + 1)
        tasks = [Task(way(seed, 7), joint_limits(*PANDA), s) for seed in SEEDS]
        compare(f"velocity and acceleration, 7 joints, N = {cells}", tasks, peers)
    dynamics, limits = ur5_size()
    s = np.linspace(0.0, 7.0, 501)
    weak = replace(limits, torque_max=np.array(TORQUES) * 0.6)
    with_torque = {name: solve for name, solve in peers.items() if "Drake" not in name}
    for title, most in (("", limits), (", torques x 0.6", weak)):
        tasks = [Task(way(seed, 6), most, s, dynamics) for seed in SEEDS]
        compare(f"and torques of an arm of the UR5's size{title}, N = 500", tasks, with_torque)
    in_units(peers)


if __name__ == "__main__":
    main()
