"""Whoever sits before the servos: is asked before anything is written, and plugs cables."""

from collections.abc import Sequence
from typing import Protocol

from splinearm.drivers.chain import ServoSpec

from .bench import Found
from .task import Task


class Person(Protocol):
    """Who answers for what is written."""

    def tell(self, words: str) -> None:
        """Take note of a line."""
        ...

    def agrees(self, tasks: Sequence[Task]) -> bool:
        """Say whether all that may be written."""
        ...

    def allows(self, words: str) -> bool:
        """Say whether one thing may be done that is told in words."""
        ...

    def lets_fall(self, names: Sequence[str]) -> bool:
        """Say whether servos may lose their torque now: their joints may fall."""
        ...

    def connects(self, servo: ServoSpec) -> None:
        """Connect a servo as the only one that is not set up yet; need not be done at once."""
        ...

    def connects_all(self, names: Sequence[str]) -> None:
        """Connect these servos too; need not be done at once."""
        ...

    def is_it(self, servo: ServoSpec, one: Found) -> bool:
        """Say whether a servo that was there before anybody asked for it is the one asked for."""
        ...
