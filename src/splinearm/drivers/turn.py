"""Which turn a servo counts in."""

from math import ceil, floor, isinf, pi

from splinearm.errors import ServoError
from splinearm.units import DEG

from .chain import ServoSpec
from .scaling import ONE_TURN_MODE, operating_mode

_OUTSIDE = 10.0 * DEG
"""How far outside its limits a joint may stand and still be believed to be in that turn, rad."""

_SEAM = 2.0 * DEG
"""By how much less a joint must stand outside its limits in one turn than in the next for that one
to be believed, rad. Where limits of a whole turn meet, an arm that hangs a little may be at either
end of its travel."""

_HOMING_IN_ONE_TURN = 1024
"""In position mode a servo takes no notice of a Homing Offset beyond that."""

_TURN = 2.0 * pi


def fold(servo: ServoSpec, ticks: int) -> int:
    """Give what Present Position will be once the torque is on.

    A servo turned by hand in position mode counts on beyond its turn, and folds back into one turn
    when its torque comes on (ROBOTIS e-Manual, "Present Position"); a goal read before would be off
    by that turn. In the other modes it stays as it is.
    """
    if operating_mode(servo) != ONE_TURN_MODE:
        return ticks
    model = servo.servo_model
    homing = servo.settings.get("Homing Offset", 0)
    if abs(homing) > _HOMING_IN_ONE_TURN:
        homing = 0
    low = model.centre - model.pulses // 2 + homing
    return low + (ticks - low) % model.pulses


def unwrapped_zero(
    servo: ServoSpec,
    zero: int,
    ticks: int,
    q_min: float,
    q_max: float,
    *,
    near: float | None = None,
) -> int:
    """Give the position register at joint zero, in the turn that the servo counts in now.

    In the modes of many turns a servo forgets its turns with the power: what it reads may be off by
    whole turns. The joint's limits say which turn it is, or who knows about where it stands.

    Args:
        servo: The servo.
        zero: Its zero_ticks.
        ticks: What Present Position is, folded.
        q_min: Lowest position of the joint, rad.
        q_max: Highest position of the joint, rad.
        near: Where the joint is known to be, to less than half a turn, rad; None: it is not known.

    Raises:
        ServoError: If more than one turn may be meant, or the joint is far outside of its limits.
    """
    if operating_mode(servo) == ONE_TURN_MODE or (near is None and isinf(q_min) and isinf(q_max)):
        return zero
    per_rad = servo.servo_model.pulses_per_rad
    q = (ticks - zero) / per_rad
    if near is not None:
        k = round((q - near) / _TURN)
    elif isinf(q_min) or isinf(q_max):
        raise _ambiguous(servo, [q, q + _TURN if isinf(q_max) else q - _TURN])
    else:
        k = _turn_within(servo, q, q_min, q_max)
    beyond = _beyond(q - k * _TURN, q_min, q_max)
    if beyond > _OUTSIDE:
        raise ServoError(
            servo.servo_id,
            f"joint {servo.joint!r} stands {beyond / DEG:.1f} deg outside its limits, so its turn "
            "cannot be told; move it within them by hand, with the torque off",
            name=servo.name,
        )
    return zero + k * round(per_rad * _TURN)


def _turn_within(servo: ServoSpec, q: float, q_min: float, q_max: float) -> int:
    """Give the turn in which a joint is within its limits, or nearest to them; only if sure."""
    first, last = ceil((q - q_max) / _TURN), floor((q - q_min) / _TURN)
    # those within the limits and the ones next to them, the best first
    turns = sorted(range(min(first, last) - 1, max(first, last) + 2), key=lambda k: (
        _beyond(q - k * _TURN, q_min, q_max), abs(k)
    ))  # fmt: skip
    best = _beyond(q - turns[0] * _TURN, q_min, q_max)
    rivals = [k for k in turns if _beyond(q - k * _TURN, q_min, q_max) <= best + _SEAM]
    if len(rivals) > 1 and best <= _OUTSIDE:
        raise _ambiguous(servo, [q - k * _TURN for k in rivals])
    return turns[0]


def _beyond(q: float, q_min: float, q_max: float) -> float:
    """Give how far outside its limits a joint stands, rad; 0 within them."""
    return max(q_min - q, q - q_max, 0.0)


def _ambiguous(servo: ServoSpec, places: list[float]) -> ServoError:
    """Make the error of a joint that may be in more than one turn."""
    text = " or ".join(f"{q / DEG:.1f}" for q in sorted(places)[:3])
    return ServoError(
        servo.servo_id,
        f"which turn joint {servo.joint!r} is in cannot be told: it may be at {text} deg; say "
        "about where it stands, move it away from the ends of its travel by hand, or narrow its "
        "limits to less than one turn",
        name=servo.name,
    )
