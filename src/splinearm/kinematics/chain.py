"""A chain of joints as packed arrays: forward kinematics and Jacobian that check nothing.

Between the motions of two joints stands one constant transform, so that::

    T_base_tool = F[0] M(q[0]) F[1] M(q[1]) ... M(q[n-1]) F[n]

where M turns about z or slides along z. The product up to and with M(q[k]) is the pose of joint
k's moved frame; its z axis is the axis of the joint.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointKind

from .link import Link

_BLOCK = 512
"""Joint vectors worked on at a time, so that a block stays in the processor's cache."""


class Chain(NamedTuple):
    """What the functions here need of an arm."""

    fixed: FloatArray
    """The constant transforms F, shape (n + 1, 4, 4)."""
    joint_link: FloatArray
    """Pose of each link frame in its moved joint frame, shape (n, 4, 4)."""
    turns: FloatArray
    """1 where the joint turns, 0 where it slides, shape (n,)."""
    slides: FloatArray
    """1 where the joint slides, 0 where it turns, shape (n,)."""
    any_slide: bool
    """Whether any joint slides."""


def pack(links: Sequence[Link], T_base_first: FloatArray, T_flange_tool: FloatArray) -> Chain:
    """Give the chain of links between a base and a tool frame."""
    before = [T_base_first, *(link.T_joint_link for link in links)]
    after = [*(link.T_parent_joint for link in links), T_flange_tool]
    turns = np.array([float(link.kind is JointKind.REVOLUTE) for link in links])
    return Chain(
        fixed=np.array([a @ b for a, b in zip(before, after, strict=True)]),
        joint_link=np.array([link.T_joint_link for link in links]),
        turns=turns,
        slides=1.0 - turns,
        any_slide=bool((turns == 0.0).any()),
    )


def fk(chain: Chain, q: FloatArray) -> FloatArray:
    """Give T_base_tool, shape (4, 4), at one joint vector, shape (n,)."""
    steps = _steps(chain, q)
    T = steps[0]
    for step in steps[1:]:
        T = T.dot(step)
    T_base_tool: FloatArray = T.dot(chain.fixed[-1])
    return T_base_tool


def joint_frames(chain: Chain, q: FloatArray) -> FloatArray:
    """Give the pose of each moved joint frame and of the tool in base, shape (n + 1, 4, 4)."""
    frames = np.empty((len(q) + 1, 4, 4))
    frames[:-1] = _steps(chain, q)
    frames[-1] = chain.fixed[-1]
    for k in range(len(q)):
        frames[k].dot(frames[k + 1].copy(), out=frames[k + 1])
    return frames


def fk_and_jacobian(chain: Chain, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give T_base_tool, shape (4, 4), and the Jacobian, shape (6, n), at one joint vector."""
    frames = joint_frames(chain, q)
    T = frames[-1]
    axes = frames[:-1, :3, 2]
    jacobian = _columns(chain, axes.T, (T[:3, 3] - frames[:-1, :3, 3]).T)
    return T, jacobian


def fk_batch(chain: Chain, q: FloatArray) -> FloatArray:
    """Give T_base_tool, shape (m, 4, 4), at m joint vectors, shape (m, n)."""
    T = _empty_transforms(len(q))
    for block in _blocks(len(q)):
        carried = _start(chain, len(q[block]))
        for k, angle in enumerate(q[block].T):
            carried = _move(chain, k, carried, angle)
        T[block, :3] = np.moveaxis(chain.fixed[-1].T @ carried, -1, 0)
    return T


def frames_batch(chain: Chain, q: FloatArray) -> FloatArray:
    """Give the pose of each link frame in base, shape (m, n, 4, 4), at m joint vectors (m, n)."""
    m, n = q.shape
    frames = _empty_transforms(m, n)
    for block in _blocks(m):
        carried = _start(chain, len(q[block]))
        for k, angle in enumerate(q[block].T):
            carried = _move(chain, k, carried, angle)
            frames[block, k, :3] = np.moveaxis(chain.joint_link[k].T @ carried, -1, 0)
    return frames


def jacobian_batch(chain: Chain, q: FloatArray) -> FloatArray:
    """Give the Jacobian, shape (m, 6, n), at m joint vectors, shape (m, n)."""
    m, n = q.shape
    jacobian = np.empty((m, 6, n))
    for block in _blocks(m):
        width = len(q[block])
        axes, origins = np.empty((3, n, width)), np.empty((3, n, width))
        carried = _start(chain, width)
        for k, angle in enumerate(q[block].T):
            carried = _move(chain, k, carried, angle)
            axes[:, k], origins[:, k] = carried[:, 2], carried[:, 3]
        tool = (chain.fixed[-1].T @ carried)[:, 3]
        columns = _columns(chain, axes, tool[:, None] - origins)
        jacobian[block] = np.moveaxis(columns, -1, 0)
    return jacobian


def _columns(chain: Chain, axes: FloatArray, arms: FloatArray) -> FloatArray:
    """Give the Jacobian (6, n, ...) of joint axes (3, n, ...) and lever arms to the tool."""
    # Siciliano et al., Robotics: Modelling, Planning and Control, 2009, eq. 3.30
    jacobian = np.empty((6, *axes.shape[1:]))
    jacobian[0] = axes[1] * arms[2] - axes[2] * arms[1]
    jacobian[1] = axes[2] * arms[0] - axes[0] * arms[2]
    jacobian[2] = axes[0] * arms[1] - axes[1] * arms[0]
    jacobian[3:] = axes
    if chain.any_slide:
        sliding = chain.slides == 1.0
        jacobian[:3, sliding] = axes[:, sliding]
        jacobian[3:, sliding] = 0.0
    return jacobian


def _steps(chain: Chain, q: FloatArray) -> FloatArray:
    """Give F[k] M(q[k]) of every joint, shape (n, 4, 4)."""
    steps = chain.fixed[:-1].copy()
    angles = q * chain.turns if chain.any_slide else q
    cos, sin = np.cos(angles)[:, None], np.sin(angles)[:, None]
    x, y = chain.fixed[:-1, :, 0], chain.fixed[:-1, :, 1]
    steps[:, :, 0] = cos * x + sin * y
    steps[:, :, 1] = cos * y - sin * x
    if chain.any_slide:
        steps[:, :, 3] += (q * chain.slides)[:, None] * steps[:, :, 2]
    return steps


def _blocks(m: int) -> list[slice]:
    return [slice(start, start + _BLOCK) for start in range(0, m, _BLOCK)]


def _empty_transforms(*batch: int) -> FloatArray:
    T = np.empty((*batch, 4, 4))
    T[..., 3, :] = (0.0, 0.0, 0.0, 1.0)
    return T


def _start(chain: Chain, width: int) -> FloatArray:
    """Give F[0] without its last row for every vector of a block, shape (3, 4, width)."""
    return np.broadcast_to(np.eye(4)[:3, :, None], (3, 4, width))


def _move(chain: Chain, k: int, carried: FloatArray, q: FloatArray) -> FloatArray:
    """Give ``carried`` F[k] M(q), rows leading and vectors trailing, shape (3, 4, width)."""
    moved: FloatArray = chain.fixed[k].T @ carried
    if chain.turns[k]:
        cos, sin = np.cos(q), np.sin(q)
        x, y = moved[:, 0].copy(), moved[:, 1]
        moved[:, 0] = cos * x + sin * y
        moved[:, 1] = cos * y - sin * x
    else:
        moved[:, 3] += q * moved[:, 2]
    return moved
