"""Which servos hang on the bus, which joint each moves, and how each must be set."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from types import MappingProxyType

from .grip import Grip
from .health_limit import HealthLimits
from .model import ServoModel, servo_model

MAX_SERVO_ID = 252
"""Highest id of a servo."""


_DRIVERS_OWN = frozenset(
    {"ID", "Status Return Level", "Bus Watchdog", "Torque Enable", "Goal Position"}
)


class ServoRole(Enum):
    """What a servo does in the arm."""

    LEADER = "leader"
    """It moves a joint and says where the joint is."""

    SHADOW = "shadow"
    """It helps a leader at the same joint."""

    GRIPPER = "gripper"
    """It opens and closes the gripper; it belongs to no joint."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ServoSpec:
    """One servo, as the arm's file says it is."""

    name: str
    """What people call it."""
    servo_id: int
    """Its id on the bus, 0..252."""
    model: str
    """Its model, as in "XM430-W350"."""
    role: ServoRole
    """What it does."""
    joint: str | None = None
    """The joint it moves; None for a gripper."""
    zero_ticks: int | None = None
    """Position register at joint zero, in ticks; None: must be calibrated first."""
    settings: Mapping[str, int] = field(default_factory=dict)
    """Raw values that registers must have, by register name, as in {"Drive Mode": 1}."""
    health: HealthLimits = field(default_factory=HealthLimits)
    """How hot, how weakly fed and how hard at work it may be."""
    grip: Grip | None = None
    """How it opens and closes; None for a servo that moves a joint."""

    def __post_init__(self) -> None:
        if not 0 <= self.servo_id <= MAX_SERVO_ID:
            raise ValueError(
                f"servo {self.name!r}: want an id in 0..{MAX_SERVO_ID}, got {self.servo_id}"
            )
        table = servo_model(self.model).table
        for register, value in self.settings.items():
            if register not in table:
                raise ValueError(f"servo {self.name!r}: {self.model} has no register {register!r}")
            if not table[register].writable:
                raise ValueError(f"servo {self.name!r}: {register} can only be read")
            if register in _DRIVERS_OWN:
                raise ValueError(f"servo {self.name!r}: {register} is for the driver to write")
            table[register].encode(value)
        if (self.joint is None) is not (self.role is ServoRole.GRIPPER):
            wanted = "no joint" if self.role is ServoRole.GRIPPER else "the joint it moves"
            raise ValueError(
                f"servo {self.name!r}: want {wanted} for a {self.role.value}, got {self.joint!r}"
            )
        if self.grip is not None and self.role is not ServoRole.GRIPPER:
            raise ValueError(f"servo {self.name!r}: want no grip for a {self.role.value}")
        if self.grip is None and self.role is ServoRole.GRIPPER:
            object.__setattr__(self, "grip", Grip())
        object.__setattr__(self, "settings", MappingProxyType(dict(self.settings)))

    @property
    def servo_model(self) -> ServoModel:
        """Its model with all its figures."""
        return servo_model(self.model)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ServoChain:
    """The servos of one arm and the bus they hang on."""

    servos: tuple[ServoSpec, ...]
    """Every servo; ids and names differ, and each joint has exactly one leader."""
    baud: int = 1_000_000
    """Bits per second on the wire."""
    protocol: float = 2.0
    """Protocol of the servos that can speak both, 1.0 or 2.0; others speak the one they know."""
    usual_port: str | None = None
    """The port where the arm is usually found."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "servos", tuple(self.servos))
        if self.baud <= 0:
            raise ValueError(f"baud: want a rate above zero, got {self.baud}")
        if self.protocol not in (1.0, 2.0):
            raise ValueError(f"protocol: want 1.0 or 2.0, got {self.protocol}")
        _refuse_twins("id", [servo.servo_id for servo in self.servos])
        _refuse_twins("name", [servo.name for servo in self.servos])
        leaders = [servo.joint for servo in self.servos if servo.role is ServoRole.LEADER]
        _refuse_twins("joint of a leader", leaders)
        for servo in self.servos:
            if servo.role is ServoRole.SHADOW and servo.joint not in leaders:
                raise ValueError(f"servo {servo.name!r}: joint {servo.joint!r} has no leader")

    def servo(self, name: str) -> ServoSpec:
        """Give the servo of that name.

        Raises:
            ValueError: If there is none, with those there are.
        """
        for servo in self.servos:
            if servo.name == name:
                return servo
        names = ", ".join(servo.name for servo in self.servos)
        raise ValueError(f"no servo {name!r}; there are {names}")

    def leaders_of(self, joint_names: Iterable[str]) -> tuple[ServoSpec, ...]:
        """Give the leader of each joint, in the order of the joints.

        Raises:
            ValueError: If a joint has none.
        """
        by_joint = {s.joint: s for s in self.servos if s.role is ServoRole.LEADER}
        names = tuple(joint_names)
        for name in names:
            if name not in by_joint:
                joints = ", ".join(str(joint) for joint in by_joint)
                raise ValueError(f"no servo moves joint {name!r}; there are servos for {joints}")
        return tuple(by_joint[name] for name in names)

    def shadows_of(self, joint_names: Iterable[str]) -> tuple[ServoSpec, ...]:
        """Give the shadows at those joints, in the order of the chain."""
        names = set(joint_names)
        return tuple(s for s in self.servos if s.role is ServoRole.SHADOW and s.joint in names)

    @property
    def gripper(self) -> ServoSpec | None:
        """The gripper's servo, the first if there are several; None without one."""
        return next((s for s in self.servos if s.role is ServoRole.GRIPPER), None)


def _refuse_twins(what: str, values: Iterable[object]) -> None:
    """Refuse the first value that comes twice."""
    seen: set[object] = set()
    for value in values:
        if value in seen:
            raise ValueError(f"servos: two have the {what} {value!r}")
        seen.add(value)
