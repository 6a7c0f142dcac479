"""The check by depth: removal simulated on heights, way after way."""

from collections.abc import Iterator, Sequence
from math import inf

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray

from .action import Cutting, Move, Rapid
from .cutter import Cutter, Tip
from .stock import HeightMap
from .verify_part import Task
from .verify_plane import Cuts
from .verify_report import Fault

_TOUCH = 1e-8
"""A way that goes less deep into the material goes not into it, m."""
_SHARE = 1e-3
"""Share by which feeds and steps may be over what they may be: numbers in files are rounded."""
_LOOKS = 500


def way_faults(
    moves: Sequence[Move], cutters: Sequence[Cutter], done: FloatArray, top: float
) -> Iterator[Fault]:
    """Give what single ways do wrong in the material."""
    for move, cutter, (deep, x, y, _) in zip(moves, cutters, done.tolist(), strict=True):
        z = float(min(move.start[2], move.end[2]))
        place = (x, y, z)
        if isinstance(move, Rapid):
            if deep > _TOUCH:
                says = f"goes rapidly through {deep * 1e3:.6g} mm of material"
                yield Fault(kind="rapid", line=move.line, where=place, amount=deep, says=says)
            continue
        if cutter.cutting_length < top - z - _TOUCH:
            over = top - z - cutter.cutting_length
            says = f"is {over * 1e3:.6g} mm deeper than the cutter can go"
            yield Fault(kind="cutting length", line=move.line, where=place, amount=over, says=says)
        if deep <= _TOUCH:
            continue
        if deep > cutter.step_down * (1.0 + _SHARE) + _TOUCH:
            says = (
                f"takes {deep * 1e3:.6g} mm at once; the cutter may {cutter.step_down * 1e3:.6g} mm"
            )
            over = deep - cutter.step_down
            yield Fault(kind="step down", line=move.line, where=place, amount=over, says=says)
        yield from _feeds(move, cutter, place)


def _feeds(move: Cutting, cutter: Cutter, place: tuple[float, float, float]) -> Iterator[Fault]:
    """Give whether a way that cuts is quicker than it may be."""
    length = move.length
    speed = move.feed if move.feed is not None else length / (move.time or inf)
    fall = float(move.start[2] - move.end[2])
    down = speed * fall / length if length > 0.0 else 0.0
    limits = (("plunge", down, cutter.plunge, "comes down"), ("feed", speed, cutter.feed, "cuts"))
    for kind, rate, most, verb in limits:
        if rate > most * (1.0 + _SHARE):
            says = f"{verb} at {rate * 60e3:.6g} mm/min; the cutter may {most * 60e3:.6g} mm/min"
            yield Fault(kind=kind, line=move.line, where=place, amount=rate - most, says=says)


def height_faults(
    task: Task,
    left: HeightMap,
    wanted: tuple[HeightMap, HeightMap],
    cuts: Cuts,
    allowed: tuple[float, float, float],
) -> Iterator[Fault]:
    """Give where heights are too low or too high: more than a cell from any edge.

    Args:
        task: The task.
        left: What is left.
        wanted: How low it may be, and how low it must be.
        cuts: What cuts.
        allowed: How much may be cut too deep, how much may be left, and how much farther than they
            must cutters may keep off.
    """
    low = _spread(wanted[0].heights, np.minimum) - left.heights
    if low.max() > allowed[0]:
        i, k = np.unravel_index(int(np.argmax(low)), low.shape)
        amount, count = float(low.max()), int((low > allowed[0]).sum())
        says = f"leaves the part {amount * 1e3:.6g} mm too low"
        place = left.place(int(i), int(k))
        yield Fault(kind="too low", where=place, amount=amount, count=count, says=says)
    high = left.heights - _spread(wanted[1].heights, np.maximum)
    high[wanted[1].heights >= task.top] = -inf
    rows, columns = np.nonzero(high > allowed[1])
    if len(rows):
        order = np.argsort(-high[rows, columns])[:: max(1, len(rows) // _LOOKS)]
        points = left.corner + left.cell * np.column_stack((columns[order], rows[order]))
        reached = _reachable(
            task, wanted[1], (rows[order], columns[order]), points, (cuts, *allowed[1:])
        )
        if reached.any():
            first = order[int(np.argmax(reached))]
            row, column = int(rows[first]), int(columns[first])
            amount = float(high[row, column])
            says = f"leaves {amount * 1e3:.6g} mm standing on the floor"
            yield Fault(
                kind="standing",
                where=left.place(row, column),
                amount=amount,
                count=int(reached.sum()),
                says=says,
            )


def _reachable(
    task: Task,
    wanted: HeightMap,
    cells: tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]],
    points: FloatArray,
    those: tuple[Cuts, float, float],
) -> npt.NDArray[np.bool_]:
    """Say which places a cutter can cover at their floors, and did not, shape (m,).

    Cells are cut along chords: what these leave where two ways just touch was cut.
    """
    cuts, tolerance, beside = those
    floors = wanted.heights[cells]
    reached = np.zeros(len(points), dtype=bool)
    for floor in np.unique(floors).tolist():
        free = task.free_below(floor + 2e-9)
        here = floors == floor
        for cutter in cuts.tools():
            radius = cutter.radius_at(task.top - floor)
            if radius > 0.0 and (free.everywhere or len(free.outline)):
                reached[here] |= free.reachable(points[here], radius + beside)
        for cutter in cuts.tools():
            if cutter.tip is Tip.FLAT:
                low = cuts.of_tool(cutter).below(floor + tolerance)
                reached[here] &= low.gaps(points[here]) > cutter.radius + tolerance
    return reached


def _spread(heights: FloatArray, pick: np.ufunc) -> FloatArray:
    """Give the least or the largest height of a cell and its eight neighbours."""
    rows = heights.copy()
    rows[1:] = pick(rows[1:], heights[:-1])
    rows[:-1] = pick(rows[:-1], heights[1:])
    both = rows.copy()
    both[:, 1:] = pick(both[:, 1:], rows[:, :-1])
    both[:, :-1] = pick(both[:, :-1], rows[:, 1:])
    return both
