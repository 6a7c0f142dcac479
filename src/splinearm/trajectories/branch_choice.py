"""In which configuration an arm has to begin if it shall follow ways of the tool."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import UnreachableError
from splinearm.joints import JointKind
from splinearm.kinematics import path_search, quaternion
from splinearm.kinematics.arm import Arm
from splinearm.units import DEG, MM

from .path import CartesianPath

_POSES = 128
"""Into how many steps a way of poses is cut at least, spread over its smooth pieces."""

_POSITIONS = 32
"""The same of positions: their orientation is free, and the search takes ten times as long."""

_LEAST = 4
"""The fewest steps of a smooth piece."""


class Choice(NamedTuple):
    """What a search for another configuration has found."""

    q: FloatArray | None
    """Joint positions at the start from which all ways can be followed, shape (n,), or None."""
    is_known: bool
    """Whether none means that there is none among those that were looked at."""


NONE = Choice(None, is_known=True)
"""No configuration that was looked at follows."""

UNKNOWN = Choice(None, is_known=False)
"""No search says whether one does."""


def choose(arm: Arm, paths: Sequence[CartesianPath], q_near: FloatArray | None = None) -> Choice:
    """Give from which joint positions an arm can follow ways of the tool.

    Of all configurations and whole turns that reach the start it is the one that follows to the
    end with the least way of the joints. Between the places that are looked at the tool goes
    straight, so that following the ways themselves has the last word.

    Args:
        arm: The arm.
        paths: The ways, each starting where the one before it ends.
        q_near: Joint positions from which the way to the start counts as well, shape (n,).

    Returns:
        The choice; unknown if some ways leave the orientation free and others do not, or a place
        cannot be reached in any configuration.
    """
    free = [path.orientation is None for path in paths]
    if any(free) and not all(free):
        return UNKNOWN
    places = np.concatenate([_places(path, first=i == 0) for i, path in enumerate(paths)])
    found = path_search.search_path(arm, places, q_near)
    if found.followed:
        return Choice(found.q[0], is_known=True)
    return UNKNOWN if found.status is path_search.PathStatus.UNREACHABLE else NONE


def explained(arm: Arm, error: UnreachableError, choice: Choice) -> UnreachableError:
    """Give the refusal of a way with what a start in another configuration would do."""
    if choice.q is not None:
        hint = (
            f"it can be followed if the arm starts in another configuration: {_said(arm, choice.q)}"
        )
    elif choice.is_known:
        hint = "no other configuration at the start was found that can follow either"
    else:
        return error
    return UnreachableError(
        error.position_error,
        error.orientation_error,
        error.joint,
        f"{error.reason}; {hint}",
        error.what,
    )


def _places(path: CartesianPath, *, first: bool) -> FloatArray:
    """Give places of a way as transforms, shape (m, 4, 4), or if free as positions, (m, 3)."""
    breaks = path.breaks
    whole = _POSITIONS if path.orientation is None else _POSES
    steps = max(_LEAST, -(-whole // (len(breaks) - 1)))
    shares = np.linspace(0.0, 1.0, steps + 1)[:-1]
    inner = breaks[:-1, None] + np.diff(breaks)[:, None] * shares
    state = path.state(np.append(inner.ravel(), breaks[-1])[0 if first else 1 :])
    if state.quat is None:
        return state.p
    T = np.zeros((len(state.p), 4, 4))
    T[:, :3, :3] = quaternion.to_matrix(state.quat)
    T[:, :3, 3] = state.p
    T[:, 3, 3] = 1.0
    return T


def _said(arm: Arm, q: FloatArray) -> str:
    """Say joint positions in the user's units."""
    words = []
    for name, kind, value in zip(arm.limits.names, arm.limits.kinds, q, strict=True):
        sliding = kind is JointKind.PRISMATIC
        words.append(f"{name} {value / MM:.4g} mm" if sliding else f"{name} {value / DEG:.4g} deg")
    return ", ".join(words)
