"""The control loop inside a servo: goals in, duty of the motor out, once a millisecond.

Gains are scaled as the manual says and act on ticks and milliseconds, giving PWM units. In mode 5
they give units of Goal Current: the controller calculates a target current, Goal Current limits it,
and a current controller makes the PWM of it, so that the motor's own voltage brakes nothing. That
the loop runs at 1 kHz and that D acts on the trajectory's velocity less the measured one are
assumptions: the manual is silent. The stiffness that follows for an XM430-W350 at its default P
gain, 18.9 N m/rad, agrees with the 21.1 N m/rad of the MuJoCo Menagerie model of ROBOTIS OP3.
Source: ROBOTIS e-Manual, "Position PID Gain", "Velocity PI Gain", "Current-based Position Control".
"""

from dataclasses import dataclass
from math import inf

from .brake import Brake
from .compliance import Compliance
from .mode import POSITION_MODES as POSITION_MODES
from .mode import Mode as Mode
from .profile import Profile, ProfileKind, by_time, by_velocity, step
from .shaft import TIMESTEP

_MS = TIMESTEP / 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class LawSettings:
    """What the registers of a servo say about its control loop, in ticks, seconds and amperes."""

    mode: int
    """Operating mode."""
    p: float
    """PWM units a tick of position error."""
    i: float
    """PWM units a tick and millisecond."""
    d: float
    """PWM units a tick in a millisecond of velocity error."""
    ff1: float
    """PWM units a tick in a millisecond of the trajectory's velocity."""
    ff2: float
    """PWM units a tick in a millisecond squared of the trajectory's acceleration."""
    vp: float
    """PWM units a unit of velocity error."""
    vi: float
    """PWM units a unit of velocity error and millisecond."""
    velocity_unit: float
    """A unit of velocity, ticks/s."""
    full_pwm: float
    """PWM units of full duty."""
    duty_limit: float
    """Highest duty, 0..1."""
    current_limit: float
    """Highest current in mode 5, A; infinite: not limited."""
    top_velocity: float
    """Profile velocity, ticks/s; 0: no profile. Time-based: total time, s."""
    acceleration: float
    """Profile acceleration, ticks/s2; 0: none. Time-based: time of a ramp, s."""
    time_based: bool
    """Whether the profile is given by its times."""
    current_unit: float = 1.0
    """A unit of the current that the position's controller asks for in mode 5, A."""
    slew: float = inf
    """Most by which the duty may change in a millisecond."""
    compliance: Compliance | None = None
    """What takes the place of the gains in servos that have none."""


class ServoLaw:
    """The loop and its state. Positions and speeds are those of the servo's registers."""

    def __init__(self, settings: LawSettings, no_load_speed: float, stall_current: float) -> None:
        """Begin at rest.

        Args:
            settings: What the registers say.
            no_load_speed: Of the motor, ticks/s.
            stall_current: Of the motor, A.
        """
        self.settings = settings
        self.goal_velocity = 0.0
        """Goal of mode 1, ticks/s."""
        self.goal_current = 0.0
        """Goal of mode 0, A."""
        self.goal_duty = 0.0
        """Goal of mode 16, -1..1."""
        self.position = 0.0
        """Where the trajectory is, ticks."""
        self.velocity = 0.0
        """How fast the trajectory moves, ticks/s."""
        self._acceleration = 0.0
        self._no_load = no_load_speed
        self.stall_current = stall_current
        """Current of the motor at standstill, full duty and nominal supply, A."""
        self.strength = 1.0
        """The supply as a share of the nominal one; above 0."""
        self._profile: Profile = step(0.0)
        self._since = 0.0
        self._ends = 0.0
        self._sum = 0.0
        self._winding = False
        self._duty = 0.0
        self._speed = 0.0
        self._brake: Brake | None = None

    @property
    def profile_kind(self) -> ProfileKind:
        """Shape of the newest profile."""
        return self._profile.kind

    @property
    def profile_ongoing(self) -> bool:
        """Whether the trajectory is still on its way to the goal."""
        return self._since < self._ends

    @property
    def busy(self) -> bool:
        """Whether it will do something new by itself: move its trajectory, or sum up an error."""
        return self.profile_ongoing or self._winding or self.braking

    def rest_at(self, position: float) -> None:
        """Begin, or stop: let the trajectory rest at ``position`` and forget what was summed up."""
        self.position, self.velocity, self._acceleration = position, 0.0, 0.0
        self._profile, self._since, self._ends = step(position), 0.0, 0.0
        self._sum = 0.0
        self._winding = False
        self._brake = None

    def release(self, position: float) -> None:
        """Let go: no output from here on, and none to slew from."""
        self.rest_at(position)
        self._duty = 0.0

    @property
    def braking(self) -> bool:
        """Whether it is still coming to rest."""
        return self._brake is not None and not self._brake.done

    def go_on(self) -> None:
        """End braking, for there is a new goal."""
        self._brake = None

    def brake(self, speed: float) -> None:
        """Brake from a speed (ticks/s) as hard as the PWM limit allows, and hold where it ends."""
        share = speed / self._no_load
        self.goal_velocity = self.goal_current = self.goal_duty = 0.0
        change = share - self._speed / self._no_load
        self._brake = Brake(self._duty * self.strength - share, change, self.settings.slew)

    def aim_at(self, goal: float) -> None:
        """Begin a profile from the trajectory's present state to a goal, ticks."""
        s = self.settings
        if s.top_velocity == 0.0:
            profile = step(goal)
        elif s.time_based:
            profile = by_time(self.position, self.velocity, goal, s.top_velocity, s.acceleration)
        else:
            profile = by_velocity(
                self.position, self.velocity, goal, s.top_velocity, s.acceleration
            )
        self._profile, self._since, self._ends = profile, 0.0, profile.duration

    def current(self, duty: float, speed: float) -> float:
        """Give the motor's current at a duty and a speed (ticks/s), A."""
        return self.stall_current * (duty * self.strength - speed / self._no_load)

    def tick(self, position: float, speed: float) -> float:
        """Let ``TIMESTEP`` go by and give the duty.

        Args:
            position: Where the servo is, ticks.
            speed: How fast it turns, ticks/s.
        """
        s = self.settings
        if self._brake is not None:
            duty = self._braked(self._brake, position, speed)
        elif s.mode in POSITION_MODES:
            output = self._follow(position, speed)
            if s.mode == Mode.CURRENT_POSITION:
                duty = self._driven_by(output * s.current_unit, speed)
            else:
                duty = output / s.full_pwm
        elif s.mode == Mode.VELOCITY:
            duty = self._turn(speed) / s.full_pwm
        elif s.mode == Mode.CURRENT:
            duty = self._driven_by(self.goal_current, speed)
        else:
            duty = self.goal_duty
        if s.slew < inf:
            duty = min(max(duty, self._duty - s.slew), self._duty + s.slew)
        self._speed = speed
        self._duty = duty = min(max(duty, -s.duty_limit), s.duty_limit)
        return duty

    def _driven_by(self, current: float, speed: float) -> float:
        """Give the duty at which a current flows, A, as far as the limit of mode 5 lets it."""
        most = self.settings.current_limit
        wanted = min(max(current, -most), most) / self.stall_current + speed / self._no_load
        return wanted / self.strength

    def _braked(self, brake: Brake, position: float, speed: float) -> float:
        """Give the duty that brings the servo to rest; at rest, go on by the law of its mode."""
        limit = self.settings.duty_limit * self.strength
        wanted = brake.tick(speed / self._no_load, self._duty * self.strength, limit)
        if brake.done:
            self._hold(position, brake.carried / self.strength)
        return wanted / self.strength

    def _hold(self, position: float, carried: float) -> None:
        """Let the goals of the mode be those that keep an output.

        Modes that feed nothing back, current and PWM, would drift; they go on braking.
        """
        s = self.settings
        if s.mode in POSITION_MODES and s.p > 0.0:
            amps = carried * self.strength * self.stall_current
            five = s.mode == Mode.CURRENT_POSITION
            output = amps / s.current_unit if five else carried * s.full_pwm
            self.rest_at(position + output / s.p)
        elif s.mode == Mode.VELOCITY and s.vi > 0.0:
            self.rest_at(position)
            self._sum = carried * s.full_pwm / s.vi

    def _follow(self, position: float, speed: float) -> float:
        """Give the PWM that brings the servo to its trajectory."""
        s = self.settings
        if self._since < self._ends or self.velocity != 0.0 or self.position != self._profile.goal:
            self._since += TIMESTEP
            self.position, self.velocity, self._acceleration = self._profile.at(self._since)
        error = self.position - position
        if s.compliance is not None:
            return s.compliance.pwm(error)
        self._sum_up(error, s.i, 1.0)
        return (
            s.p * error
            + s.i * self._sum
            + s.d * (self.velocity - speed) * 1e-3
            + s.ff1 * self.velocity * 1e-3
            + s.ff2 * self._acceleration * 1e-6
        )

    def _turn(self, speed: float) -> float:
        """Give the PWM that brings the servo to its goal velocity."""
        s = self.settings
        self.velocity = self._ramped()
        error = (self.velocity - speed) / s.velocity_unit
        self._sum_up(error, s.vi, 0.5)
        return s.vp * error + s.vi * self._sum

    def _sum_up(self, error: float, gain: float, resolution: float) -> None:
        """Add an error to the sum, as far as the sum can still drive the motor harder."""
        if gain == 0.0:
            return
        most = self.settings.full_pwm / gain
        before = self._sum
        self._sum = min(max(before + error * _MS, -most), most)
        self._winding = abs(error) > resolution and self._sum != before

    def _ramped(self) -> float:
        """Give the velocity one step nearer to its goal, as fast as the profile allows.

        A time-based profile has no acceleration of its own in mode 1; there the velocity jumps.
        """
        s = self.settings
        if s.acceleration == 0.0 or s.time_based:
            return self.goal_velocity
        most = s.acceleration * TIMESTEP
        return self.velocity + min(max(self.goal_velocity - self.velocity, -most), most)
