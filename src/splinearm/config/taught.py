"""Taught motions in files: the keys of a piece of a job that was led by hand.

The keys of such a ``[[piece]]``::

    degree        of the B-spline
    knots         of the B-spline: the time in which the joints moved, from 0, in s
    points_deg    its control points, each one number a joint; points_deg_mm with sliding joints
    rest_u        where the hand paused, by the time of the knots (none: left out)
    rest_s        for how long
    fitted        in words how near to the recording it is; for people only
"""

from collections.abc import Sequence

from splinearm.arrays import FloatArray
from splinearm.joints import JointKind, JointLimits
from splinearm.trajectories.taught import TaughtMotion

from .reader import Table
from .unit import positions_key, to_file_units

LONGEST = 3600.0
"""A piece lasts no longer, s: it is looked at whole before anything moves."""

TAUGHT_KEY = "knots"
"""The key by which such a piece is known."""

DECIMALS = 4
"""So many decimals degrees, millimetres and seconds have in a file: 0.2 micrometres at 0.1 m."""


def read_taught(table: Table, limits: JointLimits) -> TaughtMotion:
    """Read a taught motion from the table of a piece; ``table.finish()`` is left to the caller.

    Args:
        table: The table.
        limits: The joints that it is for.

    Raises:
        ConfigError: With the key that is not right.
    """
    degree = table.integer("degree", low=1, high=7)
    knots = table.every_number("knots")
    points = table.every_position("points", limits.names, limits.kinds)
    rests: tuple[tuple[float, float], ...] = ()
    if "rest_u" in table or "rest_s" in table:
        u, seconds = table.every_number("rest_u"), table.every_number("rest_s")
        if len(u) != len(seconds):
            raise table.refuse("rest_s", f"wants a number for each of {len(u)} rest_u")
        rests = tuple(zip(u.tolist(), seconds.tolist(), strict=True))
    with table.blaming(TAUGHT_KEY):
        taught = TaughtMotion(
            names=limits.names,
            degree=degree,
            knots=knots,
            points=points,
            rests=rests,
            words=table.text("fitted", ""),
        )
    if taught.duration > LONGEST:
        raise table.refuse(
            TAUGHT_KEY, f"with its rests it lasts {taught.duration:.4g} s; want at most {LONGEST:g}"
        )
    return taught


def taught_text(taught: TaughtMotion, kinds: Sequence[JointKind]) -> str:
    """Give the lines of a taught motion in the table of a piece, ready to be read again.

    Args:
        taught: The motion.
        kinds: How its joints move.
    """
    lines = [f"degree = {taught.degree}", f"knots = {numbers_text(taught.knots)}"]
    if taught.words:
        lines.insert(0, f'fitted = "{taught.words}"')
    lines.append(f"{positions_key('points', kinds)} = [")
    lines += [f"    {numbers_text(row)}," for row in to_file_units(taught.points, kinds)]
    lines.append("]")
    if taught.rests:
        u, seconds = zip(*taught.rests, strict=True)
        lines += [f"rest_u = {numbers_text(u)}", f"rest_s = {numbers_text(seconds)}"]
    return "\n".join(lines) + "\n"


def numbers_text(values: Sequence[float] | FloatArray) -> str:
    """Give numbers as TOML has them, with no more digits than they need to come back."""
    return f"[{', '.join(_number(float(value)) for value in values)}]"


def _number(value: float) -> str:
    short = round(value, DECIMALS) + 0.0
    # radians from rounded degrees come back as degrees with rounding in the 15th digit
    return repr(short if abs(value - short) <= 1e-12 * max(1.0, abs(value)) else value)
