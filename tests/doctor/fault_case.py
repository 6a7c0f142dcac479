"""A fault that the tests inject, and what the doctor must say of it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class FaultCase:
    """One fault: in the first line of a table what is done, then what must be said."""

    code: str
    """What must be found."""
    act: str
    """What is done, in words."""
    hurt: Callable[[Any], None]
    """Does it."""
    cause: str
    """What the cause must say (a regular expression)."""
    remedy: str
    """The same of the remedy."""


def nothing(_: Any) -> None:
    """Do nothing: it is wrong already."""
