"""Words on the command line that several commands share, turned into values."""

from typing import TYPE_CHECKING

from splinearm.errors import ConfigError

if TYPE_CHECKING:
    from splinearm.arrays import FloatArray
    from splinearm.config import Cell


def rate_of(rate: float) -> float:
    """Give the rate of ``--rate``, Hz.

    Raises:
        ConfigError: If no loop can have it.
    """
    if not 1.0 <= rate <= 2000.0:
        raise ConfigError("--rate", "", f"want 1 to 2000 setpoints a second, got {rate:g}")
    return rate


def start_of(cell: "Cell", pose: str | None, start_deg: str | None) -> "FloatArray":
    """Give the joint vector of a named pose or of a list of degrees.

    Raises:
        ConfigError: If the pose is not known or the list does not fit the arm.
    """
    import numpy as np

    if start_deg is None:
        name = pose if pose is not None else "home"
        if name not in cell.poses:
            raise ConfigError("--pose", "", f"{name!r} is not one of {', '.join(cell.poses)}")
        return cell.poses[name]
    try:
        values = np.array([float(word) for word in start_deg.split(",")])
    except ValueError as error:
        raise ConfigError("--start-deg", "", f"want numbers, got {start_deg!r}") from error
    if values.size != cell.arm.n or not np.isfinite(values).all():
        raise ConfigError("--start-deg", "", f"want {cell.arm.n} numbers, got {start_deg!r}")
    return cell.from_file_units(values)
