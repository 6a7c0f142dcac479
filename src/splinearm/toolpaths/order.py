"""The order of many ways that leads to the shortest travel between them."""

from collections.abc import Sequence
from math import inf

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array

_ROUNDS = 20
_MOST = 1000
"""More ways than this are ordered by the nearest one only."""


def shortest_order(
    starts: ArrayInput,
    ends: ArrayInput | None = None,
    *,
    begin: ArrayInput = (0.0, 0.0),
    turnable: Sequence[bool] | None = None,
) -> tuple[tuple[int, bool], ...]:
    """Give the order in which ways are done: the nearest next, then improved.

    Args:
        starts: Where each way begins, shape (m, 2), m.
        ends: Where each ends; None: where it begins.
        begin: Where the travel begins, shape (2,), m.
        turnable: Which ways may be run through backwards; None: none.

    Returns:
        For each way in its turn its number, and whether it is run through backwards.
    """
    first = frozen_array(starts, (None, 2), "starts")
    last = first if ends is None else frozen_array(ends, (len(first), 2), "ends")
    may = np.zeros(len(first), dtype=bool) if turnable is None else np.array(turnable, dtype=bool)
    if not len(first):
        return ()
    order, turned = _nearest(first, last, frozen_array(begin, (2,), "begin"), may)
    if len(first) <= _MOST:
        _improve(order, turned, (first, last), frozen_array(begin, (2,), "begin"), may)
    return tuple((int(i), bool(turned[i])) for i in order)


def travel(
    starts: FloatArray, ends: FloatArray, order: Sequence[tuple[int, bool]], begin: ArrayInput
) -> float:
    """Give the length of the straight ways between ways in an order, m."""
    at, far = np.asarray(begin, dtype=np.float64), 0.0
    for i, backwards in order:
        to, onward = (ends[i], starts[i]) if backwards else (starts[i], ends[i])
        far += float(np.hypot(*(to - at)))
        at = onward
    return far


def _nearest(
    first: FloatArray, last: FloatArray, begin: FloatArray, may: "np.typing.NDArray[np.bool_]"
) -> "tuple[list[int], np.typing.NDArray[np.bool_]]":
    """Give the order that always takes the nearest way, and which are turned."""
    turned = np.zeros(len(first), dtype=bool)
    left = np.ones(len(first), dtype=bool)
    order: list[int] = []
    at = begin
    for _ in range(len(first)):
        to_start = np.where(left, np.hypot(*(first - at).T), inf)
        to_end = np.where(left & may, np.hypot(*(last - at).T), inf)
        i, k = int(to_start.argmin()), int(to_end.argmin())
        if to_end[k] < to_start[i]:
            i = k
            turned[i] = True
        left[i] = False
        order.append(i)
        at = first[i] if turned[i] else last[i]
    return order, turned


def _improve(
    order: list[int],
    turned: "np.typing.NDArray[np.bool_]",
    ends: tuple[FloatArray, FloatArray],
    begin: FloatArray,
    may: "np.typing.NDArray[np.bool_]",
) -> None:
    """Turn parts of an order about, and take single ways elsewhere, while that makes it shorter.

    The first is 2-opt (Croes 1958). Ways in the part are turned too where they may be; a part that
    holds one that has a direction and ends elsewhere than it begins stays.
    """
    first, last = ends
    n = len(order)
    round_ = (first == last).all(axis=1) | may
    for _ in range(_ROUNDS):
        better = False
        for i in range(n - 1):
            ins, outs = _doors(order, turned, ends)
            before = begin if i == 0 else outs[i - 1]
            # the part i..j reversed: its last way's exit follows what came before
            old = np.hypot(*(ins[i] - before)) + np.hypot(*(np.roll(ins, -1, 0) - outs).T)
            new = np.hypot(*(outs - before).T) + np.hypot(*(np.roll(ins, -1, 0) - ins[i]).T)
            old[-1], new[-1] = np.hypot(*(ins[i] - before)), np.hypot(*(outs[-1] - before))
            gain = old - new
            gain[: i + 1] = 0.0
            fixed = np.flatnonzero(~round_[np.array(order[i:])])
            if len(fixed):
                gain[i + int(fixed[0]) :] = 0.0
            j = int(gain.argmax())
            if gain[j] > 1e-9 * (1.0 + float(np.abs(first).max())):
                part = order[i : j + 1]
                order[i : j + 1] = part[::-1]
                for k in part:
                    turned[k] = turned[k] ^ bool(may[k])
                better = True
        if not (_shift(order, turned, ends, begin) or better):
            return


def _shift(
    order: list[int],
    turned: "np.typing.NDArray[np.bool_]",
    ends: tuple[FloatArray, FloatArray],
    begin: FloatArray,
) -> bool:
    """Take single ways to where they lie on the way (Or 1976); say whether any was taken."""
    taken = False
    for way in tuple(order):
        at = order.index(way)
        ins, outs = _doors(order, turned, ends)
        before = np.vstack((begin, outs[:-1]))
        rest = np.delete(np.arange(len(order)), at)
        # what is saved by leaving it out, and what it costs before each other and at the end
        gaps = np.hypot(*(ins - before).T)
        saved = gaps[at]
        if at + 1 < len(order):
            saved += gaps[at + 1] - np.hypot(*(ins[at + 1] - before[at]))
        previous = np.vstack((begin, outs[rest]))
        costs = np.hypot(*(ins[at] - previous).T)
        costs[:-1] += np.hypot(*(ins[rest] - outs[at]).T) - np.hypot(*(ins[rest] - previous[:-1]).T)
        k = int(costs.argmin())
        if saved - costs[k] > 1e-9 * (1.0 + float(np.abs(ins).max())):
            order.insert(k, order.pop(at))
            taken = True
    return taken


def _doors(
    order: list[int],
    turned: "np.typing.NDArray[np.bool_]",
    ends: tuple[FloatArray, FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """Give where the ways are entered and left, in order."""
    index = np.array(order)
    back = turned[index][:, None]
    return (
        np.where(back, ends[1][index], ends[0][index]),
        np.where(back, ends[0][index], ends[1][index]),
    )
