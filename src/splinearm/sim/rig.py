"""Servos and what they turn, brought up to the present when someone looks."""

from collections.abc import Sequence

from .fault import FaultyServo
from .motor import nominal_voltage
from .shaft import TIMESTEP, Plant
from .supply import Supply

QUIET_SPEED = 1e-3
"""Speed below which nothing counts as moving, rad/s."""

QUIET_TIME = 0.3
"""How long nothing must move before the rig stands still, s."""

QUIET_DUTY = 0.02
"""By how much duties may change meanwhile: some ticks of an encoder on the edge between two."""

_OFF = 2.0
_ROUNDING = 1e-9


class Rig:
    """Servos and plants in one time, stepped by the millisecond.

    Once nothing has moved for a while it stands still: time goes by without steps until a servo is
    told something that may move it. An arm at rest then costs nothing.
    """

    def __init__(
        self, servos: Sequence[FaultyServo], plants: Sequence[Plant], *, held: bool = False
    ) -> None:
        """Take servos and plants.

        Args:
            servos: The servos.
            plants: What they turn.
            held: Whether a hand holds everything where it is until a servo's torque comes on.
        """
        self._servos = tuple(servos)
        self._plants = tuple(plants)
        self._steps = 0
        self._offset = 0.0
        self._drive: list[float] = []
        self._quiet_steps = 0
        self._held = held
        voltages = dict.fromkeys(nominal_voltage(servo.model) for servo in servos)
        self.supplies = tuple(Supply(voltage) for voltage in voltages)
        """The supplies, one for the servos of each nominal voltage."""
        for supply, voltage in zip(self.supplies, voltages, strict=True):
            supply.connect([s for s in servos if nominal_voltage(s.model) == voltage])

    @property
    def now(self) -> float:
        """The time up to which the rig has come, s."""
        return self._offset + self._steps * TIMESTEP

    @property
    def asleep(self) -> bool:
        """Whether the rig stands still."""
        return self._held or self._quiet_steps * TIMESTEP >= QUIET_TIME

    def wake(self) -> None:
        """Something may move from here on."""
        self._quiet_steps = 0

    def skip_to(self, t: float) -> None:
        """Let time go by without steps until ``t``, s; never back."""
        self._offset += max(t - self.now, 0.0)

    def brown_out(self, off_for: float = 0.0) -> None:
        """Let every servo lose its power and get it back after a time, s."""
        for supply in self.supplies:
            supply.brown_out(off_for)

    def advance_to(self, t: float) -> None:
        """Let the time be ``t``, s, to the millisecond before it."""
        self._held = self._held and not any(servo.torque_on for servo in self._servos)
        if any(servo.stirred for servo in self._servos):
            self.wake()
            for servo in self._servos:
                servo.stirred = False
        if self.asleep:
            self._pass_to(t)
        while not self.asleep and self.now + TIMESTEP <= t + _ROUNDING:
            self._step()
        if self.asleep:
            self._pass_to(t)

    def _step(self) -> None:
        self._steps += 1
        now = self.now
        for servo in self._servos:
            servo.tick(now)
        for plant in self._plants:
            plant.step()
        for supply in self.supplies:
            if supply.resistance > 0.0:
                supply.step()
        if self._is_quiet():
            self._quiet_steps += 1
        else:
            self._quiet_steps = 0
            self._drive = []

    def _is_quiet(self) -> bool:
        """Tell whether nothing moves, and no servo has done anything new since all was quiet."""
        return (
            all(plant.speed < QUIET_SPEED for plant in self._plants)
            and not any(servo.torque_on and servo.law.busy for servo in self._servos)
            and self._drives_on()
        )

    def _drives_on(self) -> bool:
        """Tell whether each servo still does to its shaft what it did when all became quiet."""
        if not self._drive:
            self._drive = self._driven()
        return all(
            abs(before - now) <= QUIET_DUTY
            for before, now in zip(self._drive, self._driven(), strict=True)
        )

    def _driven(self) -> list[float]:
        """Give what each servo does to its shaft: its duty, or a number that no duty is."""
        return [servo.duty if servo.torque_on else _OFF for servo in self._servos]

    def _pass_to(self, t: float) -> None:
        """Let time go by without steps, unless a servo trips or was switched meanwhile."""
        self.skip_to(t)
        tripped = [servo.tripped for servo in self._servos]
        for servo in self._servos:
            servo.watch(self.now)
        if tripped != [servo.tripped for servo in self._servos] or not self._drives_on():
            self.wake()
