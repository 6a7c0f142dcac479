"""What operations on a drawing give, verified by code that made none of it."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from splinearm.arrays import FloatArray

from .action import Action, Pause, Switch
from .cutter import Cutter
from .stock import Stock
from .verify import Allowance, verify
from .verify_line import Lines
from .verify_part import Task, Zone
from .verify_report import Verification
from .work import Done, Kind

_MARGIN = 5e-3
_BELOW = 1e-3


def verified(actions: Iterable[Action], done: Sequence[Done], tolerance: float) -> Verification:
    """Give what a program does to a block about what shall be cut.

    Args:
        actions: The program.
        done: The operations it was made of, at least one.
        tolerance: How much may be left where splines are, m.
    """
    zones = tuple(one.aim for one in done if isinstance(one.aim, Zone))
    lines = tuple(one.aim for one in done if isinstance(one.aim, Lines))
    cutters = _cutters(done)
    margin = _MARGIN + 2.0 * max(cutter.diameter for cutter in cutters.values())
    low, high = _bounds(zones, lines)
    floor = min(one.aim.floor for one in done)
    block = Stock(np.array([*(low - margin), floor - _BELOW]), np.array([*(high + margin), 0.0]))
    slack = max(one.slack for one in done)
    stock = max(0.0 if one.work.milling.finish else one.work.milling.stock for one in done)
    beside = stock + (tolerance if slack else 0.0)
    allowed = Allowance(gouge=1e-6 + slack, left=1e-5 + beside, beside=beside)
    one_cutter = next(iter(cutters.values())) if len(cutters) == 1 else cutters
    known = [a for a in actions if not isinstance(a, Pause | Switch)]
    return verify(known, Task(block, zones, lines), one_cutter, allowed)


def _bounds(zones: Sequence[Zone], lines: Sequence[Lines]) -> tuple[FloatArray, FloatArray]:
    """Give the lowest and the highest x and y of what shall be cut, each of shape (2,), m."""
    corners = [np.reshape(region.bounds, (2, 2)) for zone in zones for region in zone.regions]
    for one in lines:
        # a piece turns by a quarter at most: it bulges by less than its chord
        rows = one.track.pieces
        ends = np.concatenate((rows[:, :2], rows[:, 2:4]))
        bulge = float(np.hypot(*(rows[:, 2:4] - rows[:, :2]).T).max())
        corners.append(np.array([ends.min(axis=0) - bulge, ends.max(axis=0) + bulge]))
    every = np.array(corners)
    return every[:, 0].min(axis=0), every[:, 1].max(axis=0)


def _cutters(done: Sequence[Done]) -> dict[int, Cutter]:
    """Give cutters by number; sides are finished and holes drilled without steps down."""
    found: dict[int, Cutter] = {}
    for one in done:
        milling = one.work.milling
        cutter = found.get(milling.cutter.number, milling.cutter)
        if milling.finish or one.work.kind is Kind.DRILL:
            cutter = replace(cutter, step_down=max(cutter.step_down, milling.depth))
        found[cutter.number] = cutter
    return found
