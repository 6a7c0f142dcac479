"""What is wished of a jogged arm, and the desk on which any thread may lay it."""

import threading
import time
from dataclasses import dataclass

from splinearm.arrays import FloatArray
from splinearm.kinematics.arm import Frame


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Wish:
    """A motion that is wished."""

    rates: FloatArray
    """Speeds of the joints, shape (n,), rad/s or m/s; or of the tool, m/s and rad/s, shape (6,)."""
    frame: Frame | None
    """Along whose axes the tool shall go; None: the joints are meant."""
    lasts: float
    """For how long, s: after that without a new wish the arm brakes. Of a step, how long it takes
    at full speed."""
    step: bool = False
    """Whether all of the way shall be gone, however long that takes."""


class Desk:
    """Where wishes are laid down and the loop takes them; only the newest counts."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._wish: Wish | None = None
        self._laid = 0.0
        self._brake = False

    def lay(self, wish: Wish) -> None:
        """Lay a wish down; it takes the place of one that was not taken yet."""
        with self._lock:
            self._wish, self._laid = wish, time.monotonic()

    def brake(self) -> None:
        """Wish that the arm brakes; what was wished before is forgotten."""
        with self._lock:
            self._wish, self._brake = None, True

    def take(self) -> tuple[bool, Wish | None]:
        """Take whether to brake, and a wish if a new one is there that is not out of date."""
        with self._lock:
            brake, wish = self._brake, self._wish
            self._brake, self._wish = False, None
            if wish is not None and time.monotonic() - self._laid > wish.lasts:
                wish = None
            return brake, wish
