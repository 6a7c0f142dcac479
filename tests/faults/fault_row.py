"""What a row of the table of faults says, and what can be done to a scene."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any

from fault_time import OTHER_PORT

from splinearm.sim.choice import TripStop

Deed = Callable[[Any], object]
"""Something done to a scene."""


class Outcome(Enum):
    """What the arm does."""

    GOES_ON = "goes on"
    STOPS = "stops along the path"
    HALTS = "is stopped by its servos"
    REFUSES = "refused before anything moves"


@dataclass(frozen=True, kw_only=True)
class Fault:
    """One row."""

    name: str
    """What it is called."""
    strike: Deed
    """What goes wrong."""
    outcome: Outcome
    """What the arm does."""
    more: str = ""
    """What else the arm does, in words."""
    says: str = ""
    """Words that must be said."""
    remedy: str = "nothing"
    """What the person does, in words."""
    mend: tuple[Deed, ...] = ()
    """The same, done."""
    early: bool = False
    """Whether it is so from before the arm is entered."""
    arm: str = "planar_2r"
    """The arm."""
    options: dict[str, Any] = field(default_factory=dict)
    """How its scene is made."""
    limp: tuple[int, ...] = ()
    """Ids of servos that lose their torque without being asked to by us."""
    astray: tuple[int, ...] = ()
    """Ids of servos that cannot be kept on the path."""
    wild: tuple[int, ...] = ()
    """Ids of servos that cannot keep their joint within its limits."""
    rate: float = 100.0
    """At which rate setpoints go out, Hz."""
    dead: int | None = None
    """Id of the one servo that is not heard, and is to be named while the others are served."""
    off: float = 0.0
    """By how much joints are off in the end besides, rad: what nobody can see from the servos."""
    loose: float = 0.0
    """By how much the joints themselves may leave the path besides, rad."""
    settles: float = 0.06
    """How long servos take to rest after the last word, s."""
    tool_loose: float = 0.0
    """The same of the tool, m."""


def servo(number: int, deed: Deed) -> Deed:
    """Do something to one servo."""
    return lambda scene: deed(scene.servo(number))


def have(**knobs: Any) -> Deed:
    """Set knobs of a servo."""

    def turn(one: Any) -> None:
        for name, value in knobs.items():
            setattr(one, name, value)

    return turn


def write(**registers: int) -> Deed:
    """Set registers of a servo, as another program would."""

    def put(one: Any) -> None:
        for name, value in registers.items():
            one.memory[name.replace("_", " ")] = value

    return put


def line(kind: str, **how: Any) -> Deed:
    """Let something go wrong on the line."""
    return lambda scene: scene.line(kind, **how)


def wait(duration: float) -> Deed:
    """Let time go by."""
    return lambda scene: scene.wait(duration)


def pause(duration: float, trip: TripStop = TripStop.BRAKE) -> Deed:
    """Let the computer do something else."""

    def strike(scene: Any) -> None:
        for one in scene.virtual.all_servos:
            one.choices = replace(one.choices, on_trip=trip)
        scene.clock.pause = duration

    return strike


def unplug(scene: Any) -> None:
    scene.plug.name = None


def plug_in_elsewhere(scene: Any) -> None:
    scene.plug.name = OTHER_PORT


def cut_cable(scene: Any) -> None:
    scene.virtual.silent = True


def mend_cable(scene: Any) -> None:
    scene.virtual.silent = False


def calm(scene: Any) -> None:
    scene.calm()


def reconnect(scene: Any) -> None:
    scene.arm.reconnect()


def reconnect_elsewhere(scene: Any) -> None:
    scene.arm.reconnect(OTHER_PORT)


def recover(scene: Any) -> None:
    scene.arm.recover()


def set_up_again(number: int) -> Deed:
    """Give a servo the id, baud rate and EEPROM of the arm's file."""

    def put(scene: Any) -> None:
        one = scene.servo(number)
        spec = next(s for s in scene.chain.servos if s.servo_id == number)
        code = spec.servo_model.baud_code(scene.chain.baud)
        one.apply(
            [
                (one.memory.table[name], value)
                for name, value in {"ID": number, "Baud Rate": code, **spec.settings}.items()
            ]
        )

    return put


GOES_ON, STOPS, HALTS, REFUSES = Outcome
ASKED_FOR = "does not answer when asked for Present Position"
RECOVER = "remove the cause, support the arm, `recover()`, go on"
MEND_AND_RECONNECT = "mend it, `reconnect()`, go on"
