"""How a gripper's servo is mounted: where it is open, where closed, how hard it closes."""

from dataclasses import dataclass

FORCE = 0.25
"""How hard a gripper closes if nothing is said, as a share of its servo's stall torque. The vendor
of OpenMANIPULATOR-X closes with 200 units of Goal Current, 23 % of the stall current; that of the
WidowX arms with 150 to 350 of 885 units of PWM."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Grip:
    """How a gripper's servo moves its fingers."""

    open_ticks: int | None = None
    """Position register where it is open; None: must be calibrated first."""
    closed_ticks: int | None = None
    """Position register where it is closed with nothing in it; None: must be calibrated first."""
    force: float = FORCE
    """How hard it closes if nothing else is said, a share of the servo's stall torque."""

    def __post_init__(self) -> None:
        if not 0.0 < self.force <= 1.0:
            raise ValueError(f"force: want above 0 and at most 1, got {self.force}")
        if self.open_ticks is not None and self.open_ticks == self.closed_ticks:
            raise ValueError(f"open_ticks: want others than closed_ticks, got {self.open_ticks}")

    @property
    def travel(self) -> tuple[int, int] | None:
        """Ticks where it is closed and where it is open; None: not calibrated."""
        if self.open_ticks is None or self.closed_ticks is None:
            return None
        return self.closed_ticks, self.open_ticks
