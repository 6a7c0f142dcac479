"""Every cycle of a motion as datagrams for PlotJuggler, while the arm moves."""

import time
from collections.abc import Sequence
from math import isnan

from splinearm.control.cycle import Cycle
from splinearm.joints import JointKind

from .document import Value, rounded, unit_of_kind
from .outlet import Datagrams

SCHEMA = "splinearm-cycle/1"
"""What the JSON of a cycle says it is."""


class MotionDatagrams:
    """An observer of a motion (``runner.run_job(observe=...)``): one datagram a cycle.

    It is called beside the loop, in a thread that the loop never waits for.

    Args:
        where: "HOST:PORT".
        names: Names of the joints.
        kinds: How each moves, for the units.

    Raises:
        ConfigError: If there is no such address.
    """

    def __init__(self, where: str, names: Sequence[str], kinds: Sequence[JointKind]) -> None:
        self._outlet = Datagrams(where)
        self._joints = [
            (name, *unit_of_kind(kind)) for name, kind in zip(names, kinds, strict=True)
        ]
        self._begun: float | None = None

    @property
    def unsent(self) -> int:
        """How many this computer could not send."""
        return self._outlet.unsent

    def __call__(self, cycle: Cycle) -> None:
        """Send one cycle."""
        if self._begun is None:
            self._begun = time.time() - cycle.t
        self._outlet.take(self._document(cycle, self._begun + cycle.t))

    def close(self) -> None:
        """Send no more."""
        self._outlet.close()

    def _document(self, cycle: Cycle, timestamp: float) -> dict[str, Value]:
        joints: dict[str, Value] = {}
        wanted, state = cycle.setpoint, cycle.state
        for i, (name, unit, per_si) in enumerate(self._joints):
            joint: dict[str, Value] = {
                f"wanted_{unit}": rounded(wanted.q[i] * per_si, 4),
                f"wanted_{unit}_s": rounded(wanted.qd[i] * per_si, 3),
            }
            if state is not None:
                joint[f"measured_{unit}"] = rounded(state.q[i] * per_si, 4)
                joint[f"measured_{unit}_s"] = rounded(state.qd[i] * per_si, 3)
                if not isnan(state.current[i]):
                    joint["current_a"] = rounded(state.current[i], 3)
            joints[name] = joint
        return {
            "schema": SCHEMA,
            "timestamp": round(timestamp, 6),
            "motion_t_s": rounded(wanted.t, 6),
            "lateness_ms": rounded(cycle.lateness * 1e3, 3),
            "busy_ms": rounded(cycle.busy * 1e3, 3),
            "joints": joints,
        }
