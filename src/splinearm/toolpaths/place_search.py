"""Where work may lie so that an arm can follow its whole toolpath."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import ToolpathError
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.structure import ArmClass

from .action import Action, ArcFeed, Feed, Rapid, SplineFeed
from .placing import question_of
from .setting import Setting, class_of
from .summary import summarise
from .turn_search import search_turns, solver_of
from .unplaced import coarsely

_PLACES = 100
"""So many places of the toolpath are looked at."""

_FAR = (0.6, 0.5, 0.7, 0.4, 0.8, 0.3, 0.9)
"""Distances of the work's middle from the arm that are tried, as shares of its reach ..."""

_HIGH = (0.1, 0.2, 0.0, 0.3, 0.4, 0.5)
"""... and heights of the work's zero above the arm's base, likewise."""

_TURNED = (0.0, 0.5 * np.pi, -0.5 * np.pi, np.pi)
"""Turns of the work about its upright that are tried, rad."""


def find_place(
    actions: Sequence[Action], setting: Setting, arm: Arm, q_near: FloatArray
) -> Setting:
    """Give where level work may lie ahead of an arm, in the order of what suits arms.

    Args:
        actions: What is done, in coordinates of the work.
        setting: How the tool points; its place is not looked at.
        arm: The arm.
        q_near: Where the arm stands, shape (n,); it says what is ahead.

    Raises:
        ToolpathError: If none of the places that are tried will do.
        KinematicsError: If the arm has no closed form.
        ValueError: If nothing moves the tool.
    """
    moves = [a for a in actions if isinstance(a, Rapid | Feed | ArcFeed | SplineFeed)]
    summary = summarise(moves)
    solve = solver_of(arm, q_near)
    middle = 0.5 * (summary.low + summary.high)
    middle[2] = 0.0
    for T in _candidates(arm, middle, q_near):
        tried = replace(setting, T_base_work=T)
        question = coarsely(question_of(actions, tried, arm, q_near), _PLACES)
        if len(search_turns(arm, question, q_near, solve).q) == len(question.p):
            return tried
    size = (summary.high - summary.low) * 1e3
    raise ToolpathError(
        f"no place ahead of arm {arm.name!r} was found for work of {size[0]:.0f} x {size[1]:.0f} x "
        f"{size[2]:.0f} mm: it is too large, or the tool must point otherwise"
    )


def _candidates(arm: Arm, middle: FloatArray, q_near: FloatArray) -> Iterator[FloatArray]:
    """Give poses of the work with its middle ahead of the arm."""
    T = arm.fk(q_near)
    azimuth = float(np.arctan2(T[1, 3], T[0, 3]))
    reach = _reach(arm)
    heights = (0.0,) if class_of(arm) is ArmClass.PLANAR else _HIGH
    for turned in _TURNED:
        for far in _FAR:
            for high in heights:
                c, s = np.cos(azimuth + turned), np.sin(azimuth + turned)
                pose = np.eye(4)
                pose[:2, :2] = [[c, -s], [s, c]]
                centre = far * reach * np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
                pose[:3, 3] = centre - pose[:3, :3] @ middle
                pose[2, 3] = high * reach
                yield pose


def _reach(arm: Arm) -> float:
    """Give how far the tool gets from the first axis at the most, about, m."""
    q = np.random.default_rng(1).uniform(
        np.maximum(arm.limits.q_min, -np.pi), np.minimum(arm.limits.q_max, np.pi), (500, arm.n)
    )
    return float(np.linalg.norm(arm.fk(q)[:, :2, 3], axis=1).max())
