"""What parallel contours leave between them where they are farther apart than the cutter's radius.

A ring takes all that is within the radius r of it. Beyond the ring at the distance d from the wall,
what is farther from the wall than e = d + r must be taken by the next one, at d + s: it does,
except where the straight way up from the wall ends before it gets there, in corners and in the
middle. The stretches of the contour at e from which no such way leads to the next ring within s - r
take what is there: nothing of it is farther than r from them.
"""

from collections.abc import Iterator, Sequence
from math import ceil

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray

from .contour import Contour
from .offset import Offsets
from .region import Region
from .stretch import direction_at, place_at, stretch

_STEP = 0.1
"""Looks along a contour are so many radii apart."""
_RAYS = 8
_LEFT = 0.86
"""Something stays where a look is farther from the next ring than so many radii: looks are near
enough to each other that nothing between them is farther than one."""


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
    level = distance + radius
    contours = [c for region in offsets.at(-level) for c in region.contours]
    if not inner:
        return contours
    ways: list[Contour] = []
    beyond = step - radius
    for contour in contours:
        alongs, places, normals = _looks(contour, _STEP * radius)
        far = _distance(inner, places)
        open_ = far > beyond * (1.0 + 1e-6)
        if not open_.any():
            continue
        left = np.zeros(len(places), dtype=bool)
        left[open_] = _stays(
            offsets.part, inner, places[open_], normals[open_], (level, beyond, radius)
        )
        ways += _stretches(contour, alongs, open_, left, _STEP * radius)
    return ways


def _looks(contour: Contour, step: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give places along a contour, from corner to corner, and the direction to its left there."""
    rows: list[tuple[float, FloatArray, FloatArray]] = []
    mark = 0.0
    for start, end, bulge, size in zip(
        contour.starts, contour.ends, contour.bulges.tolist(), contour.lengths, strict=True
    ):
        if size == 0.0:
            continue
        count = max(1, ceil(size / step))
        for k in range(count + 1):
            t = direction_at(start, end, bulge, k / count)
            place = place_at(start, end, bulge, k / count)
            rows.append((mark + size * k / count, place, np.array([-t[1], t[0]])))
        mark += size
    alongs, places, normals = zip(*rows, strict=True)
    return np.array(alongs), np.array(places), np.array(normals)


def _distance(regions: Sequence[Region], places: FloatArray) -> FloatArray:
    found: FloatArray = np.min([region.distance(places) for region in regions], axis=0)
    return found


def _stays(
    part: Region,
    inner: Sequence[Region],
    places: FloatArray,
    normals: FloatArray,
    sizes: tuple[float, float, float],
) -> npt.NDArray[np.bool_]:
    """Say from which places straight ways lead to what the inner ring does not reach."""
    level, beyond, radius = sizes
    steps = np.linspace(0.0, beyond, _RAYS)
    looks = places[:, None, :] + steps[None, :, None] * normals[:, None, :]
    # on its way from the wall a place is farther by as much as it went
    on_way = part.distance(looks) >= level + steps - 1e-9 * (level + beyond)
    stays = on_way & (_distance(inner, looks) > _LEFT * radius)
    return np.asarray(stays.any(axis=1))


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
        path = stretch(contour, begin, end)
        vertices = np.concatenate((path.vertices, path.vertices[-2:0:-1]))
        yield Contour.made(vertices, np.concatenate((path.bulges, -path.bulges[::-1])))
