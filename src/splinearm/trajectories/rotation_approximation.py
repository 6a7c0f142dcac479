"""Cumulative B-splines near many given orientations, with few control orientations."""

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.curves import banded, basis
from splinearm.errors import CurveError
from splinearm.kinematics import quaternion

from .rotation_bspline import RotationBSpline, cumulative_values, shorter
from .rotation_jacobian import inverse_jacobian, jacobian
from .turning import checked_quats, equal_signs

_SWEEPS = 12
"""Most improvements of the control orientations."""

_CONVERGED = 1e-3
"""Share by which a sweep must lower the squared misses for another to be worth it."""


def approximate_orientations(
    u: ArrayInput, quats: ArrayInput, tolerance: float, *, degree: int = 3
) -> RotationBSpline:
    """Give a curve with few control orientations that passes within a tolerance of orientations.

    It is the curve of least squared angles for its knots. These are put in where it is not near
    enough, then spread again, fewer of them, by how much the curve bends. That there is no curve
    with still fewer is not proved.

    Args:
        u: Parameters, rising, shape (m,).
        quats: Orientations, unit quaternions w x y z of either sign, shape (m, 4).
        tolerance: The greatest angle, rad, between curve and orientations at the parameters.
        degree: Degree, 1 to 5, of which the curve has one continuous derivative less.

    Raises:
        CurveError: If no curve with fewer control orientations than there are orientations is so
            near.
        ValueError: If numbers, order or lengths do not fit.
    """
    given = equal_signs(checked_quats(quats))
    parameters = frozen_array(u, (len(given),), "u")
    if (np.diff(parameters) <= 0.0).any():
        raise ValueError(f"u: want rising parameters, got {parameters.tolist()}")
    if not 1 <= degree <= 5 or len(given) <= degree:
        raise ValueError(
            f"degree: want 1 to 5 and fewer than the {len(given)} orientations, got {degree!r}"
        )
    if not 0.0 < tolerance < np.pi:
        raise ValueError(f"tolerance: want between 0 and pi rad, got {tolerance!r}")
    best = _refined(parameters, given, degree, tolerance)
    if best is None:
        raise CurveError(
            f"no curve of degree {degree} with at most {len(given)} control orientations was found "
            f"within {tolerance:.3g} rad of all; interpolate them, or allow more",
            "orientations",
        )
    need = _bending(best)
    low, high = degree, len(best.turns) + 1
    while high - low > 1:
        middle = (low + high) // 2
        curve = _least_squares(
            parameters, given, _spread_knots(parameters, need, middle, degree), degree
        )
        if curve is not None and _misses_of(curve, parameters, given).max() <= tolerance:
            best, high = curve, middle
        else:
            low = middle
    return best


def _misses_of(curve: RotationBSpline, u: FloatArray, quats: FloatArray) -> FloatArray:
    return quaternion.angle_between(curve.at(u).quat, quats)


def _refined(
    u: FloatArray, quats: FloatArray, degree: int, tolerance: float
) -> RotationBSpline | None:
    """Give a curve within a tolerance that has knots put in until it is, or None."""
    inner = np.empty(0)
    while len(inner) + degree + 1 <= len(u):
        edge = np.ones(degree + 1)
        knots = np.concatenate((edge * u[0], inner, edge * u[-1]))
        curve = _least_squares(u, quats, knots, degree)
        if curve is None:
            return None
        far = _misses_of(curve, u, quats) > tolerance
        if not far.any():
            return curve
        # each stretch between knots that holds a miss is parted in the middle of its parameters
        ends = np.concatenate(([0], np.searchsorted(u, inner), [len(u)]))
        holds = np.add.reduceat(far, ends[:-1]) > 0
        roomy = np.diff(ends) >= 2
        parted = holds & roomy
        while not parted.any():
            # what misses has no room: its neighbours hold it
            wider = holds.copy()
            wider[1:] |= holds[:-1]
            wider[:-1] |= holds[1:]
            if (wider == holds).all():
                return None
            holds = wider
            parted = holds & roomy
        at = ((ends[:-1] + ends[1:]) // 2)[parted]
        inner = np.sort(np.concatenate((inner, 0.5 * (u[at - 1] + u[at]))))
    return None


def _spread_knots(
    u: FloatArray, need: tuple[FloatArray, FloatArray], count: int, degree: int
) -> FloatArray:
    """Give clamped knots that share a need evenly: parameters, and how much is needed up to them.

    Each control orientation is given parameters to hold on to.
    """
    inner = count - degree - 1
    wanted = np.interp(np.linspace(0.0, need[1][-1], inner + 2)[1:-1], need[1], need[0])
    # Schoenberg and Whitney: between the knots of each basis function lies a parameter of its own
    places = np.searchsorted(u, wanted)
    index = np.arange(inner)
    least, most = index + 1, len(u) - 1 - inner + index
    places = np.maximum.accumulate(np.clip(places, least, most) - index) + index
    places = np.minimum(places, most)
    inside = 0.5 * (u[places - 1] + u[places])
    edge = np.ones(degree + 1)
    return np.concatenate((edge * u[0], inside, edge * u[-1]))


def _bending(curve: RotationBSpline) -> tuple[FloatArray, FloatArray]:
    """Give parameters and how much a curve bends up to them, which is what knots are needed for."""
    # de Boor, A Practical Guide to Splines, 1978, ch. XII: knots as dense as the root of the next
    # derivative, which is estimated by the jumps of the highest that the curve has
    degree, edges = curve.degree, curve.breaks
    middles = 0.5 * (edges[:-1] + edges[1:])
    points = np.concatenate((np.zeros((1, 3)), np.cumsum(curve.turns, axis=0)))
    highest = basis.evaluate(curve.knots, points, degree, middles, degree)
    jumps = np.linalg.norm(np.diff(highest, axis=0), axis=1) / np.diff(middles)
    around = np.zeros(len(middles))
    around[:-1] += jumps
    around[1:] += jumps
    density = around ** (1.0 / (degree + 1))
    # no stretch is left without knots: where the estimate is nothing, the curve may still bend
    density += 0.1 * density.mean() + np.finfo(np.float64).tiny
    return edges, np.concatenate(([0.0], np.cumsum(density * np.diff(edges))))


def _least_squares(
    u: FloatArray, quats: FloatArray, knots: FloatArray, degree: int
) -> RotationBSpline | None:
    """Give the curve on knots with the least squared angles to orientations, or None."""
    # Gauss and Newton's method on control orientations turned in their own frames
    count = len(knots) - degree - 1
    spans = basis.find_spans(knots, degree, u)
    shares = cumulative_values(knots, degree, spans, u)
    # the nearest parameters to Greville's give the first control orientations
    greville = np.lib.stride_tricks.sliding_window_view(knots[1:-1], degree).mean(axis=1)
    controls = quats[np.minimum(np.searchsorted(u, greville), len(u) - 1)]
    alive = spans[:, None] + np.arange(-degree, 1)
    before = np.inf
    best = None
    for _ in range(_SWEEPS):
        misses, slopes = _misses(quats, controls, alive, shares)
        square = float(np.sum(misses * misses))
        if square < before:
            best = controls
        if not square < before * (1.0 - _CONVERGED):
            break
        before = square
        try:
            step = _normal_step(misses, slopes, alive[:, 0], count)
        except np.linalg.LinAlgError:
            return None
        controls = quaternion.normalize(
            quaternion.multiply(controls, quaternion.exp(-step.reshape(-1, 3)))
        )
    return None if best is None else RotationBSpline.from_controls(knots, best, degree)


def _misses(
    quats: FloatArray, controls: FloatArray, alive: basis.IndexArray, shares: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Give rotation vectors from orientations to the curve and their slopes by the controls.

    Shapes (m, 3) and (m, 3, degree + 1, 3); controls are turned in their own frames.
    """
    m, degree = shares.shape
    turns = shorter(controls)
    inverse = inverse_jacobian(turns)
    local = alive[:, :-1]
    slopes = np.zeros((m, 3, degree + 1, 3))
    product = np.tile((1.0, 0.0, 0.0, 0.0), (m, 1))
    # a turn log(a^-1 b) changes by J^-1 of what b turns less J^-T of what a turns
    for j in range(degree - 1, -1, -1):
        turn = turns[local[:, j]]
        part = shares[:, j, None] * turn
        back = quaternion.to_matrix(quaternion.conjugate(product))
        slope = back @ jacobian(part) * shares[:, j, None, None]
        slopes[:, :, j + 1] += slope @ inverse[local[:, j]]
        slopes[:, :, j] -= slope @ np.swapaxes(inverse[local[:, j]], 1, 2)
        product = quaternion.multiply(quaternion.exp(part), product)
    slopes[:, :, 0] += quaternion.to_matrix(quaternion.conjugate(product))
    at = quaternion.multiply(controls[alive[:, 0]], product)
    misses = quaternion.log(quaternion.multiply(quaternion.conjugate(quats), at))
    return misses, np.einsum("mab,mbjc->majc", inverse_jacobian(misses), slopes)


def _normal_step(
    misses: FloatArray, slopes: FloatArray, first: basis.IndexArray, count: int
) -> FloatArray:
    """Give the step of the least squared misses by the normal equations, shape (3 count,)."""
    width = slopes.shape[2]
    band = np.zeros((count, 3, 2 * width - 1, 3))
    right = np.zeros((count, 3))
    for i in range(width):
        np.add.at(right, first + i, np.einsum("mab,ma->mb", slopes[:, :, i], misses))
        for j in range(width):
            block = np.einsum("mab,mac->mbc", slopes[:, :, i], slopes[:, :, j])
            np.add.at(band[:, :, j - i + width - 1], first + i, block)
    rows = np.repeat(3 * (np.arange(count) - width + 1), 3)
    solved = banded.solve(rows, band.reshape(3 * count, -1), right.reshape(-1, 1))
    return solved[:, 0]
