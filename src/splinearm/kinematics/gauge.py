"""An arm in its simplest frames: standard Denavit-Hartenberg rows found from any chain.

Frames may be slid and turned along the joint axes without changing the arm. Here they are laid so
that each constant transform is one standard DH row, that parallel axes point the same way, and
that what is zero is exactly zero::

    T_base_tool = first D(0) D(1) ... D(n-1) last,   D = Rz(theta) Tz(d) Tx(a) Rx(alpha)

where theta = offset + sign q of a turning joint; the last row is a mere turn.
"""

from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray

from . import chain as chains
from .chain import Chain

ZERO = 1e-10
"""Below this a length (m) or the sine of an angle is meant to be zero."""
_AGREE = 1e-8
_FAR = 1e3
"""How many lengths of the arm away two axes may come nearest to each other."""


class Gauge(NamedTuple):
    """A chain as standard DH rows, for the functions of the closed forms."""

    rows: FloatArray
    """a, d, cos(alpha), sin(alpha) of every joint, shape (n, 4)."""
    offset: FloatArray
    """theta (d where a joint slides) of every joint at q = 0, shape (n,)."""
    sign: FloatArray
    """1 where theta grows with q, -1 where it falls, shape (n,)."""
    first: FloatArray
    """Pose of the first row's frame in base, shape (4, 4)."""
    last: FloatArray
    """Pose of the tool in the last row's frame, shape (4, 4)."""
    slides: FloatArray
    """1 where a joint slides, shape (n,)."""

    def parallel(self, k: int) -> bool:
        """Say whether the axes of joints k and k + 1 are parallel."""
        return bool(self.rows[k, 3] == 0.0)

    def meeting(self, k: int) -> bool:
        """Say whether the axes of joints k and k + 1 meet in one point."""
        return bool(self.rows[k, 0] == 0.0 and self.rows[k, 3] != 0.0)

    def spherical(self, k: int) -> bool:
        """Say whether the axes of joints k, k + 1 and k + 2 meet in one point."""
        return self.meeting(k) and self.meeting(k + 1) and bool(self.rows[k + 1, 1] == 0.0)


def reverse(chain: Chain) -> Chain:
    """Give the chain from the tool to the base; its joints are -q in the opposite order."""
    fixed = np.linalg.inv(chain.fixed[::-1])
    fixed[:, 3] = (0.0, 0.0, 0.0, 1.0)
    return Chain(
        fixed=np.ascontiguousarray(fixed),
        joint_link=chain.joint_link[::-1],
        turns=chain.turns[::-1],
        slides=chain.slides[::-1],
        any_slide=chain.any_slide,
    )


def lock(chain: Chain, joint: int, q: float) -> Chain:
    """Give the chain whose ``joint`` stands still at ``q``: one joint less."""
    motion = np.eye(4)
    if chain.turns[joint]:
        c, s = np.cos(q), np.sin(q)
        motion[:2, :2] = ((c, -s), (s, c))
    else:
        motion[2, 3] = q
    merged = chain.fixed[joint] @ motion @ chain.fixed[joint + 1]
    slides = np.delete(chain.slides, joint)
    return Chain(
        fixed=np.concatenate((chain.fixed[:joint], merged[None], chain.fixed[joint + 2 :])),
        joint_link=np.delete(chain.joint_link, joint, axis=0),
        turns=1.0 - slides,
        slides=slides,
        any_slide=bool(slides.any()),
    )


def without(chain: Chain, joint: int, q: float) -> Chain:
    """Give the chain without a joint: cut off at either end, else locked at q."""
    n = len(chain.turns)
    if 0 < joint < n - 1:
        return lock(chain, joint, q)
    kept = slice(1, None) if joint == 0 else slice(0, n - 1)
    fixed = chain.fixed[1:] if joint == 0 else chain.fixed[:-1]
    return Chain(
        fixed=fixed,
        joint_link=chain.joint_link[kept],
        turns=chain.turns[kept],
        slides=chain.slides[kept],
        any_slide=bool(chain.slides[kept].any()),
    )


def find(chain: Chain) -> Gauge:
    """Give the simplest frames of a chain.

    Raises:
        ValueError: If the frames found do not describe the chain (nearly parallel axes).
    """
    n = len(chain.turns)
    frames = chains.joint_frames(chain, np.zeros(n))
    points, axes = frames[:n, :3, 3], frames[:n, :3, 2].copy()
    sign = np.ones(n)
    for k in range(1, n):
        if axes[k] @ axes[k - 1] < 0.0 and _sine(axes[k - 1], axes[k]) < ZERO:
            axes[k], sign[k] = -axes[k], -1.0
    placed = _lay(points, axes)
    rows, offset = np.zeros((n, 4)), np.zeros(n)
    rows[:, 2] = 1.0
    for k in range(n - 1):
        step = np.linalg.solve(placed[k], placed[k + 1])
        theta = np.arctan2(step[1, 0], step[0, 0])
        rows[k] = (
            step[0, 3] * np.cos(theta) + step[1, 3] * np.sin(theta),
            step[2, 3],
            step[2, 2],
            step[2, 1],
        )
        offset[k] = theta
    rows[np.abs(rows) < ZERO] = 0.0
    for k in range(n):
        for column in (2, 3):
            if rows[k, 5 - column] == 0.0:
                rows[k, column] = np.sign(rows[k, column])
    offset = np.where(chain.slides == 1.0, 0.0, offset)
    found = Gauge(
        rows=rows,
        offset=offset,
        sign=sign,
        first=placed[0],
        last=np.linalg.solve(placed[n - 1], frames[n]),
        slides=chain.slides.copy(),
    )
    if not chain.any_slide:
        _check(chain, found)
    return found


def _lay(points: FloatArray, axes: FloatArray) -> FloatArray:
    """Give the frame of each axis, shape (n, 4, 4), x along the common normal from the last."""
    n = len(axes)
    placed = np.tile(np.eye(4), (n, 1, 1))
    origin, x = points[0], _across(axes[0])
    for k in range(n):
        if k:
            origin, x = _next(origin, axes[k - 1], x, points[k], axes[k])
        elif n > 1 and _sine(axes[0], axes[1]) >= ZERO:
            at, _ = _feet(points[0], axes[0], points[1], axes[1])
            _, x = _next(at, axes[0], x, points[1], axes[1])
            origin = at
        elif n > 1:
            _, x = _next(origin, axes[0], x, points[1], axes[1])
        x = x - axes[k] * (axes[k] @ x)
        x = x / np.linalg.norm(x)
        placed[k, :3, 0] = x
        placed[k, :3, 1] = np.cross(axes[k], x)
        placed[k, :3, 2] = axes[k]
        placed[k, :3, 3] = origin
    return placed


def _next(
    origin: FloatArray, z: FloatArray, x: FloatArray, point: FloatArray, axis: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Give origin and x of the frame on the next axis."""
    if _sine(z, axis) < ZERO:
        foot = point + axis * (axis @ (origin - point))
        way = foot - origin
        length = float(np.linalg.norm(way))
        return foot, (way / length if length >= ZERO else x)
    at, foot = _feet(origin, z, point, axis)
    normal = np.cross(z, axis)
    normal /= np.linalg.norm(normal)
    return foot, (-normal if (foot - at) @ normal < -ZERO else normal)


def _feet(
    point: FloatArray, axis: FloatArray, other: FloatArray, along: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Give the points of two lines that are nearest to each other."""
    normal = np.cross(axis, along)
    square = normal @ normal
    way = other - point
    return (
        point + axis * (np.cross(way, along) @ normal / square),
        other + along * (np.cross(way, axis) @ normal / square),
    )


def _across(axis: FloatArray) -> FloatArray:
    """Give a unit vector square to an axis."""
    x = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    unit: FloatArray = x / np.linalg.norm(x)
    return unit


def _sine(a: FloatArray, b: FloatArray) -> float:
    return float(np.linalg.norm(np.cross(a, b)))


def forward(gauge: Gauge, q: FloatArray) -> FloatArray:
    """Give T_base_tool, shape (4, 4), from the rows, at one joint vector (turning joints)."""
    T = gauge.first
    for k, angle in enumerate(q):
        T = T @ step(gauge, k, float(angle))
    T_base_tool: FloatArray = T @ gauge.last
    return T_base_tool


def step(gauge: Gauge, k: int, q: float) -> FloatArray:
    """Give the transform of row k, shape (4, 4), its joint (a turning one) at q."""
    a, d, ca, sa = gauge.rows[k]
    theta = gauge.offset[k] + gauge.sign[k] * q
    c, s = np.cos(theta), np.sin(theta)
    # standard DH, Siciliano et al. 2009, eq. 2.52
    return np.array(
        ((c, -s * ca, s * sa, a * c), (s, c * ca, -c * sa, a * s), (0, sa, ca, d), (0, 0, 0, 1))
    )


def _check(chain: Chain, found: Gauge) -> None:
    length = float(np.linalg.norm(chain.fixed[:, :3, 3], axis=1).sum())
    lengths = (found.rows[:, :2].ravel(), found.first[:3, 3], found.last[:3, 3])
    if np.abs(np.concatenate(lengths)).max() > _FAR * length:
        raise ValueError("arm: axes so nearly parallel that they meet far away")
    rng = np.random.default_rng(0)
    for _ in range(3):
        q = rng.uniform(-np.pi, np.pi, len(found.offset))
        error = np.abs(forward(found, q) - chains.fk(chain, q)).max()
        if error > _AGREE:
            raise ValueError(
                f"arm: its axes are too nearly parallel to be told apart ({error:.2g})"
            )
