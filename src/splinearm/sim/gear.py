"""Play between a motor and its horn.

The encoder of an X servo sits on the horn, so play is not in what it measures but in what the motor
can do: while it runs through the gap it moves nothing.
"""


class Gear:
    """A gear with play; its state is how far the motor is through the gap."""

    def __init__(self, play: float, no_load_speed: float) -> None:
        """Take the play, rad, and the no-load speed of the motor, rad/s."""
        self.play = play
        """By how much the horn can be turned with the motor held, rad."""
        self._no_load = no_load_speed
        self._through = play / 2.0

    def pass_on(self, duty: float, speed: float, duration: float) -> float | None:
        """Give the duty that reaches the shaft in a time, s; None: the teeth do not touch.

        In the gap the motor is taken to have the speed that its duty gives it without load.

        Args:
            duty: What the motor is given, -1..1.
            speed: Of the shaft, rad/s.
            duration: How long, s.
        """
        relative = duty * self._no_load - speed
        self._through = min(max(self._through + relative * duration, 0.0), self.play)
        if relative > 0.0:
            return duty if self._through >= self.play else None
        return duty if self._through <= 0.0 else None
