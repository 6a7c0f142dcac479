"""Who answers on a line: the servos of the arm's file, and any other, at any rate."""

import time
from collections.abc import Sequence
from dataclasses import dataclass

from splinearm.drivers.bus import PingReply
from splinearm.drivers.chain import ServoChain, ServoSpec
from splinearm.drivers.dialect import protocols_of
from splinearm.drivers.dynamixel import DEFAULT_BAUDS
from splinearm.drivers.link import is_socket
from splinearm.errors import BusError, PortError

from .model_number import model_of
from .pulse import is_shared
from .stethoscope import Heard, Stethoscope, lacks_rate

FACTORY_ID = 1
"""The id of every servo fresh out of the box."""

_SPOILT = 3
_NEAR = 20
"""How far from each other the ids are for which is looked first."""
_PATIENCE, _QUICK_PATIENCE = (0.0, 0.0, 0.2), (0.0, 0.0, 0.0)
"""How much longer than usually to wait when servos are called again and again, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stranger:
    """A servo that answered otherwise than the arm's file says."""

    reply: PingReply
    """What it said of itself."""
    baud: int
    """At which rate."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Roll:
    """Who answered."""

    baud: int
    """The rate of the arm's file, or the one at which most answered."""
    present: dict[int, PingReply]
    """By id who answered as the file says; without a file, whoever did."""
    garbled: tuple[int, ...]
    """Ids from which only damaged answers came."""
    silent: tuple[ServoSpec, ...]
    """Servos of the file that did not answer as it says."""
    strangers: tuple[Stranger, ...]
    """Who answered at another rate, in another protocol, or is not in the file."""
    is_echoed: bool
    """Whether what was sent came back."""
    tried: tuple[int, ...]
    """The rates that were tried."""
    crowded: tuple[int, ...] = ()
    """Rates at which several servos answer to the id that all have fresh out of the box."""


def call_roll(port: str, chain: ServoChain, *, until: float, thorough: bool = True) -> Roll:
    """Ask the servos of an arm's file, and everyone at other rates until none is missing.

    Args:
        port: The port.
        chain: The servos.
        until: When to stop looking, s on the monotonic clock.
        thorough: Whether to look for servos that the file does not name even if none is missing.

    Raises:
        PortError: If the port cannot be had.
    """
    protocols = protocols_of(chain)
    strangers: list[Stranger] = []
    with Stethoscope(port, chain.baud, protocols=protocols) as bus:
        present, garbled, echoed = _call_named(bus, chain, thorough=thorough)
        known = {*present, *garbled}
        silent = tuple(servo for servo in chain.servos if servo.servo_id not in known)
        if silent or thorough:
            named = {(servo.servo_id, protocols[servo.servo_id]) for servo in chain.servos}
            strangers += [
                Stranger(reply=reply, baud=chain.baud)
                for reply in _everyone(bus, echoed=echoed)
                if (reply.servo_id, reply.protocol) not in named
            ]
    tried, crowded = [chain.baud], []
    rates = [rate for rate in _rates(chain) if rate != chain.baud and not is_socket(port)]
    for baud in rates if silent else ():
        if time.monotonic() > until or all(otherwise(servo, strangers) for servo in silent):
            break
        others, is_crowd = _at(port, baud, echoed=echoed)
        strangers += others
        crowded += [baud] * is_crowd
        tried.append(baud)
    return Roll(
        baud=chain.baud,
        present=present,
        garbled=garbled,
        silent=silent,
        strangers=tuple(strangers),
        is_echoed=echoed,
        tried=tuple(tried),
        crowded=tuple(crowded),
    )


def otherwise(servo: ServoSpec, strangers: Sequence[Stranger]) -> Stranger | None:
    """Give who answered as a servo of the file would, but at another rate or in another protocol.

    An id alone is no proof where it is the one that servos have from the factory.
    """
    for one in strangers:
        if one.reply.servo_id == servo.servo_id:
            same = one.reply.model_number == servo.servo_model.number
            if same or servo.servo_id != FACTORY_ID:
                return one
    return None


def call_everyone(port: str) -> Roll:
    """Ask everyone at every rate, where no arm's file says who should be there.

    Raises:
        PortError: If the port cannot be had.
    """
    rates = DEFAULT_BAUDS[:1] if is_socket(port) else DEFAULT_BAUDS
    found: list[Stranger] = []
    with Stethoscope(port, rates[0]) as bus:
        echoed = bus.listen(0).is_echoed  # an adapter that hears itself does so at any rate
    crowded: list[int] = []
    for baud in rates:
        others, is_crowd = _at(port, baud, echoed=echoed)
        found += others
        crowded += [baud] * is_crowd
    counts = {baud: sum(one.baud == baud for one in found) for baud in rates}
    usual = max(counts, key=lambda baud: counts[baud])
    return Roll(
        baud=usual,
        present={one.reply.servo_id: one.reply for one in found if one.baud == usual},
        garbled=(),
        silent=(),
        strangers=tuple(one for one in found if one.baud != usual),
        is_echoed=echoed,
        tried=rates,
        crowded=tuple(crowded),
    )


def _call_named(
    bus: Stethoscope, chain: ServoChain, *, thorough: bool
) -> tuple[dict[int, PingReply], tuple[int, ...], bool]:
    """Ask the servos of a file again and again; give who answers, who but damaged, and an echo."""
    present: dict[int, PingReply] = {}
    garbled: dict[int, None] = {}
    echoed = False
    waiting = [servo.servo_id for servo in chain.servos]
    for patience in _PATIENCE if thorough else _QUICK_PATIENCE:
        for servo_id in tuple(waiting):
            reply, damaged, echo = _call(bus, servo_id, patience)
            echoed |= echo
            if reply is not None:
                present[servo_id] = reply
                waiting.remove(servo_id)
            elif damaged:
                garbled[servo_id] = None
        if not (present or garbled):
            break  # nobody is there: elsewhere they are found sooner
    return present, tuple(i for i in garbled if i not in present), echoed


def _call(bus: Stethoscope, servo_id: int, patience: float) -> tuple[PingReply | None, bool, bool]:
    """Ping a servo; give its answer, whether it came damaged, and whether there was an echo."""
    heard = bus.listen(servo_id, patience=patience)
    if not heard.packets:
        return None, bool(heard.data), heard.is_echoed
    params = heard.packets[0].params
    if bus.protocol_of(servo_id) == 2 and len(params) == 3:
        number = params[0] | params[1] << 8
        return PingReply(servo_id, number, params[2]), False, heard.is_echoed
    try:
        return bus.ping(servo_id), False, heard.is_echoed
    except BusError:  # of what else it takes in Protocol 1.0 something was lost
        return None, True, heard.is_echoed


def _everyone(bus: Stethoscope, *, echoed: bool) -> Sequence[PingReply]:
    """Ask everyone at the rate of a bus, in both protocols."""
    if echoed:  # an echo of Protocol 1.0 cannot be told from an answer
        return bus.scan(quiet_slots=_NEAR)
    return (*bus.scan(quiet_slots=_NEAR), *bus.scan_v1(quiet_slots=_NEAR))


def _at(port: str, baud: int, *, echoed: bool) -> tuple[list[Stranger], bool]:
    """Give who answers at a rate, and whether several do as fresh out of the box.

    Nobody does if the adapter does not have that rate.
    """
    try:
        bus = Stethoscope(port, baud)
    except PortError as error:
        if lacks_rate(error, baud):
            return [], False
        raise
    with bus:
        replies = _everyone(bus, echoed=echoed)
        is_crowd = _is_crowd(bus, replies)
        alone = [r for r in replies if not (is_crowd and r.servo_id == FACTORY_ID)]
        return [Stranger(reply=reply, baud=baud) for reply in alone], is_crowd


def _is_crowd(bus: Stethoscope, replies: Sequence[PingReply]) -> bool:
    """Tell whether several servos answer at once to the id that all have at first.

    Those of one model answer a ping alike; where they are they do not say alike.
    """
    first = [reply for reply in replies if reply.servo_id == FACTORY_ID]
    if not first:
        return all(_is_spoilt(bus.listen(FACTORY_ID)) for _ in range(_SPOILT))
    model = model_of(first[0].model_number)
    place = None if model is None else model.table.get("Present Position")
    bus.speak({FACTORY_ID: first[0].protocol})
    return place is not None and is_shared(bus, FACTORY_ID, place)


def _is_spoilt(heard: Heard) -> bool:
    return bool(heard.data) and not heard.packets


def _rates(chain: ServoChain) -> tuple[int, ...]:
    """Give the rates at which servos of an arm may be, the likeliest first."""
    known = {rate for servo in chain.servos for rate in servo.servo_model.baud_codes.values()}
    likely = [rate for rate in (57_600, 1_000_000, *DEFAULT_BAUDS) if rate in known]
    return tuple(dict.fromkeys(likely))
