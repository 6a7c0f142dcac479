"""How a servo answers: all in all, and of late."""

from splinearm.drivers.bus import Loss
from splinearm.drivers.servo_stats import ServoStats

_LONG = 1000
"""So many reads of late make older ones count half."""
_FEW = 5
"""So many damaged or lost answers may be chance."""
_SHARE = 0.01
"""Share of the answers from which on it is more than that."""


class Tally:
    """Counts the answers of one servo."""

    def __init__(self) -> None:
        self.stats = ServoStats()
        """All of them."""
        self._reads = self._lost = self._damaged = 0

    def note(self, loss: Loss | None) -> None:
        """Count one read."""
        self.stats.reads += 1
        self._reads += 1
        if loss is Loss.SILENT:
            self.stats.timeouts += 1
            self._lost += 1
        elif loss is Loss.DAMAGED:
            self.stats.crc_errors += 1
            self._damaged += 1
        if self._reads > _LONG:
            self._reads, self._lost, self._damaged = (
                count // 2 for count in (self._reads, self._lost, self._damaged)
            )

    def begin_anew(self) -> None:
        """Let what was before say nothing of how it answers now, as after a cable was out."""
        self._reads = self._lost = self._damaged = 0

    @property
    def complaint(self) -> tuple[str, str] | None:
        """The doctor's code and the cause where too much is damaged or lost of late."""
        for code, count, what in (
            ("L07", self._damaged, "damaged"),
            ("L08", self._lost, "lost"),
        ):
            if count >= _FEW and count > _SHARE * self._reads:
                return code, f"{count} of its last {self._reads} answers are {what}"
        return None
