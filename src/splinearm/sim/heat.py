"""How warm a servo gets, and when its load has lasted too long."""

from dataclasses import dataclass
from math import expm1

AMBIENT = 30.0
"""Temperature of a servo that does nothing, degC."""

RISE_AT_STALL = 400.0
"""By how much a servo would be warmer in the end if it were held at full output, K. An estimate: at
a fifth of its stall torque, the load for which the maker promises stable motion, it makes 16 K; at
a third, 44 K and with that the temperature limits of the small servos."""

TIME_CONSTANT = 600.0
"""In which time it comes to 63 % of that, s. An estimate: such servos take ten minutes and more to
get warm, and the manual lets overheated ones cool for 20 minutes."""


@dataclass(slots=True, kw_only=True)
class Heat:
    """One heat capacity, warmed by the square of the current, cooled in proportion."""

    ambient: float = AMBIENT
    """Temperature without load, degC."""
    rise_at_stall: float = RISE_AT_STALL
    """Final rise at the stall current, K."""
    time_constant: float = TIME_CONSTANT
    """Time constant, s."""
    pace: float = 1.0
    """By how much faster than in the world temperatures change: for tests in a hurry."""

    def after(self, temperature: float, load: float, duration: float) -> float:
        """Give the temperature after a time at a load, degC.

        Args:
            temperature: Before, degC.
            load: Current as a share of the stall current.
            duration: How long, s.
        """
        final = self.ambient + self.rise_at_stall * load * load
        return temperature + (temperature - final) * expm1(
            -duration * self.pace / self.time_constant
        )
