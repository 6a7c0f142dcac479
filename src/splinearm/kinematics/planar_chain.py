"""Arms whose axes are all parallel, in closed form: planar 2R and 3R, SCARA with its slide."""

from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray

from . import chain as chains
from .chain import Chain

_LENGTH = 1e-9
_SLACK = 1e-9


class PlanarChain(NamedTuple):
    """A chain of parallel axes, seen in the plane across them at q = 0."""

    T_base_plane: FloatArray
    """Pose of the plane in base, z along the first axis, shape (4, 4)."""
    T_plane_tool: FloatArray
    """Pose of the tool there at q = 0, shape (4, 4)."""
    axes: FloatArray
    """Where the turning axes cross the plane, complex, shape (2,) or (3,)."""
    turning: tuple[int, ...]
    """Which joints turn."""
    sliding: int | None
    """Which joint slides."""
    sign: FloatArray
    """1 where a joint's axis points as the first one does, else -1, shape (n,)."""


def find(chain: Chain) -> PlanarChain:
    """Give what the chain is at q = 0; all its axes are taken to be parallel."""
    n = len(chain.turns)
    frames = chains.joint_frames(chain, np.zeros(n))
    seen = np.linalg.solve(frames[0], frames)
    turning = tuple(int(k) for k in np.flatnonzero(chain.turns))
    sliding = [int(k) for k in np.flatnonzero(chain.slides)]
    return PlanarChain(
        T_base_plane=frames[0],
        T_plane_tool=seen[n],
        axes=np.array([complex(seen[k, 0, 3], seen[k, 1, 3]) for k in turning]),
        turning=turning,
        sliding=sliding[0] if sliding else None,
        sign=np.sign(seen[:n, 2, 2]),
    )


def solve(
    planar: PlanarChain, T: FloatArray, seed: FloatArray, *, oriented: bool
) -> tuple[FloatArray, FloatArray]:
    """Give branches (m, n) and what they are (m,), of a pose or of a position alone.

    With a position alone the last of three turning joints keeps its seed. Height and tilt are not
    checked here where no joint changes them.
    """
    T_plane = np.linalg.solve(planar.T_base_plane, T)
    point = complex(T_plane[0, 3], T_plane[1, 3])
    tool = complex(planar.T_plane_tool[0, 3], planar.T_plane_tool[1, 3])
    turned = T_plane[:3, :3] @ planar.T_plane_tool[:3, :3].T
    angle = float(np.arctan2(turned[1, 0] - turned[0, 1], turned[0, 0] + turned[1, 1]))
    q = np.array(seed, dtype=np.float64)
    if planar.sliding is not None:
        lift = T_plane[2, 3] - planar.T_plane_tool[2, 3]
        q[planar.sliding] = planar.sign[planar.sliding] * lift
    sign = planar.sign[list(planar.turning)]
    if len(planar.turning) == 3:
        hand = tool - planar.axes[2]
        if oriented:
            wrist, tip = point - np.exp(1j * angle) * hand, planar.axes[2]
        else:
            last = np.exp(1j * sign[2] * seed[planar.turning[2]])
            wrist, tip = point, planar.axes[2] + last * hand
    else:
        wrist, tip = point, tool
    upper, lower = planar.axes[1] - planar.axes[0], tip - planar.axes[1]
    way = wrist - planar.axes[0]
    branches, codes = [], []
    for code, (first, second) in enumerate(_elbows(upper, lower, way, q, planar)):
        one = q.copy()
        one[planar.turning[0]] = sign[0] * first
        one[planar.turning[1]] = sign[1] * second
        if len(planar.turning) == 3 and oriented:
            one[planar.turning[2]] = sign[2] * _wrapped(angle - first - second)
        branches.append(one)
        codes.append(2.0 * code)
    return np.array(branches).reshape(-1, len(q)), np.array(codes)


def _elbows(
    upper: complex, lower: complex, way: complex, q: FloatArray, planar: PlanarChain
) -> list[tuple[float, float]]:
    """Give first and second turn that lay two links (complex, at zero) along a way."""
    long, short, far = abs(upper), abs(lower), abs(way)
    if min(long, short) < _LENGTH:
        return []
    cos = (far * far - long * long - short * short) / (2.0 * long * short)
    if abs(cos) > 1.0 + _SLACK:
        return []
    bend = float(np.arccos(np.clip(cos, -1.0, 1.0)))
    bends = (bend, -bend) if bend not in (0.0, float(np.pi)) else (bend,)
    rest = float(np.angle(lower / upper))
    found = []
    for angle in bends:
        reached = upper + lower * np.exp(1j * (angle - rest))
        if far < _LENGTH:
            first = float(planar.sign[planar.turning[0]] * q[planar.turning[0]])
        else:
            first = float(np.angle(way / reached))
        found.append((first, _wrapped(angle - rest)))
    return found


def _wrapped(angle: float) -> float:
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)
