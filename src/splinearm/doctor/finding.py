"""What a check has found, as data."""

from dataclasses import asdict, dataclass
from enum import StrEnum

SCHEMA = "splinearm-doctor/1"
"""What the JSON of a diagnosis says it is."""


class Severity(StrEnum):
    """How much a finding matters."""

    ERROR = "error"
    """The arm does not work until it is mended."""
    WARNING = "warning"
    """It works, but worse than it could, or not for long."""
    HINT = "hint"
    """Nothing is wrong; something more would be possible."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One thing that is not as it should be."""

    code: str
    """Its name, as in "L02": a paragraph of docs/troubleshooting.md has it for its title."""
    severity: Severity
    """How much it matters."""
    what: str
    """What it is, in a few words, the same for every finding of this code."""
    cause: str
    """What was found, in one line."""
    remedy: str
    """The command or the act that mends it."""
    where: str
    """The port, the servo or the computer that is concerned."""

    def __str__(self) -> str:
        return f"{self.code} {self.what}: {self.where}: {self.cause}; {self.remedy}"

    def document(self) -> dict[str, str]:
        """Give it for JSON."""
        return asdict(self)
