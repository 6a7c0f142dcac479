"""What parallel contours leave between them where they are farther apart than the cutter's radius.

A ring takes all that is within the radius r of it. Beyond the ring at the distance d from the wall,
what is farther from the wall than e = d + r must be taken by the next one, at d + s: it does,
except where the straight way up from the wall ends before it gets there, in corners and in the
middle. The stretches of the contour at e from which no such way leads to the next ring within s - r
take what is there: nothing of it is farther than r from them.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray

from .contour import Contour, joined
from .offset import Offsets
from .region import Region
from .stretch import stretch, there_and_back

_STEP = 0.1
"""Looks along a contour are so many radii apart."""


def ridge_ways(
    offsets: Offsets, inner: Sequence[Region], distance: float, step: float, radius: float
) -> list[Contour]:
    """Give closed ways that take what stays between two rings; stretches go there and back.

    Args:
        offsets: The part.
        inner: The regions of the inner ring, none if there is none.
        distance: How far the outer ring is from the wall, m.
        step: How much farther the inner one is, above the radius, m.
        radius: The cutter's, m.
    """
    from .ridge_kernel import looked_along

    level, step_along = distance + radius, _STEP * radius
    contours = [c for region in offsets.at(-level) for c in region.contours]
    if not inner or not contours:
        return contours
    ring = joined(c for region in inner for c in region.contours)
    sizes = level, step - radius, radius
    rows, begins = looked_along(
        joined(contours), joined(offsets.part.contours), ring, sizes, step_along
    )
    ways: list[Contour] = []
    for contour, (first, end) in zip(contours, pairwise(begins.astype(int).tolist()), strict=True):
        own = rows[first:end]
        open_ = own[:, 1] == 1.0
        if open_.any():
            ways += _stretches(contour, own[:, 0], open_, own[:, 2] == 1.0, step_along)
    return ways


def _stretches(
    contour: Contour,
    alongs: FloatArray,
    open_: npt.NDArray[np.bool_],
    left: npt.NDArray[np.bool_],
    step: float,
) -> Iterator[Contour]:
    """Give the stretches that are open and from which something stays."""
    whole = contour.length
    if open_.all():
        yield contour
        return
    shift = int(np.argmin(open_))
    order = np.roll(np.arange(len(alongs)), -shift)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], open_[order], [False])).astype(int)))
    for a, b in edges.reshape(-1, 2).tolist():
        run = order[a:b]
        if not left[run].any():
            continue
        begin, end = alongs[run[0]] - step, alongs[run[-1]] + step
        if end < begin:
            end += whole
        if end - begin >= whole:
            yield contour
            return
        yield there_and_back(stretch(contour, begin, end))
