"""Who is on the line, whatever the rate, protocol and id."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from splinearm.doctor.roll import FACTORY_ID
from splinearm.doctor.stethoscope import lacks_rate
from splinearm.drivers.bus import PingReply
from splinearm.drivers.chain import ServoChain, ServoSpec
from splinearm.drivers.client import QUIET_SLOTS
from splinearm.drivers.dialect import protocol_of
from splinearm.drivers.dynamixel import DEFAULT_BAUDS
from splinearm.drivers.model import ServoModel, servo_models
from splinearm.errors import BusError, BusTimeoutError, PacketError, PortError, ServoError

from .bench import Address, Bench, Found

if TYPE_CHECKING:
    from splinearm.drivers.dynamixel import DynamixelBus

_OWN = ("Present Position", "Realtime Tick")
"""Where two servos of one model hardly hold the same."""


@dataclass(frozen=True, slots=True)
class Presence:
    """Who answered."""

    found: tuple[Found, ...]
    """The servos, by rate, protocol and id."""
    garbled: tuple[Address, ...] = ()
    """From where only damaged answers came: two servos may share that address."""


def target_of(servo: ServoSpec, chain: ServoChain) -> Address:
    """Give where a servo of an arm's file shall be."""
    return Address(chain.baud, protocol_of(servo, chain.protocol), servo.servo_id)


def factory_baud(model: ServoModel) -> int:
    """Give the rate of a model fresh out of the box."""
    code = model.table["Baud Rate"].initial
    return model.baud_codes[code if isinstance(code, int) else 0]


def usual_rates(chain: ServoChain | None) -> tuple[int, ...]:
    """Give the rates at which servos are likely to be, the likeliest first."""
    models = _models(chain)
    known = {rate for model in models for rate in model.baud_codes.values()}
    first = [] if chain is None else [chain.baud]
    likely = [*first, *(factory_baud(model) for model in models), *DEFAULT_BAUDS]
    return tuple(rate for rate in dict.fromkeys(likely) if rate in known)


def rare_rates(chain: ServoChain | None) -> tuple[int, ...]:
    """Give the other rates that the servos have."""
    known = {rate for model in _models(chain) for rate in model.baud_codes.values()}
    return tuple(sorted(known - set(usual_rates(chain))))


def call_file(bench: Bench, chain: ServoChain) -> Presence:
    """Ask only the servos of an arm's file, where they shall be.

    Raises:
        PortError: If the port is gone.
    """
    return call_at(bench, [target_of(servo, chain) for servo in chain.servos])


def call_at(bench: Bench, addresses: Iterable[Address]) -> Presence:
    """Ask whoever is at some addresses.

    Raises:
        PortError: If the port is gone.
    """
    found: list[Found] = []
    garbled: list[Address] = []
    waiting = list(addresses)
    for _ in range(2):
        for address in tuple(waiting):
            one, damaged = _ping(bench, address)
            if one is not None:
                found.append(one)
            elif damaged:
                garbled.append(address)
            if one is not None or damaged:
                waiting.remove(address)
        if not (found or garbled):
            break
    return Presence(tuple(found), tuple(garbled))


def call_everyone(
    bench: Bench,
    chain: ServoChain | None,
    rates: Iterable[int] | None = None,
    *,
    thorough: bool = True,
    until_all: bool = False,
    quiet_slots: int = QUIET_SLOTS,
) -> Presence:
    """Ask everyone in both protocols.

    Args:
        bench: The line.
        chain: The servos that should be there; None: whoever is there.
        rates: The rates; None: the usual ones.
        thorough: Whether to look for servos in a protocol that is not their model's first, and for
            several in the place of one of the file.
        until_all: Whether to ask at no further rate once as many of each model are there as the
            file names.
        quiet_slots: After how many ids without a servo to give up at a rate.

    Raises:
        PortError: If the port is gone.
    """
    found: dict[Address, Found] = {}
    garbled: list[Address] = []
    every = tuple(usual_rates(chain) if rates is None else rates)
    for baud in every if bench.has_rates else every[:1]:
        if until_all and chain is not None and _are_all(chain, found.values()):
            break
        try:
            bus = bench.at(baud)
        except PortError as error:
            if lacks_rate(error, baud):
                continue
            raise
        old = thorough or any(model.protocols[0] == 1 for model in _models(chain))
        found |= {one.address: one for one in _all_at(bus, baud, quiet_slots, old=old)}
        for address in _doubtful(chain, baud, found, thorough=thorough):
            one, damaged = _ping(bench, address)
            if one is not None:
                found[address] = one
            elif damaged:
                garbled.append(address)
    return Presence(tuple(found[address] for address in sorted(found)), tuple(garbled))


def _are_all(chain: ServoChain, found: Iterable[Found]) -> bool:
    """Tell whether as many of each model are there as the file names."""
    there = Counter(one.model_number for one in found)
    return Counter(servo.servo_model.number for servo in chain.servos) <= there


def without_twins(bench: Bench, presence: Presence) -> Presence:
    """Give those who answer for themselves alone.

    Two servos of one model and id answer a ping alike, at the same time; where they are they do not
    say alike.

    Raises:
        PortError: If the port is gone.
    """
    twins = [one for one in presence.found if _is_shared(bench, one)]
    alone = tuple(one for one in presence.found if one not in twins)
    return Presence(alone, (*presence.garbled, *(one.address for one in twins)))


def _all_at(bus: "DynamixelBus", baud: int, quiet_slots: int, *, old: bool) -> Iterator[Found]:
    """Ask everyone at one rate, those of Protocol 1.0 if that is wanted."""
    replies: list[PingReply] = []
    for scan in (bus.scan, bus.scan_v1) if old else (bus.scan,):
        replies += _scanned(partial(scan, quiet_slots=quiet_slots))
    for reply in replies:
        address = Address(baud, reply.protocol, reply.servo_id)
        yield Found(address, reply.model_number, reply.firmware)


def _is_shared(bench: Bench, one: Found) -> bool:
    """Tell whether what a servo says of its place is damaged each time."""
    table = {} if one.model is None else one.model.table
    try:
        for name in _OWN:
            if name in table:
                bench.to(one.address).read(one.address.servo_id, table[name])
    except PacketError:
        return True
    except (BusTimeoutError, ServoError):
        return False
    return False


def _scanned(scan: Callable[[], Sequence[PingReply]]) -> Sequence[PingReply]:
    """Give who answers; nobody, if servos spoil each other's answers: those are asked by id."""
    try:
        return scan()
    except (BusTimeoutError, PacketError):
        return ()


def _doubtful(
    chain: ServoChain | None, baud: int, found: dict[Address, Found], *, thorough: bool
) -> Sequence[Address]:
    """Give the addresses at which someone may be who was not heard in the crowd."""
    at_first = [model for model in _models(chain) if factory_baud(model) == baud]
    every = {Address(baud, model.protocols[0], FACTORY_ID) for model in at_first}
    if chain is not None:
        last = max((a.servo_id for a in found if a.baud == baud), default=-1)
        for servo in chain.servos:
            is_far = servo.servo_id > last + QUIET_SLOTS
            if is_far or (thorough and baud == chain.baud):
                every.add(target_of(servo, chain)._replace(baud=baud))
    known = {address.servo_id for address in found if address.baud == baud}
    return sorted(address for address in every if address.servo_id not in known)


def _ping(bench: Bench, address: Address) -> tuple[Found | None, bool]:
    """Ask one servo once; give it, or whether what came was damaged."""
    try:
        reply = bench.to(address).ping(address.servo_id, tries=1)
    except PortError:
        raise
    except BusTimeoutError:
        return None, False
    except BusError:
        return None, True
    return Found(address, reply.model_number, reply.firmware), False


def _models(chain: ServoChain | None) -> Sequence[ServoModel]:
    if chain is None:
        return servo_models()
    return [servo.servo_model for servo in chain.servos]
