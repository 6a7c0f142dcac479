"""Joints turned by hand: positions counted on across the ends of a turn, and how far they went."""

from statistics import median

from splinearm.drivers.model import ServoModel

_SURE = 0.75
"""From that share of a turn on, a step between two readings is a fold back into one turn: no hand
is so quick."""

_BINS = 256
"""Pairs are kept by where the leader is, in so many parts of a turn."""

_CLEAR = 48
"""A leader must have gone a turn by that number for it to be clear how a shadow goes with it."""


class Sweep:
    """Where one servo was turned to by hand.

    Its ``now``, ``low`` and ``high`` are positions as the register says them, counted on where the
    register folds into one turn. A servo that sees part of a turn only counts nothing.
    """

    def __init__(self, model: ServoModel) -> None:
        self._pulses = model.pulses
        self.counts = counts_turns(model)
        """Whether the servo knows its angle all the way round."""
        self.now = 0
        """Where it is, ticks."""
        self.low = 0
        """The lowest position so far, ticks."""
        self.high = 0
        """The highest position so far, ticks."""
        self.readings = 0
        """How often it was read."""
        self.torn = False
        """Whether it was turned through the angles that it does not see."""
        self._last = 0

    @property
    def travel(self) -> int:
        """From the lowest to the highest position, ticks."""
        return self.high - self.low

    def add(self, ticks: int) -> None:
        """Take a reading of Present Position."""
        if self.readings == 0:
            self.now = self.low = self.high = ticks
        else:
            step = ticks - self._last
            if abs(step) > _SURE * self._pulses and self.counts:
                half = self._pulses // 2
                step = (step + half) % self._pulses - half
            elif abs(step) > _SURE * self._pulses:
                self.torn = True
            self.now += step
            self.low, self.high = min(self.low, self.now), max(self.high, self.now)
        self._last = ticks
        self.readings += 1

    def begin_anew(self) -> None:
        """Forget the travel; begin where it is."""
        self.readings, self.torn = 0, False


class Pairing:
    """How the position of a shadow hangs together with that of its leader, while both are turned.

    ``shadow = sign * leader + offset``; which sign it is shows once they have moved.
    """

    def __init__(self, model: ServoModel) -> None:
        self._bin = max(model.pulses // _BINS, 1)
        self._clear = model.pulses // _CLEAR
        self._pairs: dict[int, tuple[int, int]] = {}

    def add(self, leader: int, shadow: int) -> None:
        """Take where both are, counted on, ticks."""
        self._pairs[leader // self._bin] = (leader, shadow)

    def line(self) -> tuple[int, float, float] | None:
        """Give sign and offset, and how far off the worst pair is, ticks; None: not clear yet."""
        pairs = self._pairs.values()
        leaders = [leader for leader, _ in pairs] or [0]
        if max(leaders) - min(leaders) < self._clear:
            return None
        found = []
        for sign in (1, -1):
            offsets = [shadow - sign * leader for leader, shadow in pairs]
            middle = float(median(offsets))
            found.append((max(abs(offset - middle) for offset in offsets), sign, middle))
        worst, sign, offset = min(found)
        return sign, offset, worst


def counts_turns(model: ServoModel) -> bool:
    """Say whether a model knows its angle all the way round, and counts turns while it has power.

    Those that see part of a turn only have no Homing Offset either.
    """
    return "Homing Offset" in model.table
