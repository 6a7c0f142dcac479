"""What branches look like, in words.

- shoulder left, right: the two ways the first joint can face; left is the one that is farther
  against the clock about it, from the direction that its equation names.
- elbow up, down: over or under the line from the second joint to the wrist, seen along base z
  (for planar arms: left or right of the way to the target, as module planar has it).
- wrist flipped: the other sign of the wrist's middle joint (six joints), or the tool held from
  the other side (four and five).
- branch 1, 2 ...: merely numbered, of six joints without a structure that would name them.
"""

import numpy as np

from splinearm.arrays import FloatArray

from . import chain as chains
from .arm import Arm
from .structure import ArmClass, Structure

_LEVEL = 1e-6
_PARALLEL_BASE = 0.0
_BY_NUMBER = (ArmClass.SPHERICAL_SHOULDER,)


def name(arm: Arm, structure: Structure, q: FloatArray, code: float) -> str:
    """Give the words of one branch, by its number as the kernels count."""
    bits = int(code)
    if structure.kind is ArmClass.GENERAL:
        return f"branch {bits + 1}"
    if structure.kind is ArmClass.PLANAR:
        return "elbow up" if bits & 2 else "elbow down"
    shoulder = "shoulder right" if bits & 4 else "shoulder left"
    wrist = ", wrist flipped" if bits & 1 else ""
    return f"{shoulder}, {_elbow(arm, structure, q, bits)}{wrist}"


def _elbow(arm: Arm, structure: Structure, q: FloatArray, bits: int) -> str:
    packed = structure.packed
    flat = packed[-1, 1] == _PARALLEL_BASE and structure.kind not in _BY_NUMBER
    by_number = bool(bits & 2)
    if not flat or packed[-1, 2] or len(q) == 7:
        return "elbow 2" if by_number else "elbow 1"
    frames = chains.joint_frames(arm.packed, q)
    axis = frames[1, :3, 2]
    shoulder, elbow, wrist = frames[1, :3, 3], frames[2, :3, 3], frames[3, :3, 3]
    if structure.kind is ArmClass.SPHERICAL_WRIST and structure.gauge is not None:
        wrist = np.linalg.solve(structure.gauge.last.T, frames[-1].T).T[:3, 3]
    way, bend = wrist - shoulder, elbow - shoulder
    way, bend = way - axis * (axis @ way), bend - axis * (axis @ bend)
    length = float(np.linalg.norm(way))
    if length > 0.0:
        way = way / length
    aside = bend - way * (way @ bend)
    # which side is up: seen along the axes, the way turned a quarter that has base z in it
    if abs(aside[2]) > _LEVEL:
        return "elbow up" if aside[2] > 0.0 else "elbow down"
    return "elbow down" if by_number else "elbow up"
