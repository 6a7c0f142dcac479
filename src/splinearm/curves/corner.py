"""Straight ways with rounded corners, in any number of coordinates, on bare arrays."""

import numpy as np

from splinearm.arrays import FloatArray

from .bspline import BSpline

_CRUMB = 1e-9
"""A straight way below this share of the whole is none: the roundings on both sides touch."""


def ramp(x: FloatArray, half_width: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Give a smooth max(0, x) and its first two derivatives, each of the shape of x.

    It is 0 up to minus the half width, x from the half width on, and twice continuously
    differentiable; with half width 0 it is max(0, x) itself.
    """
    # the lowest polynomial that joins both lines with equal second derivatives:
    # r = 2 w (v^3 - v^4 / 2) with v = (x + w) / (2 w); its control points lie on the two lines
    width = 2.0 * half_width
    sharp = width <= 0.0
    v = np.clip((x + half_width) / np.where(sharp, 1.0, width), 0.0, 1.0)
    inside = ~sharp & (np.abs(x) < half_width)
    value = np.where(inside, width * v**3 * (1.0 - 0.5 * v), np.maximum(x, 0.0))
    slope = np.where(inside, v * v * (3.0 - 2.0 * v), np.where(x >= 0.0, 1.0, 0.0))
    bend = np.where(inside, 6.0 * v * (1.0 - v) / np.where(sharp, 1.0, width), 0.0)
    return value, slope, bend


def rounded_polyline(corners: FloatArray, u: FloatArray, half_widths: FloatArray) -> BSpline:
    """Give straight ways between corners, rounded off, as one quartic B-spline that is C2.

    Args:
        corners: Points, shape (k + 1, dim).
        u: Their parameters, rising, shape (k + 1,); a way is run through evenly.
        half_widths: How far before and behind a corner it is rounded, in the parameter, shape
            (k + 1,), 0 at the ends; where it is 0 inside, the ways before and behind are one.
            No two may overlap.
    """
    slopes = np.diff(corners, axis=0) / np.diff(u)[:, None]
    crumb = _CRUMB * (u[-1] - u[0])
    breaks, values, directions, middles = [u[0]], [corners[0]], [slopes[0]], []
    for i in range(1, len(u) - 1):
        width = half_widths[i]
        if width <= 0.0:
            continue
        before, behind = u[i] - width, u[i] + width
        if before - breaks[-1] > crumb:
            breaks.append(before)
            values.append(corners[i] - width * slopes[i - 1])
            directions.append(slopes[i - 1])
            middles.append(0.5 * (values[-1] + values[-2]))
        breaks.append(behind)
        values.append(corners[i] + width * slopes[i])
        directions.append(slopes[i])
        middles.append(corners[i])
    if u[-1] - breaks[-1] > crumb:
        breaks.append(u[-1])
        values.append(corners[-1])
        directions.append(slopes[-1])
        middles.append(0.5 * (values[-1] + values[-2]))
    breaks[-1] = u[-1]
    return _join(np.array(breaks), np.array(values), np.array(directions), np.array(middles))


def _join(
    breaks: FloatArray, values: FloatArray, directions: FloatArray, middles: FloatArray
) -> BSpline:
    """Give the quartic with double knots from its breaks and its pieces' middle Bezier points."""
    # control points are blossoms: at a break, where the curve is straight to second order, that
    # of the tangent; between breaks that of the piece (Ramshaw, Blossoms are polar forms, 1989)
    steps = np.diff(breaks)
    padded = np.concatenate(([0.0], steps, [0.0]))
    shift = 0.25 * (padded[1:] - padded[:-1])
    tangent_points = values + shift[:, None] * directions
    points = np.empty((2 * len(middles) + 3, values.shape[1]))
    points[0], points[-1] = values[0], values[-1]
    points[1:-1:2] = tangent_points
    points[2:-1:2] = middles
    knots = np.concatenate(
        (np.repeat(breaks[0], 3), np.repeat(breaks, 2), np.repeat(breaks[-1], 3))
    )
    return BSpline(knots, points, 4)
