"""An arm led by hand, until somebody asks for an end; then it holds where it is."""

from collections.abc import Callable

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.backends import Station
from splinearm.config import Cell
from splinearm.control.realtime import real_time
from splinearm.control.stop import StopRequest
from splinearm.drivers.current_gravity import GravityCompensation, GuidingFeel, Haste
from splinearm.errors import ConfigError
from splinearm.joints import JointState

TOOL_SPEED = 0.25
"""How fast the tool's goal may be, m/s: what ISO 10218-1 allows an arm beside a person."""

_BETWEEN = 0.997
"""Share of it that joints may amount to in a cycle: between two the tool is a little quicker."""


def guide(
    station: Station,
    cell: Cell,
    *,
    stop: StopRequest | None = None,
    rate: float = 100.0,
    observe: Callable[[JointState], object] | None = None,
    bridge: int = 3,
) -> FloatArray:
    """Let a hand lead an open arm until Ctrl-C, SIGTERM or ``stop``; then hold it.

    Its servos carry its weight. Its goals go no faster than half of what the joints may, and so
    that the tool does no more than ``TOOL_SPEED``: a hand that is faster feels them resist.

    Args:
        station: The arm, open with its feed-forward.
        cell: What it is.
        stop: Where another thread may ask for an end.
        rate: Cycles a second, Hz.
        observe: Gets what was read in every cycle, in the loop: it must be quick.
        bridge: Cycles without an answer in which the arm stays at its goals; one more ends it.

    Returns:
        Where the arm is held in the end, shape (n,), rad.

    Raises:
        ConfigError: If the arm is no arm of servos, or what it weighs is not known.
        StaleFeedbackError: If it did not answer any more; it stays at its last goal.
        ServoError: If a servo reports an error; the others hold.
        PortError: If the port is gone; the servos stop by themselves.
    """
    ahead = station.feedforward
    if ahead is None or not ahead.knows_weight:
        raise ConfigError(
            cell.file,
            "feedforward",
            "leading by hand needs servos whose weight is carried: give each link its mass and "
            'inertia, and feedforward = "full"',
        )
    clock, period = station.clock, 1.0 / rate
    feel = GuidingFeel(haste=tool_haste(cell))
    with (
        stop if stop is not None else StopRequest() as request,
        real_time(),
        GravityCompensation(
            station.driver, ahead, cell.arm.limits, feel, period=period, bridge=bridge
        ) as compensation,
    ):
        due = clock.now()
        while not request.requested:
            due = max(due + period, clock.now())  # what was missed is not made up for
            clock.wait_until(due)
            state = compensation.step()
            if observe is not None and state is not None:
                observe(state)
        return compensation.goal


def tool_haste(cell: Cell) -> Haste:
    """Give how fast the tool of an arm is, as a share of ``TOOL_SPEED``."""
    arm = cell.arm

    def haste(q: FloatArray, qd: FloatArray) -> float:
        return float(np.linalg.norm(arm.jacobian(q)[:3] @ qd)) / (_BETWEEN * TOOL_SPEED)

    return haste
