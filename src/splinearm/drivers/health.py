"""Servos looked after while they move: temperature, supply and effort, one servo at a time.

Position, speed and current come in every cycle. What changes slowly is asked of one servo after the
other, some times a second, so that a cycle rarely costs a transaction more.
"""

import logging
import struct
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import exp, isnan, nan
from typing import NoReturn

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import BusError, HealthError, ServoError

from .ability import HARDWARE_ERROR, says_torque, torque_span, voltage_register
from .asking import read_all
from .bus import Reply, ServoBus, loss_error
from .chain import ServoSpec
from .cyclic import GroupRead
from .groups import BulkRead
from .health_limit import HealthLimits
from .packets import ALERT_BIT
from .startup import hardware_error

_log = logging.getLogger(__name__)

_LAYOUTS = {2: struct.Struct("<HB"), 1: struct.Struct("<BB")}
"""Supply and temperature, by the bytes of the supply."""
_ROUND = 1.0
"""How long a round of all servos takes, s."""
MEMORY = 0.5
"""Time over which the effort of a servo is taken together, s: accelerating is no overload."""
_STEP = 0.02
"""How often an effort counts, s: at a high rate not every cycle has to."""
_FIRST_SHARE = 0.1
_PATIENCE = 3
"""How often in a row a servo may be silent before it counts as lost."""
_LIMIT_REGISTERS = ("Temperature Limit", "Max Voltage Limit", "Min Voltage Limit")


@dataclass(slots=True, kw_only=True)
class HealthReading:
    """What is known of how a servo fares; NaN where nothing is."""

    t: float = nan
    """When temperature and voltage were read, s on the monotonic clock."""
    temperature: float = nan
    """Temperature inside, degC."""
    voltage: float = nan
    """Supply, V."""
    current: float = nan
    """Magnitude of its current over the last half second, A."""
    load: float = nan
    """The same of its load, as a share of its torque."""


@dataclass(frozen=True, slots=True)
class _Watched:
    """One quantity: where it is read, how it is told, and what helps."""

    field: str
    name: str
    unit: str
    remedy: str
    factor: float = 1.0
    low: bool = False


LIGHTEN = "look for what blocks the joint, lighten its load or move slower"
"""What helps a servo that works too hard."""
_QUANTITIES = (
    _Watched(
        "temperature",
        "temperature",
        "degC",
        "let it cool down, then lighten its load or let it rest more",
    ),
    _Watched(
        "voltage",
        "supply",
        "V",
        "charge the battery or take a stronger supply or thicker cables",
        low=True,
    ),
    _Watched("voltage", "supply", "V", "lower the supply"),
    _Watched("current", "current", "A", LIGHTEN),
    _Watched("load", "load", "%", LIGHTEN, factor=100.0),
)


class HealthWatch:
    """The health of an arm's servos, read a little at a time.

    Args:
        bus: The bus.
        servos: The servos; leaders first, one a joint.
        leaders: How many of them are leaders.
        limits: By id what is borne, with a number in every field.
        period: Time between two looks, s; None: each servo is looked at once a second, and once
            a second whether it has torque.
    """

    def __init__(
        self,
        bus: ServoBus,
        servos: Sequence[ServoSpec],
        leaders: int,
        limits: Mapping[int, HealthLimits],
        period: float | None = None,
    ) -> None:
        self._bus = bus
        self._servos = tuple(servos)
        self._leaders = self._servos[:leaders]
        self.limits = limits
        """By id what is borne."""
        self._period = _ROUND / (2 * len(self._servos)) if period is None else period
        supplies = [voltage_register(servo.servo_model) for servo in servos]
        self._layouts = [_LAYOUTS[supply.size] for supply in supplies]
        self._fares = [
            _reader(servo, supply.address, layout.size)
            for servo, supply, layout in zip(servos, supplies, self._layouts, strict=True)
        ]
        self._torques = [_reader(servo, *torque_span(servo.servo_model)) for servo in servos]
        self._next = 0
        self._asks_torque = False
        self._due = time.monotonic()
        self._missed = 0
        self._effort = np.full(leaders, nan)
        self._effort_t = nan
        kinds = ["current" if s.servo_model.has_current else "load" for s in self._leaders]
        self._effort_warn = np.array(
            [
                getattr(limits[servo.servo_id], f"{kind}_warn")
                for servo, kind in zip(self._leaders, kinds, strict=True)
            ]
        )
        self._kinds = kinds
        self._told: set[tuple[int, str, bool]] = set()
        self._raised: set[tuple[int, str, bool]] = set()
        self._silences: Counter[int] = Counter()
        self._fallen: BusError | None = None
        self._reminded = False
        self._readings = {servo.servo_id: HealthReading() for servo in self._servos}

    @property
    def readings(self) -> Mapping[int, HealthReading]:
        """By id how each servo fares."""
        self._note_efforts()
        return self._readings

    def look(self, t: float, effort: FloatArray, *, torque: bool = True) -> None:
        """Take the effort of a cycle, and if it is time ask the next servo how it fares.

        Args:
            t: When, s on the monotonic clock.
            effort: Current of each leader, A, or its load as a share, shape (n,).
            torque: Whether the servos should have torque.

        Raises:
            HealthError: If something is beyond its stop threshold and was not before.
            ServoError: If a servo has latched a hardware error, or has lost its torque.
            BusTimeoutError: If a servo was silent for three looks.
        """
        if self._fallen is not None and self._reminded:
            self._reminded = False
            raise self._fallen
        if not t - self._effort_t < _STEP:  # or it is the first
            self._weigh(t, np.abs(effort))
        if self._silences:
            self._ask_those_who_are_back(torque=torque)
        if t >= self._due:
            servo = self._servos[self._next]
            self._ask(t, torque=torque)
            self._note_efforts()
            self._judge(servo)

    def suspect(self, servo_id: int) -> None:
        """Note that a servo gave no answer: after some in a row it may come back without torque."""
        self._silences[servo_id] += 1

    def begin_anew(self) -> None:
        """Forget what was: after a recovery everything is read, and told, again."""
        self._effort = np.full_like(self._effort, nan)
        self._told.clear()
        self._raised.clear()
        self._fallen = None
        self._missed = 0
        for servo_id in self._readings:
            self._readings[servo_id] = HealthReading()

    def remind(self) -> None:
        """Raise again at the next look what was raised before and, as far as known, is still so."""
        self._raised.clear()
        self._reminded = True

    def _ask_those_who_are_back(self, *, torque: bool) -> None:
        """Ask servos that were silent for long whether they still have torque."""
        back = [k for k, s in enumerate(self._servos) if self._silences[s.servo_id] >= _PATIENCE]
        self._silences.clear()
        for k in back:
            servo = self._servos[k]
            reply = self._bus.sync_read(self._torques[k])[servo.servo_id]
            if torque and reply.loss is None and not says_torque(reply.data):
                self._fall(_limp(servo))

    def _weigh(self, t: float, effort: FloatArray) -> None:
        """Let an effort count by the time since the last, from none at first; judge their mean."""
        share = 0.0 if isnan(self._effort_t) else 1.0 - exp(-(t - self._effort_t) / MEMORY)
        known = np.where(np.isnan(self._effort), 0.0, self._effort)
        if t - self._effort_t > MEMORY:  # what was before a pause may be mended
            known = np.fmin(known, effort)
        # after a pause the first word counts no more than others: who starts hard may do so
        mean = known + min(share, _FIRST_SHARE) * (effort - known)
        self._effort = np.where(np.isnan(effort), self._effort, mean)
        self._effort_t = t
        if self._raised or (self._effort >= self._effort_warn).any():
            self._note_efforts()
            for servo in self._leaders:
                self._judge(servo)

    def _note_efforts(self) -> None:
        for servo, kind, value in zip(self._leaders, self._kinds, self._effort, strict=True):
            setattr(self._readings[servo.servo_id], kind, float(value))

    def _ask(self, t: float, *, torque: bool) -> None:
        """Ask the servo whose turn it is; one that is silent stays at its turn."""
        servo = self._servos[self._next]
        group = (self._torques if self._asks_torque else self._fares)[self._next]
        reply = self._bus.sync_read(group)[servo.servo_id]
        if reply.loss is not None:
            self._miss(servo, reply)
            return
        self._missed = 0
        self._due = t + self._period
        if not self._asks_torque:
            decivolt, degrees = self._layouts[self._next].unpack(reply.data)
            reading = self._readings[servo.servo_id]
            reading.t, reading.voltage, reading.temperature = t, decivolt / 10.0, float(degrees)
        self._next = (self._next + 1) % len(self._servos)
        asked_torque, self._asks_torque = self._asks_torque, self._asks_torque ^ (self._next == 0)
        if reply.error & ALERT_BIT:
            self._fall(self._latched(servo, reply.latched))
        if asked_torque and torque and not says_torque(reply.data):
            self._fall(_limp(servo))

    def _fall(self, error: BusError) -> NoReturn:
        """Raise the error of a servo without torque, and again when reminded."""
        self._fallen, self._reminded = error, False
        raise error

    def _miss(self, servo: ServoSpec, reply: Reply) -> None:
        """Ask again in the next cycle; raise if that was often enough."""
        self._missed += 1
        if self._missed >= _PATIENCE:
            raise loss_error(
                reply, servo.servo_id, "Present Temperature", port=self._bus.port, name=servo.name
            )

    def _latched(self, servo: ServoSpec, told: int) -> BusError:
        """Make the error of a servo that reports a hardware error; ``told`` is what it said."""
        register = servo.servo_model.table.get(HARDWARE_ERROR)
        status = told
        if register is not None:
            with suppress(BusError):
                status = self._bus.read(servo.servo_id, register)
        return hardware_error(servo, status)

    def _judge(self, servo: ServoSpec) -> None:
        """Say once what is worth a word, raise once what stops the arm."""
        for quantity in _QUANTITIES:
            key = (servo.servo_id, quantity.field, quantity.low)
            error = self._error(servo, quantity)
            if error is None:
                self._raised.discard(key)
                self._warn(servo, quantity, key)
            elif key not in self._raised:
                self._raised.add(key)
                raise error

    def _error(self, servo: ServoSpec, quantity: _Watched) -> HealthError | None:
        value, limit = self._value(servo, quantity, "stop")
        if not _beyond(value, limit, low=quantity.low):
            return None
        return HealthError(
            servo.servo_id,
            servo.joint or servo.name,
            quantity.name,
            value,
            limit,
            unit=quantity.unit,
            remedy=quantity.remedy,
            low=quantity.low,
            name=servo.name,
        )

    def _warn(self, servo: ServoSpec, quantity: _Watched, key: tuple[int, str, bool]) -> None:
        value, limit = self._value(servo, quantity, "warn")
        if not _beyond(value, limit, low=quantity.low) or key in self._told:
            return
        self._told.add(key)
        _, stop = self._value(servo, quantity, "stop")
        _log.warning(
            "servo %d (%s): its %s is %.4g %s; at %.4g %s the arm stops; %s",
            servo.servo_id,
            servo.name,
            quantity.name,
            value,
            quantity.unit,
            stop,
            quantity.unit,
            quantity.remedy,
        )

    def _value(self, servo: ServoSpec, quantity: _Watched, which: str) -> tuple[float, float]:
        """Give what a quantity is and where its threshold lies, in the unit it is told in."""
        side = {("voltage", True): "voltage_low", ("voltage", False): "voltage_high"}
        stem = side.get((quantity.field, quantity.low), quantity.field)
        limit: float = getattr(self.limits[servo.servo_id], f"{stem}_{which}")
        value: float = getattr(self._readings[servo.servo_id], quantity.field)
        return value * quantity.factor, limit * quantity.factor


def _beyond(value: float, limit: float, *, low: bool) -> bool:
    """Tell whether a value is at its threshold or beyond; one that is not known is not."""
    return value <= limit if low else value >= limit


def health_limits(bus: ServoBus, servos: Sequence[ServoSpec]) -> dict[int, HealthLimits]:
    """Give by id what is borne of each servo: what its file says, else by its own registers.

    Raises:
        BusError: If a servo gives no answer.
    """
    found = {name: read_all(bus, servos, name) for name in _LIMIT_REGISTERS}
    return {
        servo.servo_id: servo.health.resolved(
            servo.servo_model, {name: values[servo.servo_id] for name, values in found.items()}
        )
        for servo in servos
    }


def _limp(servo: ServoSpec) -> ServoError:
    """Make the error of a servo whose torque went off unasked."""
    return ServoError(
        servo.servo_id,
        "it has lost its torque without an error: it has started anew, as after a dip of its "
        "supply, or another program switched it off; support the arm and recover it",
        alert=True,
        name=servo.name,
    )


def _reader(servo: ServoSpec, address: int, length: int) -> GroupRead:
    """Prepare a question to one servo."""
    return GroupRead([BulkRead(servo.servo_id, address, length)], fast=False)
