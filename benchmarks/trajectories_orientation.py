"""Orientation curves through twelve random orientations, beside scipy, Drake and interpolatepy.

Run it on one core, for example ``taskset -c 1 python benchmarks/trajectories_orientation.py``.
Times are the best of several repeats; what counts is the ratio within one run. Jumps are those of
a curve's own rates across its inner orientations; how wrong these are, and the root of the mean
squared angular acceleration, come from differences of sixth order of its orientations. A peer that
is not installed is left out, with its reason.
"""

import datetime
import os
import platform
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from kinematics_forward import imported, processor, shortest

from splinearm.kinematics import quaternion
from splinearm.trajectories.orientation import RotationPolyline, interpolate_orientations
from splinearm.trajectories.squad import Squad

WANTED_US = 0.6
"""For one sample with velocity and acceleration into a given array."""

# differences of sixth order at -3 .. 3 steps (Fornberg, Math. Comp. 51 (1988) 699, tables 1 and 2)
FIRST = np.array((-1 / 60, 3 / 20, -3 / 4, 0.0, 3 / 4, -3 / 20, 1 / 60))
SECOND = np.array((1 / 90, -3 / 20, 3 / 2, -49 / 18, 3 / 2, -3 / 20, 1 / 90))
STEP = 4e-3

Sample = Callable[[float], tuple[np.ndarray, np.ndarray, np.ndarray]]


class Curve(NamedTuple):
    """A curve to look at."""

    name: str
    one: Callable[[], object]
    """One sample with velocity and acceleration, to be timed."""
    at: Sample
    """Orientation w x y z, angular velocity and acceleration at a parameter."""


def ours(u: np.ndarray, quats: np.ndarray) -> Iterator[Curve]:
    """Give our curves."""
    for name, curve in (
        ("B-spline, cubic", interpolate_orientations(u, quats)),
        ("B-spline, quintic", interpolate_orientations(u, quats, degree=5)),
    ):
        state = np.empty(10)
        yield Curve(
            f"{name}, into", lambda curve=curve, state=state: curve.into(4.321, state), _one(curve)
        )
        yield Curve(f"{name}, at", lambda curve=curve: curve.at(_HERE), _one(curve))
    squad, chain = Squad(u, quats), RotationPolyline(u, quats, np.zeros(len(u)))
    yield Curve("squad", lambda: squad.at(_HERE), _one(squad))
    yield Curve("slerps", lambda: chain.at(_HERE), _one(chain))


_HERE = np.array([4.321])


def _one(curve: object) -> Sample:
    return lambda u: tuple(part[0] for part in curve.at(np.array([u])))


def of_scipy(u: np.ndarray, quats: np.ndarray) -> Iterator[Curve]:
    """Give scipy's cubic rotation vectors."""
    transform = imported("scipy.spatial.transform")
    if transform is None:
        return
    rotations = transform.Rotation.from_quat(quaternion.to_xyzw(quats))
    spline = transform.RotationSpline(u, rotations)

    def at(x: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return quaternion.from_xyzw(spline(x).as_quat()), spline(x, 1), spline(x, 2)

    yield Curve(
        "scipy RotationSpline", lambda: (spline(4.321), spline(4.321, 1), spline(4.321, 2)), at
    )


def of_drake(u: np.ndarray, quats: np.ndarray) -> Iterator[Curve]:
    """Give Drake's slerps."""
    trajectories, eigen = (
        imported("pydrake.trajectories"),
        imported("pydrake.common.eigen_geometry"),
    )
    if trajectories is None or eigen is None:
        return
    slerp = trajectories.PiecewiseQuaternionSlerp(list(u), [eigen.Quaternion(q) for q in quats])

    def at(x: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return (
            slerp.orientation(x).wxyz(),
            slerp.angular_velocity(x),
            slerp.angular_acceleration(x),
        )

    def one() -> object:
        return (
            slerp.orientation(4.321),
            slerp.angular_velocity(4.321),
            slerp.angular_acceleration(4.321),
        )

    yield Curve("Drake PiecewiseQuaternionSlerp", one, at)


def of_interpolatepy(u: np.ndarray, quats: np.ndarray) -> Iterator[Curve]:
    """Give interpolatepy's three."""
    peer = imported("interpolatepy")
    if peer is None:
        return
    given = [peer.Quaternion(*quat) for quat in quats]
    for name, kind in (
        ("interpolatepy squad", lambda: peer.QuaternionSpline(list(u), given, "squad")),
        ("interpolatepy SquadC2", lambda: peer.SquadC2(list(u), given)),
        (
            "interpolatepy LogQuaternion",
            lambda: peer.LogQuaternionInterpolation(list(u), given),
        ),
    ):
        curve = kind()

        def at(x: float, curve: object = curve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            quat = curve.evaluate(x)
            return (
                quaternion.normalize(np.array((quat.w, *(getattr(quat, k) for k in "xyz")))),
                np.ravel(curve.evaluate_velocity(x)),
                np.ravel(curve.evaluate_acceleration(x)),
            )

        def one(curve: object = curve) -> object:
            return (
                curve.evaluate(4.321),
                curve.evaluate_velocity(4.321),
                curve.evaluate_acceleration(4.321),
            )

        yield Curve(name, one, at)


def differences(curve: Curve, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give angular velocity and acceleration of the orientations, in the fixed frame."""
    around = np.array([[curve.at(x + k * STEP)[0] for k in range(-3, 4)] for x in at])
    turned = quaternion.multiply(around, quaternion.conjugate(around[:, 3:4]))
    vectors = quaternion.log(turned)
    return (
        np.einsum("k,mki->mi", FIRST, vectors) / STEP,
        np.einsum("k,mki->mi", SECOND, vectors) / STEP**2,
    )


def look(curve: Curve, u: np.ndarray) -> tuple[float, float, float, float, float]:
    """Give jumps of the own rates, how wrong these are, and the rms acceleration."""
    tiny = 1e-9
    before, behind = ([curve.at(x + d)[1:] for x in u[1:-1]] for d in (-tiny, tiny))
    jumps = np.abs(np.array(before) - np.array(behind)).max(axis=(0, 2))
    at = (u[:-1, None] + np.diff(u)[:, None] * np.linspace(0.02, 0.98, 60)).ravel()
    omega, alpha = differences(curve, at)
    quat, own_omega, own_alpha = (np.array(part) for part in zip(*map(curve.at, at), strict=True))
    # a peer may write its rates in the body: that is not called wrong
    body = quaternion.conjugate(quat)
    wrong = [
        min(
            np.abs(own - true).max(),
            np.abs(own - quaternion.rotate(body, true)).max(),
        )
        for own, true in ((own_omega, omega), (own_alpha, alpha))
    ]
    rms = float(np.sqrt(np.mean(np.sum(alpha**2, axis=1))))
    return float(jumps[0]), float(jumps[1]), float(wrong[0]), float(wrong[1]), rms


def compare(u: np.ndarray, quats: np.ndarray) -> None:
    """Print the table."""
    curves = [
        curve for make in (ours, of_scipy, of_drake, of_interpolatepy) for curve in make(u, quats)
    ]
    times = shortest(*(curve.one for curve in curves), number=2000, rounds=25)
    print(
        f"{'':32} {'us a sample':>11} {'jump rad/s':>10} {'rad/s2':>9} "
        f"{'wrong rad/s':>11} {'rad/s2':>9} {'rms rad/s2':>10}"
    )
    for curve, time in zip(curves, times, strict=True):
        jump, jump2, wrong, wrong2, rms = look(curve, u)
        print(
            f"{curve.name:32} {1e6 * time:11.2f} {jump:10.1e} {jump2:9.1e} "
            f"{wrong:11.1e} {wrong2:9.1e} {rms:10.3f}"
        )
    met = "met" if 1e6 * times[0] <= WANTED_US else "NOT MET"
    print(f"one sample into a given array: {1e6 * times[0]:.2f} us, want <= {WANTED_US} us: {met}")


def compare_smoothness(cases: int) -> None:
    """Print how the rms acceleration compares with scipy's over many draws."""
    if imported("scipy.spatial.transform") is None:
        return
    for what, turn in (("any", None), ("1 rad apart", 1.0), ("3.1 rad apart", 3.1)):
        ratios = []
        for seed in range(cases):
            u, quats = draw(seed, turn)
            at = np.linspace(u[0], u[-1], 1500)
            alpha = interpolate_orientations(u, quats).at(at).alpha
            spline = next(of_scipy(u, quats))
            peer = spline.at(at)[2]
            ratios.append(np.sqrt(np.mean(np.sum(alpha**2, 1)) / np.mean(np.sum(peer**2, 1))))
        print(
            f"rms acceleration over scipy's, 12 orientations {what:14} {cases} draws: "
            f"median {np.median(ratios):.3f}, worst {max(ratios):.3f}"
        )


def draw(seed: int, turn: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Give even parameters and twelve orientations, any or so far apart."""
    rng = np.random.default_rng(seed)
    u = np.arange(12.0)
    if turn is None:
        return u, quaternion.random(rng, 12)
    steps = rng.normal(size=(12, 3))
    steps *= turn / np.linalg.norm(steps, axis=1, keepdims=True)
    quats = [quaternion.random(rng)]
    for step in steps[1:]:
        quats.append(quaternion.multiply(quats[-1], quaternion.exp(step)))
    return u, np.array(quats)


def batches(u: np.ndarray, quats: np.ndarray, m: int) -> None:
    """Print many samples at once."""
    curve = interpolate_orientations(u, quats)
    at = np.linspace(u[0], u[-1], m)
    mixed = np.random.default_rng(0).permutation(at)
    works = [lambda: curve.at(at), lambda: curve.at(mixed)]
    names = ["sorted", "in any order"]
    spline = next(of_scipy(u, quats), None)
    if spline is not None:
        works.append(lambda: spline.at(at))
        names.append("scipy, sorted")
    times = shortest(*works, number=1, rounds=15)
    for name, time in zip(names, times, strict=True):
        print(f"{m} samples {name:14} {1e3 * time:8.2f} ms, {1e9 * time / m:7.1f} ns each")


def main() -> None:
    """Print where and when, then the tables."""
    print(f"{datetime.datetime.now(tz=datetime.UTC):%Y-%m-%d %H:%M} UTC, {platform.platform()}")
    print(f"{processor()}, cores {sorted(os.sched_getaffinity(0))}, numpy {np.__version__}")
    u, quats = draw(0, None)
    compare(u, quats)
    batches(u, quats, 100_000)
    compare_smoothness(40)


if __name__ == "__main__":
    main()
