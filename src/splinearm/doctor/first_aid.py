"""Why a command could not reach its servos, in one line, by a quick look at the line.

A timeout says only that nobody answered. Before it is shown the same checks as those of ``splinearm
doctor`` are run, as far as they take a moment, and their first finding takes its place.
"""

from pathlib import Path
from typing import TYPE_CHECKING

from splinearm.errors import BusTimeoutError, PacketError, PortError, SplinearmError

from .finding import Finding, Severity

if TYPE_CHECKING:
    from splinearm.config import Cell

EXPLAINED = (BusTimeoutError, PacketError, PortError)
"""The errors that a look at the line explains."""

_SILENCING = frozenset(("S01", "S06", "S09", "S11"))
"""What may be wrong inside a servo that does not answer as it should."""

_DAMAGING = frozenset(("P05", "L05", "L07", "L11"))
"""What may be wrong on a line on which answers come damaged, whatever else is."""

_NO_PORTS = ("mujoco", "virtual")


def explained(
    error: SplinearmError,
    *,
    port: str | None = None,
    arm: str | None = None,
    job: str | None = None,
) -> str:
    """Give an error in one line, with its cause and what mends it where a look tells.

    Args:
        error: The error.
        port: The port that the command was told, if the error names none.
        arm: The arm that the command was told.
        job: The job that it was told, which names an arm too.
    """
    port = getattr(error, "port", "") or port
    if not isinstance(error, EXPLAINED) or port is None or port in _NO_PORTS:
        return str(error)
    cell, name = _cell(arm, job)
    command = f"splinearm doctor {port}" + (f" --arm {name}" if name else "")
    if _has_ended(port):
        return (
            f"{error}; the virtual bus has ended with this run: if this computer was too busy, "
            "close other programs and try again"
        )
    finding = _first(error, port, cell, name)
    if finding is None:
        return f"{error}; `{command}` looks closer"
    head = _head(error)
    where = "" if finding.where in head else f"{finding.where}: "
    return (
        f"{head}: {where}{finding.cause}; {finding.remedy} "
        f"({finding.code}; `{command}` looks closer)"
    )


def _cell(arm: str | None, job: str | None) -> "tuple[Cell | None, str | None]":
    """Give the arm of a command and its name, as far as they can be told."""
    from splinearm.config import load_cell, load_job, shipped_arms
    from splinearm.config.cell import arm_file

    try:
        if arm is None and job is not None and job.endswith(".toml"):
            arm = str(load_job(job).arm)
        if arm is None:
            return None, None
        cell = load_cell(arm)
    except SplinearmError:
        return None, arm
    is_shipped = cell.name in shipped_arms() and arm_file(cell.name) == cell.file
    return cell, cell.name if is_shipped else arm


def _has_ended(port: str) -> bool:
    """Tell whether a port was the socket of a bus that is no more."""
    return port.startswith("unix:") and not Path(port.removeprefix("unix:")).exists()


def _first(
    error: SplinearmError, port: str, cell: "Cell | None", arm: str | None
) -> Finding | None:
    """Look, and give what is to be mended first; None: nothing that explains an error."""
    from .look import QUICK, diagnose

    try:
        diagnosis = diagnose(port, cell, arm=arm, effort=QUICK)
    except SplinearmError:
        return None
    telling = [f for f in diagnosis.findings if _tells(f, error)]
    if isinstance(error, PacketError):
        telling = [f for f in telling if f.code in _DAMAGING] or telling
    serious = [f for f in telling if f.severity is Severity.ERROR]
    return next(iter(serious or telling), None)


def _tells(finding: Finding, error: SplinearmError) -> bool:
    """Tell whether a finding may be why a command failed so."""
    if isinstance(error, PortError):
        return finding.code.startswith("P")
    return finding.code[0] in "PL" or finding.code in _SILENCING


def _head(error: SplinearmError) -> str:
    """Say what failed, without a guess at the cause."""
    if isinstance(error, BusTimeoutError):
        name = f" ({error.name})" if error.name else ""
        return f"servo {error.servo_id}{name} does not answer"
    if isinstance(error, PortError):
        return f"port {error.port} cannot be used"
    return str(error)
