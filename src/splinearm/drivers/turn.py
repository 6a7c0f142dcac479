"""Which turn a servo counts in."""

from math import ceil, floor, isinf, pi

from splinearm.errors import ServoError
from splinearm.units import DEG

from .chain import ServoSpec
from .scaling import ONE_TURN_MODE, operating_mode

_OUTSIDE = 10.0 * DEG
"""How far outside its limits a joint may stand and still be believed to be in that turn, rad."""


_SEAM = 2.0 * DEG
"""How far outside its limits a servo's own count still beats the same place a turn away, rad.

Where limits of a whole turn meet, an arm that hangs a little must not seem to be at the other end.
"""


def fold(servo: ServoSpec, ticks: int) -> int:
    """Give what Present Position will be once the torque is on.

    A servo turned by hand in position mode counts on beyond its turn, and folds back into one turn
    when its torque comes on (ROBOTIS e-Manual, "Present Position"); a goal read before would be off
    by that turn. In the other modes it stays as it is.
    """
    if operating_mode(servo) != ONE_TURN_MODE:
        return ticks
    model = servo.servo_model
    low = model.centre - model.pulses // 2 + servo.settings.get("Homing Offset", 0)
    return low + (ticks - low) % model.pulses


def unwrapped_zero(servo: ServoSpec, zero: int, ticks: int, q_min: float, q_max: float) -> int:
    """Give the position register at joint zero, in the turn that the servo counts in now.

    In the modes of many turns a servo forgets its turns with the power: what it reads may be off by
    whole turns. The joint's limits say which turn it is; the servo's own count, if they allow it.

    Args:
        servo: The servo.
        zero: Its zero_ticks.
        ticks: What Present Position is, folded.
        q_min: Lowest position of the joint, rad.
        q_max: Highest position of the joint, rad.

    Raises:
        ServoError: If the limits leave more than one turn, or the joint is far outside of them.
    """
    if operating_mode(servo) == ONE_TURN_MODE or (isinf(q_min) and isinf(q_max)):
        return zero
    model = servo.servo_model
    q = (ticks - zero) / model.pulses_per_rad
    turn = 2.0 * pi
    if isinf(q_min) or isinf(q_max):
        raise _ambiguous(servo, [q, q + turn if isinf(q_max) else q - turn])
    first, last = ceil((q - q_max) / turn), floor((q - q_min) / turn)
    if last > first and q_max - q_min > turn:
        raise _ambiguous(servo, [q - k * turn for k in range(first, last + 1)])
    if max(q_min - q, q - q_max) <= _SEAM:
        return zero
    # none within the limits: the turn that comes nearest to their middle
    k = first if first <= last else round((q - 0.5 * (q_min + q_max)) / turn)
    stands = q - k * turn
    beyond = max(q_min - stands, stands - q_max)
    if beyond > _OUTSIDE:
        raise ServoError(
            servo.servo_id,
            f"joint {servo.joint!r} stands {beyond / DEG:.1f} deg outside its limits, so its turn "
            "cannot be told; move it within them by hand, with the torque off",
            name=servo.name,
        )
    return zero + k * round(model.pulses_per_rad * turn)


def _ambiguous(servo: ServoSpec, places: list[float]) -> ServoError:
    """Make the error of a joint that may be in more than one turn."""
    text = " or ".join(f"{q / DEG:.1f}" for q in places[:3])
    return ServoError(
        servo.servo_id,
        f"which turn joint {servo.joint!r} is in cannot be told: it may be at {text} deg; "
        "narrow its limits to at most one turn",
        name=servo.name,
    )
