"""How the angle of a shaft becomes the position that a servo reads."""

from math import floor, tau


class Horn:
    """A servo's encoder, the way the servo is mounted, and its count of turns.

    The encoder knows the angle within one turn; turns are counted while the power is on. Drive Mode
    may reverse the direction, Homing Offset is added last.
    """

    def __init__(
        self, per_rad: float, pulses: int, *, reverse: bool, at_zero: float, lowest: int = 0
    ) -> None:
        """Mount a servo so that its position grows with the joint and is right at joint zero.

        Args:
            per_rad: Ticks a radian.
            pulses: Ticks a turn.
            reverse: Whether its Drive Mode reverses it as it is mounted.
            at_zero: Its position at joint zero less its homing offset, ticks.
            lowest: The lowest position of its one turn, ticks.
        """
        self._per_rad = per_rad
        self._pulses = pulses
        self._lowest = lowest
        self._mount = -1 if reverse else 1
        self._at_zero = self._mount * at_zero
        self.direction = 1
        """1 if the position grows with the joint, -1 if it falls."""
        self._shift = 0.0
        self._homing = 0
        self._turns = 0
        self._frozen: float | None = None
        self._gain = per_rad
        self._at_rest = 0.0
        self._add = 0

    def set_up(self, *, reverse: bool, homing: int) -> None:
        """Take what the registers say."""
        sign = -1 if reverse else 1
        self.direction = sign * self._mount
        self._shift = sign * self._at_zero
        self._homing = homing
        self._reckon()

    def slip(self, angle: float) -> None:
        """Slip on the shaft: from here on it reads as if the joint were ``angle`` (rad) further."""
        change = self._mount * self._per_rad * angle
        self._at_zero += change
        self._shift += self.direction * self._mount * change
        self._reckon()

    def freeze(self, angle: float | None) -> None:
        """Let the encoder see this angle (rad) for ever, whatever the shaft does; None: no more."""
        self._frozen = angle
        self._reckon()

    def _reckon(self) -> None:
        """Find the numbers that a position is made of."""
        gain = self.direction * self._per_rad
        self._gain = gain if self._frozen is None else 0.0
        self._at_rest = self._shift + (0.0 if self._frozen is None else gain * self._frozen)
        self._add = self._homing - self._turns * self._pulses

    def fold(self, angle: float) -> None:
        """Forget whole turns: the position at ``angle`` (rad) lies within one from here on."""
        self._turns = floor((round(self._raw(angle)) - self._lowest) / self._pulses)
        self._add = self._homing - self._turns * self._pulses

    def position(self, angle: float) -> int:
        """Give the position at an angle of the shaft, ticks."""
        return round(self._gain * angle + self._at_rest) + self._add

    def speed(self, speed: float) -> float:
        """Give the speed of the position at a speed of the shaft (rad/s), ticks/s."""
        return self._gain * speed

    def _raw(self, angle: float) -> float:
        return self._gain * angle + self._at_rest


class Potentiometer(Horn):
    """The sensor of servos that see part of a turn only and count no turns: AX-12A and XL-320.

    In the gap, for which the manual says "invalid angle", it reads the nearer end.
    """

    def fold(self, angle: float) -> None:
        """Nothing is counted, so nothing is to be forgotten."""

    def position(self, angle: float) -> int:
        """Give the position at an angle of the shaft, ticks."""
        last = self._pulses - 1
        turn = self._per_rad * tau
        middle = last / 2.0
        # within half a turn of mid travel, then to the nearer end
        away = (self._raw(angle) - middle + turn / 2.0) % turn - turn / 2.0
        return min(max(round(middle + away), 0), last)
