"""What a robot description file (URDF, MJCF) says of an arm, and of what else moves on it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from os import PathLike, fspath
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import ConfigError
from splinearm.joints import JointKind, JointLimits

from . import body
from .arm import Arm
from .link import Inertia

DEFAULT_SPEED = {JointKind.REVOLUTE: 1.0, JointKind.PRISMATIC: 0.1}
"""Speed, rad/s or m/s, of a joint whose file gives none or zero."""

DEFAULT_RAMP = 0.5
"""In this time, s, a joint whose file gives no acceleration comes to its highest speed."""

ENDLESS = 1e300
"""A limit at or beyond this stands for none, as does its absence."""

_MAY_BE_ENDLESS = {
    "lower",
    "upper",
    "velocity",
    "effort",
    "acceleration",
    "jerk",
    "range",
    "actuatorfrcrange",
}


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class SideJoint:
    """A moving joint beside the arm's own: a finger, or a joint that mimics another."""

    name: str
    """Its name."""
    kind: JointKind
    """How it moves."""
    parent: str
    """The joint (of the arm or another side joint) whose link it sits on; empty: the base."""
    T_base_joint: FloatArray
    """Its pose in base where all joints are at zero, shape (4, 4); it acts on its z axis."""
    q_min: float
    """Lowest position, rad or m."""
    q_max: float
    """Highest position, rad or m."""
    mimics: str = ""
    """The joint it follows: q = multiplier * q_of_that + offset; empty: it is driven by itself."""
    multiplier: float = 1.0
    """How much it moves for each rad or m of the joint it follows."""
    offset: float = 0.0
    """Where it is when that joint is at zero, rad or m."""
    inertia: Inertia | None = None
    """What it carries, in base where all joints are at zero. The arm's links hold it as well."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Description:
    """A robot description file as an arm."""

    arm: Arm
    """The serial chain from base to tip."""
    base: str
    """Name of the link or body that is the base."""
    tip: str
    """Name of the link, body or site that is the tool."""
    side_joints: tuple[SideJoint, ...] = ()
    """What else moves; the arm carries their masses as they are at zero."""


@dataclass(slots=True, kw_only=True)
class JointNote:
    """What a file says of one joint's limits; what it does not say is None."""

    name: str
    kind: JointKind
    q_min: float = -inf
    q_max: float = inf
    qd_max: float | None = None
    qdd_max: float | None = None
    qddd_max: float | None = None
    torque_max: float | None = None


@dataclass(slots=True)
class Source:
    """An XML file or text, and the words to refuse what it says."""

    file: str
    root: ET.Element = field(default_factory=lambda: ET.Element("none"))

    @classmethod
    def read(cls, source: str | PathLike[str], root: str) -> "Source":
        """Read a file, or a text that begins with ``<``, whose root element is of this name.

        Raises:
            ConfigError: If it cannot be read, is no XML or has another root.
        """
        text = fspath(source)
        file = "text" if text.lstrip().startswith("<") else text
        try:
            content = text if file == "text" else Path(text).read_text(encoding="utf-8")
            element = ET.fromstring(content)  # noqa: S314 - a file of the user's own; no entities
        except OSError as error:
            raise ConfigError(file, "", f"cannot be read: {error.strerror}") from error
        except UnicodeDecodeError as error:
            raise ConfigError(file, "", f"is no UTF-8 text: {error.reason}") from error
        except ET.ParseError as error:
            raise ConfigError(file, "", f"is no XML: {error}") from error
        if element.tag != root:
            reason = f"its root is <{element.tag}>, not <{root}>"
            if any("xacro" in name for name in (content[:2000], element.tag)):
                reason += "; it is a xacro file: run xacro on it first"
            raise ConfigError(file, element.tag, reason)
        return cls(file, element)

    def refuse(self, where: str, reason: str) -> ConfigError:
        """Give the error that names the file and the element."""
        return ConfigError(self.file, where, reason)

    def numbers(
        self, element: Mapping[str, str], key: str, sizes: Sequence[int], where: str
    ) -> FloatArray:
        """Give the numbers of an attribute, as many as one of ``sizes`` says.

        Raises:
            ConfigError: If it is missing or holds something else.
        """
        text = element.get(key)
        if text is None:
            raise self.refuse(where, f"{key} is missing")
        try:
            values = np.array([float(word) for word in text.split()])
        except ValueError as error:
            raise self.refuse(where, f"{key}: want numbers, got {text!r}") from error
        if values.size not in sizes:
            wanted = " or ".join(str(size) for size in sizes)
            raise self.refuse(where, f"{key}: want {wanted} numbers, got {text!r}")
        # only limits may be without end
        if np.isnan(values).any() or (key not in _MAY_BE_ENDLESS and np.isinf(values).any()):
            raise self.refuse(where, f"{key}: want finite numbers, got {text!r}")
        return values

    def number(
        self, element: Mapping[str, str], key: str, where: str, default: float | None = None
    ) -> float:
        """Give the number of an attribute, or a default if it is not there."""
        if default is not None and key not in element:
            return default
        return float(self.numbers(element, key, (1,), where)[0])

    def positive(self, element: Mapping[str, str], key: str, where: str) -> float | None:
        """Give a number above zero; None where it is missing, zero or without end."""
        value = self.number(element, key, where, 0.0)
        if value < 0.0:
            raise self.refuse(where, f"{key}: want a number above zero, got {value:g}")
        return value if 0.0 < value < ENDLESS else None


def limits_of(source: Source, notes: Sequence[JointNote]) -> JointLimits:
    """Give the limits that a file says, with the defaults of this module where it does not.

    Jerk and torque are known if they are for every joint.

    Raises:
        ConfigError: If a joint has no room to move.
    """
    for i, note in enumerate(notes):
        if note.name in [other.name for other in notes[:i]]:
            raise source.refuse(f"joint {note.name!r}", "is there twice")
        if note.q_min >= note.q_max:
            raise source.refuse(
                f"joint {note.name!r}",
                f"its lowest position {note.q_min:g} is not below its highest {note.q_max:g}",
            )
    speeds = [note.qd_max or DEFAULT_SPEED[note.kind] for note in notes]
    ramps = [
        note.qdd_max or speed / DEFAULT_RAMP for note, speed in zip(notes, speeds, strict=True)
    ]
    return JointLimits(
        names=tuple(note.name for note in notes),
        kinds=tuple(note.kind for note in notes),
        q_min=np.array([note.q_min for note in notes]),
        q_max=np.array([note.q_max for note in notes]),
        qd_max=np.array(speeds),
        qdd_max=np.array(ramps),
        qddd_max=_all_or_none([note.qddd_max for note in notes]),
        torque_max=_all_or_none([note.torque_max for note in notes]),
    )


def text_of(values: object) -> str:
    """Give numbers as text that loses nothing."""
    array = np.atleast_1d(np.asarray(values, dtype=np.float64)).ravel()
    return " ".join(repr(float(value) + 0.0) for value in array)


def free_name(wanted: str, taken: set[str]) -> str:
    """Give a name that is not taken yet, and take it."""
    while wanted in taken:
        wanted += "_"
    taken.add(wanted)
    return wanted


def take_off(
    inertias: dict[str, Inertia | None], own: Sequence[str], sides: Sequence[SideJoint]
) -> None:
    """Take what side joints carry off the links of the arm, which hold it as well.

    Args:
        inertias: Of the links by their joints' names, in base; changed here.
        own: Names of the arm's joints.
        sides: The side joints, each after the one it sits on.
    """
    carrier = {name: name for name in own}
    for side in sides:
        carrier[side.name] = carrier.get(side.parent, "")
        whole = inertias.get(carrier[side.name])
        if side.inertia is not None and whole is not None:
            inertias[carrier[side.name]] = body.without(whole, side.inertia)


def _all_or_none(values: Sequence[float | None]) -> FloatArray | None:
    known = [value for value in values if value is not None]
    return np.array(known) if known and len(known) == len(values) else None
