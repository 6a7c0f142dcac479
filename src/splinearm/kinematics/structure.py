"""What class of arm a chain of joints is, so far as it has closed forms: found from the model."""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from splinearm.arrays import FloatArray

from . import gauge as gauges
from .chain import Chain
from .gauge import Gauge

_TOLERANCE = 1e-9
_ROWS = 13


class ArmClass(Enum):
    """How the joints of an arm come apart, so that its branches can be computed."""

    SPHERICAL_WRIST = "spherical wrist"
    """Six joints; the axes of the last three meet in a point."""

    SPHERICAL_SHOULDER = "spherical shoulder"
    """Six joints; the axes of the first three meet in a point."""

    THREE_PARALLEL = "three parallel axes"
    """Six joints; the second to fourth axes are parallel and the last two meet (UR)."""

    GENERAL = "six joints of any kind"
    """Six turning joints without such a structure: up to 16 branches, by eigenvalues."""

    SEVEN = "spherical shoulder, elbow and wrist"
    """Seven joints, the first three axes meeting and the fifth and sixth: the swivel is given."""

    PAN_AND_ROLL = "pan, three parallel axes and roll"
    """Five joints: one, three parallel, and a roll (Koch, ReactorX-150, WidowX-200)."""

    PAN = "pan and three parallel axes"
    """Four joints: one, and three parallel (OpenMANIPULATOR-X)."""

    PLANAR = "parallel axes"
    """Two or three turning joints about parallel axes, at most one that slides along them."""

    NONE = "no closed form"
    """None of these: numeric inverse kinematics serves it."""


_BASES = (
    "a base whose second and third axes are parallel",
    "a base whose first and second axes meet",
    "a base whose second and third axes meet",
    "a base whose first and second axes are parallel",
    "a base that asks for a quartic",
)


@dataclass(frozen=True, slots=True, eq=False)
class Structure:
    """The class of an arm and what its closed form needs."""

    kind: ArmClass
    """The class."""
    words: str
    """The class in words."""
    packed: FloatArray
    """The arm as its kernels take it, shape (n + 7, 6) or more; empty for other classes."""
    gauge: Gauge | None = None
    """The arm in its simplest frames, for the classes that use them."""


def find(chain: Chain) -> Structure:
    """Give the class of a chain of joints."""
    if _all_parallel(chain):
        return Structure(ArmClass.PLANAR, "all axes parallel", np.zeros((0, 6)))
    n = len(chain.turns)
    if chain.any_slide or n not in (4, 5, 6):
        return _none()
    try:
        gauge = gauges.find(chain)
        if n == 6:
            back = gauges.find(gauges.reverse(chain))
            return _six(gauge, reverse=False) or _six(back, reverse=True) or _general(gauge)
    except ValueError:
        return _none()
    return _few(gauge)


def _few(gauge: Gauge) -> Structure:
    """Give the class of four or five turning joints."""
    three = gauge.parallel(1) and gauge.parallel(2) and not gauge.parallel(0)
    if not three or min(abs(gauge.rows[1:3, 0])) == 0.0:
        return _none()
    if len(gauge.offset) == 4:
        return Structure(ArmClass.PAN, ArmClass.PAN.value, pack(gauge), gauge)
    if gauge.parallel(3):
        return _none()
    return Structure(ArmClass.PAN_AND_ROLL, ArmClass.PAN_AND_ROLL.value, pack(gauge), gauge)


def _none() -> Structure:
    return Structure(ArmClass.NONE, ArmClass.NONE.value, np.zeros((0, 6)))


def _six(gauge: Gauge, *, reverse: bool) -> Structure | None:
    """Give the class of six turning joints, or None when it is none that is known."""
    rows = gauge.rows
    # Pieper 1968: three axes that meet in a point part position from orientation
    if gauge.spherical(3):
        base = _base(gauge)
        if base is None:
            return None
        kind = ArmClass.SPHERICAL_SHOULDER if reverse else ArmClass.SPHERICAL_WRIST
        words = f"{kind.value}, {_BASES[base]}"
        if reverse:
            words += " (seen from the tool)"
        return Structure(kind, words, pack(gauge, 0, base, reverse=reverse), gauge)
    three = gauge.parallel(1) and gauge.parallel(2) and not gauge.parallel(0)
    if three and gauge.meeting(4) and not gauge.parallel(3) and min(abs(rows[1:3, 0])) > 0.0:
        kind = ArmClass.THREE_PARALLEL
        words = kind.value + (" (seen from the tool)" if reverse else "")
        return Structure(kind, words, pack(gauge, 1, 0, reverse=reverse), gauge)
    return None


def _general(gauge: Gauge) -> Structure:
    """Give six turning joints as module general_six_kernel takes them, but for the ways."""
    packed = np.zeros((_ROWS + 1, 6))
    packed[:_ROWS] = pack(gauge, 2)
    # any fixed turns that are no round figures will do
    packed[_ROWS] = np.random.default_rng(6).uniform(-np.pi, np.pi, 6)
    return Structure(ArmClass.GENERAL, ArmClass.GENERAL.value, packed, gauge)


def _base(gauge: Gauge) -> int | None:
    """Give the kind of the first three joints of a spherical wrist, as module wrist_kernel has."""
    (a0, _, _, sa0), (a1, _, _, sa1) = gauge.rows[:2]
    moved = gauge.rows[3, 0] != 0.0 or gauge.rows[4, 1] != 0.0
    on_axis = gauge.rows[2, 0] == 0.0 and 0.0 in (gauge.rows[2, 3], gauge.rows[3, 1])
    if (on_axis and not moved) or (sa0 == 0.0 and sa1 == 0.0):
        return None  # the third joint does not move the wrist's centre, or nothing lifts it
    if sa1 == 0.0:
        return 0 if a1 != 0.0 else None
    if sa0 == 0.0:
        return 3 if a0 != 0.0 else None
    if a0 == 0.0:
        return 1
    return 2 if a1 == 0.0 else 4


def pack(gauge: Gauge, kind: int = 0, base: int = 0, *, reverse: bool = False) -> FloatArray:
    """Give an arm in its simplest frames as the kernels take it, shape (n + 7, 6)."""
    n = len(gauge.offset)
    packed = np.zeros((n + 7, 6))
    packed[:n, :4] = gauge.rows
    packed[:n, 4] = gauge.offset
    packed[:n, 5] = -gauge.sign if reverse else gauge.sign
    packed[n : n + 3, :4] = np.linalg.inv(gauge.first)[:3]
    packed[n + 3 : n + 6, :4] = np.linalg.inv(gauge.last)[:3]
    size = 1.0 + float(np.abs(gauge.rows[:, :2]).sum())
    packed[n + 6, :4] = kind, base, float(reverse), _TOLERANCE * size
    return packed


def _all_parallel(chain: Chain) -> bool:
    """Say whether all joints act along parallel axes, two or three of them turning."""
    tilted = np.hypot(chain.fixed[1:-1, 0, 2], chain.fixed[1:-1, 1, 2]) > gauges.ZERO
    return bool(not tilted.any() and 2 <= chain.turns.sum() <= 3 and chain.slides.sum() <= 1)
