"""How each servo of an arm answered during a motion."""

from collections.abc import Mapping
from dataclasses import dataclass

from splinearm.drivers.base import ArmDriver
from splinearm.drivers.chain import ServoChain


@dataclass(frozen=True, slots=True, kw_only=True)
class ServoCount:
    """How one servo answered."""

    servo_id: int
    """Its id."""
    name: str
    """What the arm file calls it."""
    joint: str
    """The joint it moves."""
    reads: int
    """How often it was asked."""
    timeouts: int
    """How often nothing came from it."""
    crc_errors: int
    """How often what came was damaged."""
    retries: int
    """How often it was asked again."""


_COUNTED = ("reads", "timeouts", "crc_errors", "retries")


class ServoCounter:
    """Counts from the moment it is made.

    Args:
        driver: The arm; without ``stats`` nothing is counted.
        chain: Its servos, for their names.
    """

    def __init__(self, driver: ArmDriver, chain: ServoChain | None) -> None:
        self._driver = driver
        self._chain = chain
        self._before = self._figures()

    def counts(self) -> tuple[ServoCount, ...]:
        """Give what was counted since then."""
        if self._chain is None:
            return ()
        specs = {spec.servo_id: spec for spec in self._chain.servos}
        nothing = dict.fromkeys(_COUNTED, 0)
        counts = []
        for servo_id, now in self._figures().items():
            before, spec = self._before.get(servo_id, nothing), specs[servo_id]
            since = {what: now[what] - before[what] for what in _COUNTED}
            counts.append(
                ServoCount(servo_id=servo_id, name=spec.name, joint=spec.joint or "", **since)
            )
        return tuple(counts)

    def _figures(self) -> dict[int, dict[str, int]]:
        stats: Mapping[int, object] = getattr(self._driver, "stats", {})
        return {
            servo_id: {what: getattr(one, what, 0) for what in _COUNTED}
            for servo_id, one in stats.items()
        }
