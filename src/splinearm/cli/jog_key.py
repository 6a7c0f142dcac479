"""What the keys of ``splinearm jog`` mean, and how long one counts as held."""

from collections import deque
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.kinematics.arm import Frame

MODES = ("joints", "base", "tool")
"""What is moved: one joint, or the tool along the axes of a frame."""
AXES = {
    "up": (0, 1.0), "down": (0, -1.0), "left": (1, 1.0), "right": (1, -1.0), "r": (2, 1.0),
    "f": (2, -1.0), "o": (3, 1.0), "u": (3, -1.0), "k": (4, 1.0), "i": (4, -1.0), "j": (5, 1.0),
    "l": (5, -1.0),
}  # fmt: skip
"""Which axis of the tool a key moves, and which way."""
SPEEDS_MM = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 150.0, 200.0, 250.0)
SPEEDS_DEG = (1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 45.0, 60.0)
STEPS_MM = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
STEPS_DEG = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0)

_TAP = 0.12
"""How long a key counts that has not repeated yet, s."""
_SHORTEST, _LONGEST = 0.08, 0.4
"""Bounds of how long one counts that repeats, s."""
_REPEATS = 0.2
"""Presses of one key that follow sooner than this, s, come from a key that is held."""
_LATE = 2.5
"""So many times as late as the slowest of the last repeats one may come."""


class KeyRepeat:
    """How long a key counts as held: terminals say when a key comes, not when it is let go."""

    def __init__(self) -> None:
        self._key = ""
        self._t = -np.inf
        self._between: deque[float] = deque(maxlen=8)

    def press(self, key: str, t: float) -> None:
        """Take note of a key at a time, s."""
        between = t - self._t
        if key == self._key and between < _REPEATS:
            self._between.append(between)
        self._key, self._t = key, t

    @property
    def lasts(self) -> float:
        """How long a key counts after it came, s."""
        if len(self._between) < 3:
            return _TAP
        return float(np.clip(_LATE * max(self._between), _SHORTEST, _LONGEST))


@dataclass(slots=True, kw_only=True)
class Settings:
    """What a person has chosen."""

    n: int
    """Number of joints."""
    mode: str = "joints"
    """One of `MODES`."""
    joint: int = 0
    """The joint that is moved."""
    stepping: bool = False
    """Whether a key is one step."""
    speed_mm: float = 50.0
    """Speed of the tool and of sliding joints, mm/s."""
    speed_deg: float = 15.0
    """Speed of turns, deg/s."""
    step_mm: float = 1.0
    """A step, mm."""
    step_deg: float = 1.0
    """A step of a turn, deg."""

    @property
    def frame(self) -> Frame | None:
        """Along whose axes the tool is moved; None: a joint is."""
        if self.mode == "joints":
            return None
        return "tool" if self.mode == "tool" else "base"

    def change(self, key: str) -> bool:
        """Take a key that changes settings; give whether it does."""
        if key == "tab":
            self.mode = MODES[(MODES.index(self.mode) + 1) % len(MODES)]
        elif key == "m":
            self.stepping = not self.stepping
        elif key in "+=-":
            up = key != "-"
            self.speed_mm = _next(SPEEDS_MM, self.speed_mm, up=up)
            self.speed_deg = _next(SPEEDS_DEG, self.speed_deg, up=up)
        elif key in "[]":
            up = key == "]"
            self.step_mm = _next(STEPS_MM, self.step_mm, up=up)
            self.step_deg = _next(STEPS_DEG, self.step_deg, up=up)
        elif key.isdecimal() and 1 <= int(key) <= self.n:
            self.mode, self.joint = "joints", int(key) - 1
        elif self.mode == "joints" and key in ("up", "down"):
            self.joint = (self.joint + (1 if key == "down" else -1)) % self.n
        else:
            return False
        return True

    def rates(self, key: str, slides: bool) -> FloatArray | None:  # noqa: FBT001
        """Give the speeds that a key wishes, (n,) or (6,), in SI, or None.

        Args:
            key: The key.
            slides: Whether the chosen joint slides.
        """
        mm, deg = self.speed_mm * 1e-3, np.radians(self.speed_deg)
        if self.mode == "joints":
            if key not in ("left", "right"):
                return None
            rates = np.zeros(self.n)
            rates[self.joint] = (mm if slides else deg) * (1.0 if key == "right" else -1.0)
            return rates
        if key not in AXES:
            return None
        axis, sign = AXES[key]
        rates = np.zeros(6)
        rates[axis] = sign * (mm if axis < 3 else deg)
        return rates

    def step_time(self, rates: FloatArray, slides: bool) -> float:  # noqa: FBT001
        """Give for how long rates are a step, s."""
        along = slides if self.mode == "joints" else bool(rates[:3].any())
        step = self.step_mm * 1e-3 if along else np.radians(self.step_deg)
        return float(step / np.abs(rates).max())


def _next(ladder: tuple[float, ...], value: float, *, up: bool) -> float:
    """Give the next rung of a ladder."""
    if up:
        return next((rung for rung in ladder if rung > value * 1.001), ladder[-1])
    return next((rung for rung in reversed(ladder) if rung < value * 0.999), ladder[0])
