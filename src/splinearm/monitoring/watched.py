"""One servo that is watched: what it last said, and how well it answers."""

from dataclasses import replace
from math import exp, isnan, nan

from splinearm.doctor.chart import Chart, read_registers
from splinearm.doctor.finding import Finding
from splinearm.doctor.model_number import model_of
from splinearm.doctor.setting_check import other_model, unknown_model
from splinearm.doctor.stethoscope import Stethoscope
from splinearm.drivers.ability import HARDWARE_ERROR, voltage_register
from splinearm.drivers.bus import PingReply, Reply
from splinearm.drivers.health import MEMORY
from splinearm.drivers.health_limit import HealthLimits
from splinearm.drivers.model import ServoModel
from splinearm.drivers.packets import ALERT_BIT

from .block import (
    TEMPERATURE,
    TORQUE,
    VOLTAGE,
    Block,
    Motion,
    MotionBlock,
    slow_blocks,
    slow_values,
)
from .dial import Dial, Place
from .judgement import Evidence, judge
from .sample import ServoSample
from .tally import Tally

_MISSES, _SILENCE = 5, 0.25
"""How often in a row, and for how long, s, a servo may be lost before it counts as silent: this
computer, or the adapter, may pause for a moment too."""


class Watched:
    """One servo.

    Args:
        servo_id: Its id.
        place: What it is for.
        protocol: The protocol that it should speak, 1 or 2.
    """

    def __init__(self, servo_id: int, place: Place, protocol: int = 2) -> None:
        self.servo_id = servo_id
        self.place = place
        self.protocol = protocol
        spec = place.servo
        self.name = f"servo_{servo_id}" if spec is None else spec.name
        """What it is called."""
        self.model: ServoModel | None = None
        """Its model, as it says itself; None: not known yet, or not known here."""
        self.firmware = 0
        """Its firmware."""
        self.motion: MotionBlock | None = None
        """What is read of it in every cycle; None: nothing, as it has not answered yet."""
        self.slow: tuple[Block, ...] = ()
        """What is read of it now and then."""
        self.is_alone = False
        """Whether it answers single reads only."""
        self.tally = Tally()
        """How it has answered."""
        self.is_stale = False
        """Whether what changes slowly should be asked again soon."""
        self._limits = HealthLimits()
        self._values: dict[str, int] = {}
        self._dial: Dial | None = None
        self._seen = Motion(nan, nan, nan, nan, None)
        self._position = nan
        self._effort, self._effort_t = nan, nan
        self._misses = 0
        self._is_silent = True
        self._heard, self._heard_t = True, nan
        self._alert = False
        self._latched = 0
        self._other: Finding | None = None

    @property
    def is_present(self) -> bool:
        """Whether it is asked in every cycle."""
        return not self._is_silent

    def greet(self, bus: Stethoscope, reply: PingReply) -> None:
        """Take a servo in that answered a ping: read what is to be known of it.

        Raises:
            PortError: If the port is gone.
        """
        model, spec = model_of(reply.model_number), self.place.servo
        self._other = None if spec is None else other_model(spec, reply)
        if model is None:
            self._other = self._other or unknown_model(f"servo {self.servo_id}", reply)
            return
        self.firmware, self.protocol = reply.firmware, reply.protocol
        values = read_registers(bus, self.servo_id, model, None)
        if values is None:
            return
        try:
            self.motion = MotionBlock(model)
        except ValueError:  # no servo that turns
            return
        self.model, self.slow = model, slow_blocks(model)
        self._values = {}
        self._know(model, values)
        self._dial = None
        if not self._heard:  # it answers, but never in a group
            self.is_alone = True
        self._misses, self._is_silent = 0, False
        self._heard, self._heard_t, self._alert = False, nan, False
        self.tally.begin_anew()
        self.is_stale = True

    def take_motion(self, reply: Reply, t: float) -> None:
        """Take what came of its motion, or that nothing came; t on the monotonic clock, s."""
        self.tally.note(reply.loss)
        if isnan(self._heard_t):
            self._heard_t = t
        if reply.loss is not None or self.motion is None:
            self._misses += 1
            self._is_silent = self._misses >= _MISSES and t - self._heard_t >= _SILENCE
            return
        self._misses, self._heard, self._heard_t = 0, True, t
        alert = bool(reply.error & ALERT_BIT)
        self._latched = reply.latched
        self.is_stale |= alert is not self._alert
        self._alert = alert
        self._seen = self.motion.read(reply.data)
        if self._dial is None and self.model is not None:
            self._dial = Dial(self.model, self.place, self._seen.ticks)
        if self._dial is not None:
            self._position = self._dial.position(self._seen.ticks, torque=self.torque)
        self._weigh(t)

    def take_slow(self, block: Block, reply: Reply) -> bool:
        """Take what changes slowly; give whether its registers should be read anew.

        What is in the EEPROM changes only while a servo has no torque.
        """
        if reply.loss is not None or self.model is None:
            return False
        had = self.torque
        self._values |= slow_values(self.model, block, reply.data)
        return had is False and self.torque is True

    def refresh(self, bus: Stethoscope) -> None:
        """Read its registers anew."""
        if self.model is None:
            return
        values = read_registers(bus, self.servo_id, self.model, None)
        if values is not None:
            self._know(self.model, values)

    def _know(self, model: ServoModel, values: dict[str, int]) -> None:
        """Take what its registers hold, and what is borne by them."""
        spec = self.place.servo
        health = HealthLimits() if spec is None else spec.health
        self._limits = health.resolved(model, values)
        self._values |= values

    def lose(self) -> None:
        """Count it as silent from now on, as when the port is gone."""
        self._is_silent = True

    @property
    def torque(self) -> bool | None:
        """Whether it has torque; None: not known yet."""
        known = self._values.get(TORQUE)
        return None if known is None else bool(known)

    def sample(self, port: str, arm: str | None, retries: int) -> ServoSample:
        """Give how it fares.

        Args:
            port: The port, for remedies.
            arm: How the user named the arm, for remedies.
            retries: How often single questions to it were asked again.
        """
        facts = self._facts(retries)
        if not self._is_silent and self._heard:
            facts = self._with_measurements(facts)
        return replace(facts, verdict=judge(facts, self._evidence(port, arm)))

    def _facts(self, retries: int) -> ServoSample:
        """Give who it is and how it answers: all that is known while it is silent."""
        spec, stats = self.place.servo, self.tally.stats
        return ServoSample(
            servo_id=self.servo_id,
            name=self.name,
            joint=None if spec is None else spec.joint,
            model="" if self.model is None else self.model.name,
            kind=self.place.kind,
            reads=stats.reads,
            lost=stats.timeouts,
            damaged=stats.crc_errors,
            retries=retries,
        )

    def _with_measurements(self, facts: ServoSample) -> ServoSample:
        """Add what it measures."""
        model, values, seen = self.model, self._values, self._seen
        if model is None:
            return facts
        supply = values.get(VOLTAGE, values.get(voltage_register(model).name))
        return replace(
            facts,
            answers=True,
            position=self._position,
            velocity=seen.velocity,
            current=seen.current,
            mean_current=self._effort if model.has_current else nan,
            load=seen.load,
            temperature=float(values.get(TEMPERATURE, nan)),
            voltage=nan if supply is None else supply / 10.0,
            errors=model.hardware_errors(values.get(HARDWARE_ERROR, self._latched)),
            torque=self.torque,
            moving=seen.moving,
        )

    def _evidence(self, port: str, arm: str | None) -> Evidence:
        spec, chart = self.place.servo, None
        if self.model is not None:
            chart = Chart(
                servo_id=self.servo_id,
                name="" if spec is None else spec.name,
                model=self.model,
                firmware=self.firmware,
                values=self._values,
            )
        moves_joint = spec is not None and spec.joint is not None
        return Evidence(
            chart=chart,
            limits=self._limits,
            effort=self._effort,
            port=port,
            arm=arm,
            complaint=self.tally.complaint,
            other=self._other,
            is_calibrated=not moves_joint or self.place.zero is not None,
        )

    def _weigh(self, t: float) -> None:
        """Let an effort count by the time since the last, from none at first."""
        seen = self._seen
        effort = abs(seen.current if isnan(seen.load) else seen.load)
        share = 0.0 if isnan(self._effort_t) else 1.0 - exp(-(t - self._effort_t) / MEMORY)
        known = 0.0 if isnan(self._effort) else self._effort
        self._effort = known + share * (effort - known)
        self._effort_t = t
