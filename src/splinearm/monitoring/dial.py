"""Where a joint stands by what the position register of its servo says, without asking for more."""

from contextlib import suppress
from dataclasses import dataclass, replace

from splinearm.drivers.chain import ServoSpec
from splinearm.drivers.model import ServoModel
from splinearm.drivers.turn import fold, unwrapped_zero
from splinearm.errors import ServoError
from splinearm.joints import JointKind


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Place:
    """What a servo is for."""

    servo: ServoSpec | None = None
    """What the arm's file says of it; None: there is no file."""
    zero: int | None = None
    """Position register at joint zero, ticks; None: it is not known."""
    range: tuple[float, float] | None = None
    """Lowest and highest position of its joint, rad or m."""
    kind: JointKind = JointKind.REVOLUTE
    """How its joint moves."""


class Dial:
    """Turns ticks into positions.

    Args:
        model: The model of the servo.
        place: What it is for.
        ticks: Where it stands now: it tells the turn that it counts in.
    """

    def __init__(self, model: ServoModel, place: Place, ticks: float) -> None:
        self._per_rad = model.pulses_per_rad
        servo = place.servo
        zero = model.centre if place.zero is None else place.zero
        self._servo = None if servo is None else replace(servo, model=model.name, settings={})
        if servo is not None and servo.servo_model is model:
            self._servo = servo
        if self._servo is not None and place.range is not None:
            # where its turn cannot be told it stays as it is: this is for looking, not for moving
            with suppress(ServoError, ValueError):
                zero = unwrapped_zero(self._servo, zero, self._folded(ticks), *place.range)
        self._zero = zero

    def position(self, ticks: float, *, torque: bool | None) -> float:
        """Give the position of the joint, rad or m.

        Args:
            ticks: What the position register says.
            torque: Whether the servo has torque: without it one of a single turn counts on beyond.
        """
        if torque is False:
            ticks = self._folded(ticks)
        return (ticks - self._zero) / self._per_rad

    def _folded(self, ticks: float) -> int:
        """Give the ticks within the turn that counts once the torque is on."""
        if self._servo is None:
            return int(ticks)
        try:
            return fold(self._servo, int(ticks))
        except ValueError:  # no position mode: it counts as it turns
            return int(ticks)
