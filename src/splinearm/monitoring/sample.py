"""What a look at an arm gives: one sample of all its servos."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from math import nan

from splinearm.joints import JointKind

from .beat import Rhythm


class Level(IntEnum):
    """How something fares; what is worse is more."""

    WELL = 0
    """As it should."""
    WARN = 1
    """Worth a word."""
    STOP = 2
    """An arm would stop for it."""

    @property
    def word(self) -> str:
        """Its name for files."""
        return self.name.lower()


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """What is to be said of a servo."""

    level: Level = Level.WELL
    """How it fares as a whole."""
    code: str = ""
    """The doctor's code of what is worst; empty: it has none, or all is well."""
    what: str = ""
    """What is wrong, in a few words."""
    remedy: str = ""
    """What mends it."""
    fields: Mapping[str, Level] = field(default_factory=dict)
    """How single quantities fare that are not well, by their names in ``ServoSample``."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ServoSample:
    """How one servo fares, in SI; NaN, or None, where nothing is known."""

    servo_id: int
    """Its id."""
    name: str
    """What the arm's file calls it, or "servo_7"."""
    joint: str | None
    """The joint it moves; None: a gripper, or there is no file."""
    model: str
    """Its model; empty: it has not answered yet."""
    kind: JointKind = JointKind.REVOLUTE
    """Whether its position is an angle or a length."""
    answers: bool = False
    """Whether it answers now; else the quantities are those of before."""
    position: float = nan
    """Position, rad or m; without a file from the middle of its travel."""
    velocity: float = nan
    """Velocity, rad/s or m/s."""
    current: float = nan
    """Current, A."""
    mean_current: float = nan
    """Magnitude of its current over half a second, A: what its limits are for."""
    load: float = nan
    """Load, as a share of its torque, of servos that measure no current."""
    temperature: float = nan
    """Temperature inside, degC."""
    voltage: float = nan
    """Supply, V."""
    errors: tuple[str, ...] = ()
    """Hardware errors that it has latched, by name."""
    torque: bool | None = None
    """Whether it has torque."""
    moving: bool | None = None
    """Whether it says that it moves."""
    reads: int = 0
    """How often its motion was asked for."""
    lost: int = 0
    """How often nothing came from it."""
    damaged: int = 0
    """How often what came had a wrong CRC."""
    retries: int = 0
    """How often a single question had to be asked again."""
    verdict: Verdict = field(default_factory=Verdict)
    """What is to be said of it."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Sample:
    """How an arm fares at one moment."""

    t: float
    """When, s since 1970, as clocks of walls and programs have it."""
    number: int
    """Number of the sample, from 1."""
    port: str
    """The port."""
    baud: int
    """Bits per second."""
    arm: str | None
    """Name of the arm; None: whoever answered is looked at."""
    trouble: str
    """Why the port cannot be used now, in words; empty: it can."""
    rhythm: Rhythm
    """How often samples are taken, and how evenly."""
    servos: tuple[ServoSample, ...]
    """Its servos."""

    @property
    def level(self) -> Level:
        """How the worst of it fares."""
        worst = max((servo.verdict.level for servo in self.servos), default=Level.WELL)
        return Level.STOP if self.trouble else worst
