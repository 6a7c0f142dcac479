"""The ways along which six joints of any kind are solved: chosen once an arm, by trial.

See module pencil_kernel for what a way is. Along some of them the determinant of an arm of special
structure is zero throughout, and near to such an arm it is small; so all ways are tried on poses of
the arm, and those that stay farthest from that and give back the joints the poses came from serve.
An arm that has lost a direction wherever it stands has no way that would.
"""

from dataclasses import replace
from itertools import permutations, product

import numpy as np

from splinearm.arrays import FloatArray

from . import gauge
from .structure import Structure

_ALL = np.array(
    [(drop, far, *two) for drop, far, two in product(range(6), (0, 1), permutations(range(3), 2))],
    dtype=np.float64,
)
_KEPT = 2
_TRIED = 36
_POSES = 48
_MEASURED = 4
_REGULAR = 1e-9
_FOUND = 1e-6
_STILL = 1e-9


def complete(found: Structure) -> Structure | None:
    """Give a structure of six joints with the ways that serve it; None if none does."""
    from . import general_six_kernel as kernel

    q, T = _poses(found)
    if not _moves(found, q):
        return None
    worst = np.empty(len(_ALL))
    kernel.regularity(found.packed, T[:_MEASURED], _ALL, worst)
    kept: list[FloatArray] = []
    for i in np.argsort(-worst, kind="stable")[:_TRIED]:
        if worst[i] < _REGULAR or len(kept) == _KEPT:
            break
        tried = _with_ways(found, _ALL[i : i + 1]).packed
        if all(_finds(tried, *one) for one in zip(T, q, strict=True)):
            kept.append(_ALL[i])
    return _with_ways(found, np.array(kept)) if kept else None


def complete_like(found: Structure, other: Structure) -> Structure | None:
    """Do the same for an arm that is like another one, whose ways are tried first."""
    from . import general_six_kernel as kernel

    ways = np.ascontiguousarray(other.packed[kernel.WAYS :, :4])
    _, T = _poses(found)
    worst = np.empty(len(ways))
    kernel.regularity(found.packed, T[:1], ways, worst)
    return _with_ways(found, ways) if (worst > _REGULAR).all() else complete(found)


def _with_ways(found: Structure, ways: FloatArray) -> Structure:
    from . import general_six_kernel as kernel

    rows = np.zeros((len(ways), 6))
    rows[:, :4] = ways
    return replace(found, packed=np.concatenate((found.packed[: kernel.WAYS], rows)))


def _poses(found: Structure) -> tuple[FloatArray, FloatArray]:
    """Give joint positions of an arm and the poses they lead to."""
    if found.gauge is None:
        raise ValueError(f"structure: want one in its simplest frames, got {found.words}")
    one = found.gauge
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (_POSES, 6))
    return q, np.array([gauge.forward(one, row) for row in q])


def _finds(packed: FloatArray, T: FloatArray, q: FloatArray) -> bool:
    """Say whether the first way leads back to q."""
    from . import general_six_kernel as kernel

    # a seed that is no answer, so that none is found from it
    found, _ = kernel.solve(packed, T, q + 1.0)
    apart = np.abs(np.sin(0.5 * (found - q))).max(axis=1)
    return bool(len(found) and apart.min() < _FOUND)


def _moves(found: Structure, q: FloatArray) -> bool:
    """Say whether the six joints can move in six ways somewhere."""
    if found.gauge is None:
        raise ValueError(f"structure: want one in its simplest frames, got {found.words}")
    for row in q[:_MEASURED]:
        frame, columns = np.eye(4), []
        for k in range(6):
            columns.append(np.concatenate((np.cross(frame[:3, 3], frame[:3, 2]), frame[:3, 2])))
            frame = frame @ gauge.step(found.gauge, k, float(row[k]))
        values = np.linalg.svd(np.array(columns), compute_uv=False)
        if values[-1] > _STILL * values[0]:
            return True
    return False
