"""The shortest way to rest along a path, from any moment of a time law."""

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointLimits

from . import constraint, reachability
from .constraint import Rows
from .joint_path import JointPath
from .pace import Envelope, slow_down_from
from .paced_law import PacedLaw
from .section import Law, Section
from .time_law import TimeLaw, split_cells

_CELLS = 60
"""Into about so many cells the way to rest is divided."""

_AHEAD = 40
"""How many cells are prepared at a time."""

_SHORT = 1e-3
"""A cell that has begun is left to the law under way if less than this share of it is left."""

_REST = 1e-12
"""Below this share of the highest speed the motion is at rest."""

_QUARTERINGS = 12
_HALVINGS = 5
"""How far and how finely the place in the last cell is sought where the motion ends."""


Envelopes = dict[int, Envelope]
"""What motions ask of their joints, by the identity of their sections."""


def law_to_rest(section: Section, limits: JointLimits, t: float, known: Envelopes) -> Law:
    """Give the law that leaves a section's own at a time and comes to rest along its path.

    Args:
        section: The section; it ends at rest.
        limits: What the joints may do.
        t: When it is left, from 0 to the end of its law, s.
        known: What earlier calls have found of sections, by identity; is added to.
    """
    law = section.law
    if limits.qddd_max is None and isinstance(law, TimeLaw):
        s, speed, _ = law.at(t)
        return brake(section.path, limits, law, s, speed)
    if id(section) not in known:
        known[id(section)] = Envelope.of(section, section.nodes(), (0.0, law.duration), limits)
    pace = slow_down_from(known[id(section)], t)
    if pace.t[-1] >= law.duration - t:
        return law.between(t, law.duration)
    return PacedLaw(law, pace)


def brake(path: JointPath, limits: JointLimits, law: TimeLaw, s: float, speed: float) -> TimeLaw:
    """Give the law that slows down along the path as hard as the joints' accelerations allow.

    At every place it is at most as fast as the law it leaves, so no velocity is exceeded, it ends
    where that one ends at the latest, and there is always a way on: a slower copy of that law.

    Args:
        path: The way of the joints.
        limits: What the joints may do.
        law: The law under way; it ends at rest.
        s: Where the motion is, and
        speed: its ds/dt there, as that law has them at one time.
    """
    if speed <= _REST * law.speed.max() or s >= law.s[-1]:
        return TimeLaw(np.array([s]), np.zeros(1))
    grid, planned = _grid(path, limits, law, s, speed * speed)
    squares = [speed * speed]
    i = 1 if len(grid) > 2 and _is_short(law, s) else 0
    squares += planned[1 : i + 1].tolist()
    first, rows = i, _rows_from(path, limits, grid, i)
    while i + 2 < len(grid):
        if i - first == len(rows.a):
            first, rows = i, _rows_from(path, limits, grid, i)
        x = squares[i]
        least = reachability.lowest_behind(rows.a[i - first], rows.b[i - first], x)
        if least <= 0.0:
            break
        # rounding aside, the law under way scaled down to x never demands less
        squares.append(min(least, float(planned[i + 1]) * x / float(planned[i])))
        i += 1
    end = _end_within(path, limits, float(grid[i]), float(grid[i + 1]), squares[i])
    hard = TimeLaw(np.append(grid[: i + 1], end), np.append(squares, 0.0))
    return min(hard, _rest_of(law, s, speed * speed), key=lambda one: one.duration)


def _rows_from(path: JointPath, limits: JointLimits, grid: FloatArray, i: int) -> Rows:
    """Give the inequalities of the next cells."""
    return constraint.acceleration_rows(path, limits, grid[i : i + _AHEAD + 1])


def _rest_of(law: TimeLaw, s: float, x: float) -> TimeLaw:
    """Give what is left of a law; near its end that may be sooner at rest."""
    ahead = law.s > s
    return TimeLaw(np.append(s, law.s[ahead]), np.append(x, law.x[ahead]))


def _is_short(law: TimeLaw, s: float) -> bool:
    cell = int(np.searchsorted(law.s, s, side="right"))
    return bool(law.s[cell] - s < _SHORT * (law.s[cell] - law.s[cell - 1]))


def _grid(
    path: JointPath, limits: JointLimits, law: TimeLaw, s: float, x: float
) -> tuple[FloatArray, FloatArray]:
    """Give nodes from s on, all of the law's and more, and the law's x there."""
    slope = path.at(s)[1]
    hardest = 1.0 / max(float((np.abs(slope) / limits.qdd_max).max()), 1e-300)
    longest = max(x / (2.0 * hardest) / _CELLS, float(law.s[-1] - s) / 2000.0)
    edges = np.concatenate(([s], law.s[law.s > s]))
    counts = np.maximum(1, np.ceil(np.diff(edges) / longest)).astype(np.intp)
    if _is_short(law, s):
        counts[0] = 1
    grid = split_cells(edges, counts)
    planned = np.interp(grid, law.s, law.x)
    planned[0] = x
    return grid, planned


def _end_within(path: JointPath, limits: JointLimits, s: float, end: float, x: float) -> float:
    """Give a place of a cell where the motion can have come to rest, nearly the first."""

    def can_rest_at(place: float) -> bool:
        rows = constraint.acceleration_rows(path, limits, np.array([s, place]))
        return bool((rows.a * x).max() <= 1.0)

    low = s
    for _ in range(_QUARTERINGS):
        nearer = s + 0.25 * (end - s)
        if not can_rest_at(nearer):
            low = nearer
            break
        end = nearer
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + end)
        if can_rest_at(middle):
            end = middle
        else:
            low = middle
    return end
