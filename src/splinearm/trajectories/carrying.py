"""Orientations carried along a way from node to node, in steps of fourth order."""

from collections.abc import Callable

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.curves.basis import IndexArray
from splinearm.errors import CurveError
from splinearm.kinematics import quaternion

_MOST_NODES = 200_000

_GAUSS = 0.5 - np.sqrt(3.0) / 6.0, 0.5 + np.sqrt(3.0) / 6.0

Field = Callable[[FloatArray], FloatArray]
"""What gives vectors, shape (m, 3), at parameters, shape (m,)."""


def nodes_of(breaks: FloatArray, direction: Field, largest: float, least: int) -> FloatArray:
    """Give nodes between which a direction turns little; refuse one that turns on the spot.

    Args:
        breaks: Ends of the smooth pieces.
        direction: Gives unit vectors.
        largest: How far it may turn from node to node, rad.
        least: The fewest steps of a smooth piece.

    Raises:
        CurveError: If it turns however near the nodes are, with where.
    """
    nodes = np.unique(np.linspace(breaks[:-1], breaks[1:], least + 1, axis=1))
    while True:
        sharp = np.linalg.norm(np.diff(direction(nodes), axis=0), axis=1) > largest
        if not sharp.any():
            return nodes
        middles = 0.5 * (nodes[:-1] + nodes[1:])[sharp]
        if np.isin(middles, nodes).any() or len(nodes) > _MOST_NODES:
            raise no_direction("the tool would have to turn on the spot there", middles[0])
        nodes = np.sort(np.concatenate((nodes, middles)))


def node_before(nodes: FloatArray, u: FloatArray) -> IndexArray:
    """Give the nodes from which steps lead to parameters, shape (m,)."""
    before: IndexArray = np.clip(np.searchsorted(nodes, u, side="right") - 1, 0, len(nodes) - 2)
    return before


def steps(omega: Field, start: FloatArray, h: FloatArray) -> FloatArray:
    """Give the turns from parameters on by steps h, both (m,), as unit quaternions, shape (m, 4).

    Args:
        omega: Gives angular velocities in the fixed frame, rad per unit of the parameter.
        start: Where the steps begin.
        h: How far they lead.
    """
    # Magnus expansion of fourth order on two Gauss points (Iserles et al., Lie-group methods,
    # Acta Numerica 9, 2000, sec. 5)
    first, second = (omega(start + share * h) for share in _GAUSS)
    width = h[:, None]
    turn = 0.5 * width * (first + second)
    turn += np.sqrt(3.0) / 12.0 * width**2 * np.cross(second, first)
    return quaternion.exp(turn)


def no_direction(what: str, where: float) -> CurveError:
    """Give the error of a way that has no direction for a tool somewhere."""
    return CurveError(what, f"s = {where:g}")
