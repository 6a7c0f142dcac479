"""What operations on a drawing give, verified by code that made none of it."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from .action import Action, Pause, Switch
from .cutter import Cutter
from .stock import Stock
from .verify import Allowance, verify
from .verify_part import Task
from .verify_report import Verification
from .work import Done

_MARGIN = 5e-3
_BELOW = 1e-3


def verified(
    actions: Iterable[Action], done: Sequence[Done], tolerance: float
) -> Verification | None:
    """Give what a program does to a block about its zones.

    Args:
        actions: The program.
        done: The operations it was made of.
        tolerance: How much may be left where splines are, m.

    Returns:
        What was found; None where an operation says no part to compare with: facing, engraving,
        and profiles on the line.
    """
    zones = [one.zone for one in done if one.zone is not None]
    if len(zones) < len(done) or not zones:
        return None
    bounds = np.array([region.bounds for zone in zones for region in zone.regions])
    cutters = _cutters(done)
    margin = _MARGIN + 2.0 * max(cutter.diameter for cutter in cutters.values())
    floor = min(zone.floor for zone in zones)
    low = np.array([*(bounds[:, :2].min(axis=0) - margin), floor - _BELOW])
    high = np.array([*(bounds[:, 2:].max(axis=0) + margin), 0.0])
    slack = max(one.slack for one in done)
    left = 1e-5 + max(0.0 if one.work.milling.finish else one.work.milling.stock for one in done)
    allowed = Allowance(gouge=1e-6 + slack, left=left + (tolerance if slack else 0.0))
    one_cutter = next(iter(cutters.values())) if len(cutters) == 1 else cutters
    known = [a for a in actions if not isinstance(a, Pause | Switch)]
    return verify(known, Task(Stock(low, high), tuple(zones)), one_cutter, allowed)


def _cutters(done: Sequence[Done]) -> dict[int, Cutter]:
    """Give cutters by number; one that finishes sides may do that at full depth."""
    found: dict[int, Cutter] = {}
    for one in done:
        milling = one.work.milling
        cutter = found.get(milling.cutter.number, milling.cutter)
        if milling.finish:
            cutter = replace(cutter, step_down=max(cutter.step_down, milling.depth))
        found[cutter.number] = cutter
    return found
