"""How long a toolpath takes on a machine with limits of acceleration and jerk."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import inf, pi, sin, sqrt

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.trajectories.point_to_point import ROWS, compiled_motion

from .action import Action, ArcFeed, Cutting, Dwell, Moving, SplineFeed


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """What moves a machine."""

    rapid: float = 3.0 / 60.0
    """How fast rapid ways are, m/s."""
    acceleration: float = 0.5
    """Highest acceleration along the way and across it, m/s2."""
    jerk: float = 10.0
    """Highest jerk along the way, m/s3."""
    junction: float = 1e-5
    """By how much a corner may be rounded, m; 0: it stops in every corner."""

    def __post_init__(self) -> None:
        for name in ("rapid", "acceleration", "jerk"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0.0):
                raise ValueError(f"{name}: want above zero, got {getattr(self, name)}")
        if not (np.isfinite(self.junction) and self.junction >= 0.0):
            raise ValueError(f"junction: want zero or more, got {self.junction}")


@dataclass(frozen=True, slots=True, eq=False)
class _Block:
    """A way with one highest speed."""

    length: float
    speed: float
    enter: FloatArray
    """The direction at its begin, shape (3,)."""
    leave: FloatArray


def estimate(actions: Iterable[Action], drive: Drive | None = None) -> float:
    """Give how long a toolpath takes, s, tool changes left out.

    Each way is run through at its feed, less where an arc is too tight for the acceleration, with
    speeds in corners by how far they may be rounded, and from speed to speed within acceleration
    and jerk. The acceleration is zero where ways meet that differ in feed or direction, so that a
    controller which looks at several ways at once may be somewhat quicker.

    Args:
        actions: What the machine does.
        drive: What moves it; None: a small router.
    """
    drive = drive or Drive()
    total = 0.0
    blocks: list[_Block] = []
    for action in actions:
        if isinstance(action, Moving):
            block = _block(action, drive)
            if block is not None:
                blocks.append(block)
            continue
        total += _time(blocks, drive)
        blocks = []
        if isinstance(action, Dwell):
            total += action.time
    return total + _time(blocks, drive)


def _block(move: Moving, drive: Drive) -> _Block | None:
    length = move.length
    if not length > 0.0:
        return None
    if isinstance(move, Cutting):
        speed = length / move.time if move.time else float(move.feed or inf)
    else:
        speed = drive.rapid
    if isinstance(move, ArcFeed):
        x = np.array([0.0, 1e-4, 1.0 - 1e-4, 1.0])
        places = move.at(x)
        radius = max(move.radius_at_start, 1e-9)
        speed = min(speed, sqrt(drive.acceleration * radius))
        enter, leave = _unit(places[1] - places[0]), _unit(places[3] - places[2])
    elif isinstance(move, SplineFeed):
        first, last = move.curve.domain
        velocity = move.curve.at(np.array([first, last]), 1)
        enter, leave = _unit(velocity[0]), _unit(velocity[1])
        u = np.linspace(first, last, 65)
        d1, d2 = move.curve.at(u, 1), move.curve.at(u, 2)
        bend = np.linalg.norm(np.cross(d1, d2), axis=1) / np.linalg.norm(d1, axis=1) ** 3
        speed = min(speed, sqrt(drive.acceleration / max(float(bend.max()), 1e-9)))
    else:
        enter = leave = _unit(move.end - move.start)
    return _Block(length, speed, enter, leave)


def _unit(way: FloatArray) -> FloatArray:
    unit: FloatArray = way / max(float(np.linalg.norm(way)), 1e-300)
    return unit


def _time(blocks: Sequence[_Block], drive: Drive) -> float:
    """Give the time of blocks that begin and end at rest."""
    if not blocks:
        return 0.0
    merged: list[list[float]] = []
    corners = [0.0]
    last: _Block | None = None
    for block in blocks:
        if last is not None:
            cosine = float(np.clip(last.leave @ block.enter, -1.0, 1.0))
            if cosine > 1.0 - 1e-6 and block.speed == last.speed:
                merged[-1][0] += block.length
                last = block
                continue
            corners.append(min(_corner_speed(cosine, drive), block.speed, last.speed))
        merged.append([block.length, block.speed])
        last = block
    corners.append(0.0)
    for k in range(len(merged)):
        corners[k + 1] = min(corners[k + 1], _reached(corners[k], merged[k][0], drive))
    for k in range(len(merged) - 1, -1, -1):
        corners[k] = min(corners[k], _reached(corners[k + 1], merged[k][0], drive))
    return sum(
        _duration(length, corners[k], corners[k + 1], speed, drive)
        for k, (length, speed) in enumerate(merged)
    )


def _corner_speed(cosine: float, drive: Drive) -> float:
    """Give how fast a corner may be passed (the junction deviation of GRBL, S. K. Jeon 2011)."""
    if cosine > 1.0 - 1e-6:
        return inf
    half = sin(0.5 * (pi - float(np.arccos(cosine))))  # of the angle between both ways
    if half >= 1.0 - 1e-12:
        return inf
    return sqrt(drive.acceleration * drive.junction * half / (1.0 - half))


def _change(v: float, w: float, drive: Drive) -> tuple[float, float]:
    """Give time and length of a change of speed, with no acceleration before and behind it."""
    a, j, dv = drive.acceleration, drive.jerk, abs(w - v)
    time = dv / a + a / j if dv >= a * a / j else 2.0 * sqrt(dv / j)
    return time, 0.5 * (v + w) * time


def _reached(v: float, length: float, drive: Drive) -> float:
    """Give the highest speed that can be reached from another within a length."""
    a, j = drive.acceleration, drive.jerk
    bend = a * a / j
    # with an acceleration that reaches its limit the length is quadratic in the speed
    square = 0.25 * bend * bend + v * v - v * bend + 2.0 * a * length
    if square > 0.0:
        w = sqrt(square) - 0.5 * bend
        if w - v >= bend:
            return float(w)
    # else a cubic of x = sqrt((w - v) / j), by Newton's method from above: it is convex
    x = min(length / (2.0 * v) if v > 0.0 else inf, (length / j) ** (1.0 / 3.0))
    for _ in range(60):
        step = ((j * x * x + 2.0 * v) * x - length) / (3.0 * j * x * x + 2.0 * v)
        x -= step
        if abs(step) <= 1e-15 * x:
            break
    return float(v + j * x * x)


def _duration(length: float, v: float, w: float, top: float, drive: Drive) -> float:
    """Give the least time for a length from speed to speed, up to a highest one between."""
    top = max(top, v, w)
    (up, rise), (down, fall) = _change(v, top, drive), _change(top, w, drive)
    if rise + fall <= length:
        return up + down + (length - rise - fall) / top
    phases, report = np.zeros((1, ROWS, 5)), np.zeros(2)
    compiled_motion()(
        np.array([[0.0, v, 0.0]]),
        np.array([[length, w, 0.0]]),
        np.array([[top, drive.acceleration, drive.jerk]]),
        np.array([np.nan, 1.0]),
        phases,
        report,
    )
    return float(report[0])
