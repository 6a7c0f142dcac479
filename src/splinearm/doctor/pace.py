"""The loop rate that an arm's line allows: by formula from its bytes and delays, then measured.

A cycle is one write of all goals and one read of all servos (two reads where models differ). On the
wire every byte takes ten bits; each servo that answers by itself waits its Return Delay Time first,
in a fast read only the first one does; an adapter hands answers over at ticks of its latency.

The write is waited for and not sent when the rate is measured: nothing is written to a servo.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil
from statistics import median

from splinearm.drivers.bus import Loss, PingReply, ReadGroup
from splinearm.drivers.chain import ServoChain
from splinearm.drivers.crew import Crew
from splinearm.drivers.link import BITS_PER_BYTE
from splinearm.drivers.packets import Instruction
from splinearm.drivers.traffic import Extras, Traffic, direct_traffic

from .catalogue import found
from .finding import Finding
from .stethoscope import Stethoscope

USUAL_RATE = 100.0
"""Setpoints a second that a job wants unless it says otherwise, Hz."""

_FAST = (Instruction.FAST_SYNC_READ, Instruction.FAST_BULK_READ)
_CYCLES, _LASTS = 200, 1.0  # s
_FALLS_SHORT = 0.7
_NEAR = 0.02  # share of a tick that a cycle may need too much and still be counted as within it


@dataclass(frozen=True, slots=True, kw_only=True)
class Pace:
    """How often a second an arm can be written to and read."""

    baud: int
    """Bits per second."""
    servos: int
    """How many are read."""
    bytes_out: int
    """Bytes to the servos in a cycle."""
    bytes_back: int
    """Bytes from them."""
    delay: float
    """What servos wait before answers, together, s."""
    latency: float
    """At ticks of what time answers are handed over, s; 0: at once."""
    predicted: float
    """The rate that follows, Hz."""
    measured: float | None = None
    """The rate that was measured, Hz; None: it was not."""

    @property
    def words(self) -> str:
        """Give it in a line."""
        late = f", handed over every {self.latency * 1e3:g} ms" if self.latency else ""
        text = (
            f"{self.predicted:.0f} Hz follow from {self.bytes_out} + {self.bytes_back} bytes for "
            f"{self.servos} servos at {self.baud} baud, {self.delay * 1e6:.0f} us of delays{late}"
        )
        return text if self.measured is None else f"{text}; measured: {self.measured:.0f} Hz"


def traffic_of(
    chain: ServoChain, joint_names: tuple[str, ...], roll: Mapping[int, PingReply]
) -> Traffic:
    """Give what goes to and fro in a cycle of an arm.

    Raises:
        ValueError: If a servo of the arm cannot be a joint.
    """
    return direct_traffic(Crew.of(chain, joint_names), roll, Extras())


def predicted_period(
    traffic: Traffic, baud: int, delays: Mapping[int, float], latency: float
) -> float:
    """Give the time of a cycle by formula, s.

    Args:
        traffic: What goes to and fro.
        baud: Bits per second.
        delays: By id the servo's delay before an answer, s.
        latency: At ticks of what time answers are handed over, s.
    """
    pending = bytes_out(traffic, writes_only=True) * BITS_PER_BYTE / baud
    total = 0.0
    for part in traffic.reads:
        group = part.group
        count = len(group.request) + group.reply_length
        pending += count * BITS_PER_BYTE / baud + _delay(group, delays)
        ticks = max(ceil(pending / latency - _NEAR), 1) if latency else 0
        total += ticks * latency if latency else pending
        pending = 0.0
    return total


def bytes_out(traffic: Traffic, *, writes_only: bool = False) -> int:
    """Give how many bytes go to the servos in a cycle."""
    writes = sum(len(part.group.frame([0] * len(part.group.ids))) for part in traffic.writes)
    return writes if writes_only else writes + sum(len(p.group.request) for p in traffic.reads)


def pace_of(traffic: Traffic, baud: int, delays: Mapping[int, float], latency: float) -> Pace:
    """Give the rate that follows."""
    return Pace(
        baud=baud,
        servos=sum(len(part.group.ids) for part in traffic.reads),
        bytes_out=bytes_out(traffic),
        bytes_back=sum(part.group.reply_length for part in traffic.reads),
        delay=sum(_delay(part.group, delays) for part in traffic.reads),
        latency=latency,
        predicted=1.0 / predicted_period(traffic, baud, delays, latency),
    )


def measured_rate(bus: Stethoscope, traffic: Traffic, *, cycles: int = _CYCLES) -> float | None:
    """Give the rate that the line and this computer hold, Hz; None: too many answers are lost.

    Args:
        bus: The bus.
        traffic: What is read; what would be written is waited for.
        cycles: How many cycles to measure at most; it takes a second at most.

    Raises:
        PortError: If the port is gone.
    """
    writing = bytes_out(traffic, writes_only=True) * BITS_PER_BYTE / bus.baud
    periods: list[float] = []
    good = 0
    until = time.monotonic() + _LASTS
    last = time.perf_counter()
    while len(periods) < cycles and time.monotonic() < until:
        _wait(last + writing)
        whole = all(_read(bus, part.group) for part in traffic.reads)
        now = time.perf_counter()
        periods.append(now - last)
        good += whole
        last = now
    if not periods or good < 0.8 * len(periods):
        return None
    return 1.0 / median(periods)


def check_pace(pace: Pace, where: str) -> list[Finding]:
    """Say whether the line is too slow for jobs, or this computer for the line."""
    if pace.predicted < USUAL_RATE:
        return [found("C07", where, pace.words, _quicker(pace))]
    if pace.measured is not None and pace.measured < _FALLS_SHORT * pace.predicted:
        remedy = "close other programs, or permit real-time priority (`splinearm doctor` says how)"
        return [found("C08", where, pace.words, remedy)]
    return []


def _quicker(pace: Pace) -> str:
    """Say what helps most."""
    wire = (pace.bytes_out + pace.bytes_back) * BITS_PER_BYTE / pace.baud
    if pace.latency > max(wire, pace.delay):
        return "set the adapter's latency timer to 1 ms (see P05)"
    if pace.delay > wire:
        return "set the Return Delay Time of every servo to 0 (see L09)"
    return (
        "give every servo a higher Baud Rate (1000000 or more) and write it into the arm's file, "
        "or run jobs with a lower --rate"
    )


def _delay(group: ReadGroup, delays: Mapping[int, float]) -> float:
    """Give what servos wait before their answers to a read, together, s."""
    each = [delays.get(servo_id, 0.0) for servo_id in group.ids]
    return each[0] if group.instruction in _FAST else sum(each)


def _wait(due: float) -> None:
    """Wait as long as the bytes of the write would take."""
    left = due - time.perf_counter()
    if left > 1e-3:
        time.sleep(left - 5e-4)
    while time.perf_counter() < due:
        pass


def _read(bus: Stethoscope, group: ReadGroup) -> bool:
    """Read once; tell whether everyone answered."""
    answer = bus.fetch(group)
    if isinstance(answer, bytes):
        return True
    return all(reply.loss is None or reply.loss is Loss.REFUSED for reply in answer.values())
