"""How the angle of a shaft becomes the position that a servo reads."""

from math import floor


class Horn:
    """A servo's encoder, the way the servo is mounted, and its count of turns.

    The encoder knows the angle within one turn; turns are counted while the power is on. Drive Mode
    may reverse the direction, Homing Offset is added last.
    """

    def __init__(self, per_rad: float, pulses: int, *, reverse: bool, at_zero: float) -> None:
        """Mount a servo so that its position grows with the joint and is right at joint zero.

        Args:
            per_rad: Ticks a radian.
            pulses: Ticks a turn.
            reverse: Whether its Drive Mode reverses it as it is mounted.
            at_zero: Its position at joint zero less its homing offset, ticks.
        """
        self._per_rad = per_rad
        self._pulses = pulses
        self._mount = -1 if reverse else 1
        self._at_zero = self._mount * at_zero
        self.direction = 1
        """1 if the position grows with the joint, -1 if it falls."""
        self._shift = 0.0
        self._homing = 0
        self._turns = 0

    def set_up(self, *, reverse: bool, homing: int) -> None:
        """Take what the registers say."""
        sign = -1 if reverse else 1
        self.direction = sign * self._mount
        self._shift = sign * self._at_zero
        self._homing = homing

    def fold(self, angle: float) -> None:
        """Forget whole turns: the position at ``angle`` (rad) lies within one from here on."""
        self._turns = floor(round(self._raw(angle)) / self._pulses)

    def position(self, angle: float) -> int:
        """Give the position at an angle of the shaft, ticks."""
        return round(self._raw(angle)) - self._turns * self._pulses + self._homing

    def speed(self, speed: float) -> float:
        """Give the speed of the position at a speed of the shaft (rad/s), ticks/s."""
        return self.direction * self._per_rad * speed

    def _raw(self, angle: float) -> float:
        return self.direction * self._per_rad * angle + self._shift
