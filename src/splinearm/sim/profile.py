"""Profiles: how a servo brings its trajectory from where it is to a goal.

Units are the caller's: here ticks and seconds. Source: ROBOTIS e-Manual, "What is the Profile".
"""

from dataclasses import dataclass
from enum import IntEnum
from math import copysign, sqrt


class ProfileKind(IntEnum):
    """Shape of a profile's velocity, as in bits 4 and 5 of Moving Status."""

    STEP = 0
    RECTANGULAR = 1
    TRIANGULAR = 2
    TRAPEZOIDAL = 3


@dataclass(frozen=True, slots=True)
class Phase:
    """A time of constant acceleration."""

    duration: float
    position: float
    velocity: float
    acceleration: float

    def at(self, t: float) -> tuple[float, float, float]:
        """Give position, velocity and acceleration ``t`` after its begin."""
        return (
            self.position + (self.velocity + 0.5 * self.acceleration * t) * t,
            self.velocity + self.acceleration * t,
            self.acceleration,
        )


@dataclass(frozen=True, slots=True)
class Profile:
    """A way to a goal, phase by phase; it rests at the goal after the last."""

    goal: float
    """Where it ends."""
    kind: ProfileKind
    """Its shape."""
    phases: tuple[Phase, ...] = ()
    """What it does on the way."""

    @property
    def duration(self) -> float:
        """Time it takes."""
        return sum(phase.duration for phase in self.phases)

    def at(self, t: float) -> tuple[float, float, float]:
        """Give position, velocity and acceleration at a time since its begin."""
        for phase in self.phases:
            if t < phase.duration:
                return phase.at(t)
            t -= phase.duration
        return self.goal, 0.0, 0.0


def step(goal: float) -> Profile:
    """Give the profile that is at its goal at once."""
    return Profile(goal, ProfileKind.STEP)


def by_velocity(
    start: float, velocity: float, goal: float, top_velocity: float, acceleration: float
) -> Profile:
    """Give the profile of a top velocity and an acceleration, from a state of motion.

    Args:
        start: Where it begins.
        velocity: How fast it begins; without acceleration that is forgotten.
        goal: Where it ends, at rest.
        top_velocity: Above zero.
        acceleration: At least zero; zero: the velocity jumps (a rectangular profile).
    """
    if acceleration == 0.0:
        speed = copysign(top_velocity, goal - start)
        duration = abs(goal - start) / top_velocity
        return Profile(goal, ProfileKind.RECTANGULAR, (Phase(duration, start, speed, 0.0),))
    # time-optimal motion of a double integrator: towards where braking at once would not stop
    way = goal - start - velocity * abs(velocity) / (2.0 * acceleration)
    sign = copysign(1.0, way)
    peak = min(top_velocity, sqrt(acceleration * sign * (goal - start) + velocity**2 / 2.0))
    kind = ProfileKind.TRAPEZOIDAL if peak == top_velocity else ProfileKind.TRIANGULAR
    return _three_phases(start, velocity, goal, sign * peak, acceleration, kind)


def by_time(
    start: float, velocity: float, goal: float, total_time: float, ramp_time: float
) -> Profile:
    """Give the profile that takes a given time, with ramps of a given time at both ends.

    Args:
        start: Where it begins.
        velocity: How fast it begins.
        goal: Where it ends, at rest.
        total_time: Above zero.
        ramp_time: At least zero, at most half the total; zero: the velocity jumps.
    """
    ramp = min(ramp_time, total_time / 2.0)
    if ramp == 0.0:
        speed = (goal - start) / total_time
        return Profile(goal, ProfileKind.RECTANGULAR, (Phase(total_time, start, speed, 0.0),))
    cruise = (goal - start - velocity * ramp / 2.0) / (total_time - ramp)
    rise = Phase(ramp, start, velocity, (cruise - velocity) / ramp)
    level = Phase(total_time - 2.0 * ramp, rise.at(ramp)[0], cruise, 0.0)
    fall = Phase(ramp, level.at(level.duration)[0], cruise, -cruise / ramp)
    kind = ProfileKind.TRAPEZOIDAL if level.duration > 0.0 else ProfileKind.TRIANGULAR
    return Profile(goal, kind, (rise, level, fall))


def _three_phases(
    start: float, velocity: float, goal: float, peak: float, acceleration: float, kind: ProfileKind
) -> Profile:
    """Give the profile that comes to a peak velocity, keeps it, and brakes to rest at the goal."""
    rise_time = abs(peak - velocity) / acceleration
    rise = Phase(rise_time, start, velocity, copysign(acceleration, peak - velocity))
    fall_time = abs(peak) / acceleration
    p_fall = goal - peak * fall_time / 2.0
    p_level = rise.at(rise_time)[0]
    level_time = max((p_fall - p_level) / peak, 0.0) if peak != 0.0 else 0.0
    level = Phase(level_time, p_level, peak, 0.0)
    fall = Phase(fall_time, p_fall, peak, -copysign(acceleration, peak))
    return Profile(goal, kind, (rise, level, fall))
