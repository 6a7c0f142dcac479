"""How a servo comes to rest as hard as it can, without knowing what hangs on it.

Quantities are shares: of the stall torque at the nominal supply, of the no-load speed. A motor then
obeys ``T dw/dt = (u - w) - L`` with its output ``u``, speed ``w``, load ``L`` and a time constant
``T`` that depends on what it moves. Braking begins with a step of the output, which tells ``T``;
from then on the load is observed and carried.
"""

from .motor import MOTOR_TIME_CONSTANT

BRAKE_GAIN = 30.0
"""Output to speed while braking: the unloaded motor comes to rest with a time constant of 2 ms."""

GAIN_BY_SLEW = 300.0
"""The same to the slew of the output a millisecond, where that is limited: else it would ring."""

REST_SPEED = 0.004
"""Speed below which a servo counts as at rest."""

WEIGHING = 6
"""For how long the answer to the step is watched, milliseconds."""

OBSERVING = 0.1
"""Share of what is new about the load that is believed each millisecond."""

_LEAST = MOTOR_TIME_CONSTANT * 1e3  # milliseconds: the motor alone
_MOST = 20.0 * _LEAST
_LONGEST = 500  # milliseconds
_SETTLED = 0.02


class Brake:
    """One braking; a millisecond a call of ``tick``."""

    def __init__(self, torque: float, change: float, slew: float) -> None:
        """Begin.

        Args:
            torque: What the motor gave in the millisecond before, ``u - w``.
            change: By how much its speed changed meanwhile.
            slew: Most by which the output can change in a millisecond.
        """
        self.carried = 0.0
        """Output that carries the load."""
        self.done = False
        """Whether it is at rest."""
        self._gain = min(BRAKE_GAIN, GAIN_BY_SLEW * slew)
        self._ticks = 0
        self._torque = torque
        self._change = change
        self._began = 0.0
        self._speed = 0.0
        self._given = 0.0
        self._time_constant = _LEAST

    def tick(self, speed: float, given: float, limit: float) -> float:
        """Give the output at a speed, within a limit; ``given`` is what was given before."""
        if self._ticks == 0:
            self._began = speed
        elif self._ticks <= WEIGHING:
            self._given += given - self._speed
            if self._ticks == WEIGHING:
                self._weigh(self._given / WEIGHING, (speed - self._began) / WEIGHING)
        else:
            self._observe(given - self._speed, speed - self._speed, speed)
        self._ticks += 1
        self._speed = speed
        return min(max(self.carried + (1.0 - self._gain) * speed, -limit), limit)

    def _weigh(self, torque: float, change: float) -> None:
        """Find time constant and load from what moved the motor how much, before and now."""
        differs = change - self._change
        time_constant = (torque - self._torque) / differs if differs else _LEAST
        self._time_constant = min(max(time_constant, _LEAST), _MOST)
        self._carry(torque - self._time_constant * change)

    def _observe(self, torque: float, change: float, speed: float) -> None:
        """Correct the load by the newest millisecond."""
        new = torque - self._time_constant * change - self.carried
        self._carry(self.carried + OBSERVING * new)
        at_rest = abs(speed) < REST_SPEED and abs(new) < _SETTLED
        self.done = at_rest or self._ticks > _LONGEST

    def _carry(self, load: float) -> None:
        self.carried = min(max(load, -1.0), 1.0)
