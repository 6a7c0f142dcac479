"""Watching the servos on a port: who is there, one cyclic read of all, and one sample a cycle."""

import logging
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import inf
from types import TracebackType
from typing import TYPE_CHECKING, Self

from splinearm.backends import require_chain
from splinearm.control.clock import WallClock
from splinearm.doctor.roll import call_everyone
from splinearm.doctor.stethoscope import Stethoscope
from splinearm.drivers.bus import PingReply
from splinearm.drivers.chain import ServoChain
from splinearm.drivers.dialect import protocol_of
from splinearm.errors import BusError, PortError, SilentBusError

from .beat import Beat, Rhythm
from .dial import Place
from .round import Round
from .sample import Sample
from .watched import Watched

if TYPE_CHECKING:
    from splinearm.config import Cell

_log = logging.getLogger(__name__)

RATE = 50.0
"""Samples a second unless something else is said, Hz."""

_MARGIN = 0.025
"""How late an answer may come, s: adapters that do not say so may hold it back for 16 ms."""
_SLOW_ROUND = 1.0
"""How often what changes slowly is asked, s."""
_CALLS, _QUICKEST, _KNOCKS = 0.5, 0.1, 0.5
"""How often each of those who are silent is called, but no two sooner after each other than the
second, and how often a port that is gone is tried, s."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Crowd:
    """Who is to be watched."""

    baud: int
    servos: tuple[Watched, ...]
    arm: str | None = None
    """Name of the arm."""
    told: str | None = None
    """How the user named it."""


class Monitor:
    """Watches servos; it reads and pings, and can send nothing else.

    A servo that is silent is called again and again, and a port that is gone is opened again as
    soon as it is there: neither is an error once the watching has begun.

    Args:
        port: The port.
        cell: The arm that is there; None: whoever answers is watched.
        baud: Bits per second; None: as the arm's file says, or the rate at which servos answer.
        told: How the user named the arm, for remedies.

    Raises:
        ConfigError: If the arm has no servos.
        PortError: If the port cannot be used.
        SilentBusError: If no arm was named and nobody answers.
    """

    def __init__(
        self,
        port: str,
        cell: "Cell | None" = None,
        *,
        baud: int | None = None,
        told: str | None = None,
    ) -> None:
        if cell is None:
            self._crowd = _whoever(port, baud)
        else:
            self._crowd = _of_arm(cell, require_chain(cell), baud, told)
        self._port = port
        protocols = {servo.servo_id: servo.protocol for servo in self._crowd.servos}
        self._bus = Stethoscope(port, self._crowd.baud, protocols=protocols, margin=_MARGIN)
        self._round: Round | None = None
        self._trouble = ""
        self._number = 0
        self._slow_due = self._call_due = self._knock_due = -1.0
        self._turn = self._calls = 0
        self._beat = Beat()
        try:
            with suppress(PortError):  # the next sample says so
                self._call_all()
        except BaseException:
            self._bus.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._bus.close()

    def samples(self, rate: float = RATE) -> Iterator[Sample]:
        """Give samples at a rate, Hz, for as long as they are asked for.

        Raises:
            ValueError: With the first, if that is no rate.
        """
        if not 0.0 < rate < inf:
            raise ValueError(f"rate: want samples a second above 0, got {rate}")
        clock, period = WallClock(), 1.0 / rate
        self._beat = Beat(rate)
        due = clock.now()
        while True:
            yield self.sample()
            due = max(due + period, clock.now())  # what was missed is not made up for
            clock.wait_until(due)

    def sample(self) -> Sample:
        """Ask once and give what there is to say; waits for nothing but answers."""
        now, t = time.monotonic(), time.time()
        self._number += 1
        try:
            if self._trouble:
                self._beat.pause()
                self._knock(now)
            else:
                self._beat.strike(now)
                self._ask(now)
        except PortError as error:
            self._lose(error)
        return self._sample(t)

    def _sample(self, t: float) -> Sample:
        crowd, retries = self._crowd, self._bus.retries
        return Sample(
            t=t,
            number=self._number,
            port=self._port,
            baud=crowd.baud,
            arm=crowd.arm,
            trouble=self._trouble,
            rhythm=Rhythm(wanted=self._beat.rhythm.wanted) if self._trouble else self._beat.rhythm,
            servos=tuple(
                servo.sample(self._port, crowd.told, retries.get(servo.servo_id, 0))
                for servo in crowd.servos
            ),
        )

    def _ask(self, now: float) -> None:
        """Do what one cycle does: ask all how they move, and at most one thing more."""
        everyone = self._crowd.servos
        before = [servo for servo in everyone if servo.is_present]
        if self._round is None or not self._round.is_for(before):
            self._round = Round(before)
        self._round.ask_motion(self._bus, now)
        if any(servo.is_stale for servo in before):
            self._turn = 0
            self._ask_slowly(self._round, now)
        elif now >= self._slow_due:
            self._ask_slowly(self._round, now)
        elif now >= self._call_due:
            self._call_one([servo for servo in everyone if not servo.is_present], now)

    def _ask_slowly(self, these: Round, now: float) -> None:
        """Ask one of the blocks that change slowly; once in a round each."""
        for servo in these.ask_slow(self._bus, self._turn):
            servo.refresh(self._bus)
        self._turn += 1
        if self._turn >= these.slow_count:
            self._turn = 0
            self._slow_due = now + _SLOW_ROUND

    def _call_one(self, absent: Sequence[Watched], now: float) -> None:
        """Call one of those who are silent, another each time."""
        if absent:
            self._call_due = now + max(_CALLS / len(absent), _QUICKEST)
            self._calls += 1
            self._call(absent[self._calls % len(absent)])

    def _call_all(self) -> None:
        """Call everyone, and ask once for what changes slowly."""
        for servo in self._crowd.servos:
            self._call(servo)
        present = [servo for servo in self._crowd.servos if servo.is_present]
        self._round = Round(present)
        for turn in range(self._round.slow_count):
            self._round.ask_slow(self._bus, turn)
        self._slow_due = time.monotonic() + _SLOW_ROUND

    def _call(self, servo: Watched) -> None:
        reply = self._ping(servo)
        if reply is not None:
            servo.greet(self._bus, reply)

    def _ping(self, servo: Watched) -> PingReply | None:
        """Ping a servo once; None: it gives no answer that can be used."""
        heard = self._bus.listen(servo.servo_id)
        if not heard.packets:
            return None
        params = heard.packets[0].params
        if servo.protocol == 2 and len(params) == 3:
            return PingReply(servo.servo_id, params[0] | params[1] << 8, params[2])
        try:
            return self._bus.ping(servo.servo_id)
        except PortError:
            raise
        except BusError:  # of what else it takes in Protocol 1.0 something was lost
            return None

    def _lose(self, error: PortError) -> None:
        """Note that the port is gone."""
        if not self._trouble:
            _log.warning("%s", error)
        self._trouble = error.reason
        self._knock_due = time.monotonic() + _KNOCKS
        for servo in self._crowd.servos:
            servo.lose()

    def _knock(self, now: float) -> None:
        """Try to have the port again, if it is time to."""
        if now < self._knock_due:
            return
        self._knock_due = now + _KNOCKS
        self._bus.reopen()
        self._trouble = ""
        _log.warning("port %s is there again", self._port)
        self._call_all()


def _whoever(port: str, baud: int | None) -> _Crowd:
    """Find out who answers on a port."""
    if baud is None:
        roll = call_everyone(port)
        baud, present = roll.baud, roll.present
    else:
        with Stethoscope(port, baud) as bus:
            replies = (*bus.scan(), *bus.scan_v1())
        present = {reply.servo_id: reply for reply in replies}
    if not present:
        raise SilentBusError(port)
    servos = [Watched(i, Place(), reply.protocol) for i, reply in sorted(present.items())]
    return _Crowd(baud=baud, servos=tuple(servos))


def _of_arm(cell: "Cell", chain: ServoChain, baud: int | None, told: str | None) -> _Crowd:
    """Give the servos of an arm in the order of its file."""
    limits, names = cell.arm.limits, cell.arm.joint_names
    leaders = {servo.joint: servo for servo in chain.leaders_of(names)}
    servos = []
    for servo in chain.servos:
        place = Place(servo=servo, zero=servo.zero_ticks)
        if servo.joint is not None:
            i = names.index(servo.joint)
            zero = servo.zero_ticks
            place = Place(
                servo=servo,
                zero=leaders[servo.joint].zero_ticks if zero is None else zero,
                range=(float(limits.q_min[i]), float(limits.q_max[i])),
                kind=limits.kinds[i],
            )
        servos.append(Watched(servo.servo_id, place, protocol_of(servo, chain.protocol)))
    return _Crowd(
        baud=chain.baud if baud is None else baud,
        servos=tuple(servos),
        arm=cell.name,
        told=told or cell.name,
    )
