"""How an AX servo holds: no gains but a slack, a slope and a least output on either side.

Source: ROBOTIS e-Manual, AX-12A, "Compliance Margin", "Compliance Slope", "Punch", and the drawing
there: within the margin nothing, from there on Punch growing by the slope to the full output.
"""

from dataclasses import dataclass
from math import copysign


@dataclass(frozen=True, slots=True, kw_only=True)
class Compliance:
    """Margins and slopes in ticks; below: towards lower positions (CW), above: CCW."""

    margin_below: float
    margin_above: float
    slope_below: float
    slope_above: float
    punch: float
    """Least output, PWM units."""
    full: float
    """Full output, PWM units."""

    def pwm(self, error: float) -> float:
        """Give the output for an error (wanted less measured position), ticks."""
        if error > 0.0:
            beyond, slope = error - self.margin_above, self.slope_above
        else:
            beyond, slope = -error - self.margin_below, self.slope_below
        if beyond <= 0.0:
            return 0.0
        grown = self.punch + (self.full - self.punch) * beyond / slope
        return copysign(min(grown, self.full), error)


def representative_slope(value: int) -> int:
    """Give the slope that a register's value stands for: one of 2, 4, 8 .. 128 ticks."""
    return min(max(1 << max(value.bit_length() - 1, 0), 2), 128)
