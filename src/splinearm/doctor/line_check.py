"""What is wrong with who answers on a line."""

from collections.abc import Iterator, Sequence
from statistics import quantiles

from splinearm.drivers.chain import ServoChain, ServoSpec
from splinearm.drivers.dialect import protocol_of
from splinearm.drivers.link import BITS_PER_BYTE

from .advice import set_register, setup
from .catalogue import found
from .finding import Finding
from .model_number import model_words
from .pulse import Pulse
from .roll import FACTORY_ID, Roll, Stranger, otherwise

_FACTORY_RATE = 57_600
_FEW = 2
"""So many spoilt or lost answers may be chance."""
_DAMAGED, _LOST = 0.005, 0.01
"""Shares of the answers from which on it is more than that."""
_PING_BYTES = {1: (6, 6), 2: (10, 14)}
_HELD = 4e-3  # s: what holds answers back for less may be this computer


def check_roll(
    port: str, roll: Roll, chain: ServoChain | None, arm: str | None = None
) -> Iterator[Finding]:
    """Say who is missing, who answers otherwise, and who should not be there."""
    if roll.is_echoed:
        yield found(
            "L11",
            port,
            "every byte that is sent comes back before the answer",
            "switch the echo of the adapter off, or separate its TX and RX lines",
        )
    mend = setup(port, arm)
    for baud in roll.crowded:
        yield _crowd(baud, roll, mend)
    if not (roll.present or roll.garbled or roll.strangers):
        if not roll.crowded:
            yield _nobody(port, roll)
        return
    explained: set[int] = set()
    strangers = list(roll.strangers)
    for servo in roll.silent:
        one = otherwise(servo, strangers)
        if one is not None and chain is not None:
            explained.add(servo.servo_id)
            strangers.remove(one)
            yield from _misset(servo, one, chain, mend)
    missing = [servo for servo in roll.silent if servo.servo_id not in explained]
    if missing and chain is not None and not roll.crowded:
        yield _missing(port, missing, chain, strangers, mend)
    for one in strangers:
        yield _stranger(one, roll) if chain is not None else _at_odds(one, roll)


def _nobody(port: str, roll: Roll) -> Finding:
    tried = ", ".join(f"{rate:g}" if rate < 1e6 else f"{rate * 1e-6:g}M" for rate in roll.tried)
    echo = "only what was sent comes back; " if roll.is_echoed else ""
    return found(
        "L01",
        port,
        f"{echo}nobody answers at {tried} baud, in protocol 1.0 or 2.0",
        "switch the servos' power on (their LEDs blink once), check the cable between adapter and "
        f"first servo, then run `splinearm scan {port}`, which asks every id",
    )


def _misset(servo: ServoSpec, one: Stranger, chain: ServoChain, mend: str) -> Iterator[Finding]:
    where, model = f"servo {servo.servo_id} ({servo.name})", servo.servo_model
    if one.baud != chain.baud:
        code = model.baud_code(chain.baud)
        yield found(
            "L02",
            where,
            f"it answers at {one.baud} baud; the arm's file says {chain.baud}",
            set_register(mend, model, servo.servo_id, "Baud Rate", code),
        )
    wanted = protocol_of(servo, chain.protocol)
    if one.reply.protocol != wanted:
        yield found(
            "L03",
            where,
            f"it speaks protocol {one.reply.protocol}.0; the arm's file says {wanted}.0",
            set_register(mend, model, servo.servo_id, "Protocol Type", wanted)
            if "Protocol Type" in model.table
            else f"write protocol = {one.reply.protocol}.0 into [bus] of the arm's file",
        )


def _missing(
    port: str,
    missing: Sequence[ServoSpec],
    chain: ServoChain,
    strangers: Sequence[Stranger],
    mend: str,
) -> Finding:
    """Say who is missing, and what the order of the servos on the line tells."""
    names = ", ".join(f"{servo.servo_id} ({servo.name})" for servo in missing)
    cause = f"no answer from {'servo' if len(missing) == 1 else 'servos'} {names}"
    tail = chain.servos[len(chain.servos) - len(missing) :]
    remedy = "check its cable and its power; if its LED blinks, its id may be another"
    if len(missing) > 1 and list(tail) == list(missing):
        last = chain.servos[len(chain.servos) - len(missing) - 1]
        cause += f": all that come after servo {last.servo_id} ({last.name})"
        remedy = f"check the cable that leaves servo {last.servo_id} ({last.name})"
    fresh = [one for one in strangers if _is_fresh(one)]
    if fresh:
        model = model_words(fresh[0].reply.model_number)
        cause += f"; a {model} fresh from the factory (id 1, {fresh[0].baud} baud) is there"
        remedy = (
            f"if that is it: {mend}, which gives it id {missing[0].servo_id} and {chain.baud} "
            "baud; else check the cable"
        )
    return found("L04", port, cause, remedy)


def _stranger(one: Stranger, roll: Roll) -> Finding:
    reply = one.reply
    cause = (
        f"a {model_words(reply.model_number)} answers at {one.baud} baud in protocol "
        f"{reply.protocol}.0, and the arm's file does not name it"
    )
    remedy = "unplug it, or add a [[servo]] for it to the arm's file"
    if reply.servo_id in roll.present:
        remedy += f"; its id {reply.servo_id} is taken: give it another first"
    return found("L06", f"servo {reply.servo_id}", cause, remedy)


def _at_odds(one: Stranger, roll: Roll) -> Finding:
    """Make the finding of a servo at another rate than the others, where no file says which."""
    return found(
        "L02",
        f"servo {one.reply.servo_id}",
        f"a {model_words(one.reply.model_number)} answers at {one.baud} baud, others at "
        f"{roll.baud}: one line has one rate",
        "look with --arm ARM, so that the arm's file says which rate is right, or set all to one",
    )


def _is_fresh(one: Stranger) -> bool:
    return one.reply.servo_id == FACTORY_ID and one.baud == _FACTORY_RATE


def _crowd(baud: int, roll: Roll, mend: str) -> Finding:
    """Make the finding of servos that answer together as every one does at first."""
    who = ", ".join(f"{servo.servo_id} ({servo.name})" for servo in roll.silent)
    return found(
        "L05",
        f"servo {FACTORY_ID}",
        f"something answers at {baud} baud, but garbled: several servos have the id {FACTORY_ID}, "
        "as all have fresh out of the box"
        + (f"; the missing {who} may be among them" if who else ""),
        f"{mend}: it lets you connect one after the other and gives each its id",
    )


def shared_id(where: str, silent: Sequence[ServoSpec], mend: str) -> Finding:
    """Make the finding of an id that two servos have."""
    who = ", ".join(f"{servo.servo_id} ({servo.name})" for servo in silent)
    return found(
        "L05",
        where,
        "two servos have this id: their answers clash"
        + (f"; the missing servo {who} may be one of them" if who else ""),
        f"unplug the cable to one of the two and {mend}, which gives the other its own id; then "
        "plug it in again",
    )


def check_pulses(port: str, pulses: dict[int, Pulse], names: dict[int, str]) -> Iterator[Finding]:
    """Say whose answers come damaged or get lost.

    Args:
        port: The port.
        pulses: By id how the servos answered; not those that share an id.
        names: By id how a servo is called.
    """
    for code, what, share in (("L07", "damaged", _DAMAGED), ("L08", "silent", _LOST)):
        counts = {i: int(getattr(pulse, what)) for i, pulse in pulses.items()}
        bad = {
            i: count
            for i, count in counts.items()
            if count >= _FEW and count >= share * pulses[i].asked
        }
        everyone, total = sum(counts.values()), sum(pulse.asked for pulse in pulses.values())
        word = "damaged" if what == "damaged" else "lost"
        if len(bad) == 1 and len(pulses) > 1:
            servo_id, count = next(iter(bad.items()))
            asked = pulses[servo_id].asked
            cause = f"{count} of {asked} answers are {word}, and few or none of the others'"
            remedy = "tighten the plugs at this servo, then change its cable"
            yield found(code, names[servo_id], cause, remedy)
        elif everyone >= _FEW and everyone >= share * total:
            yield found(
                code,
                port,
                f"{everyone} of {total} answers are {word}, from {len(bad) or 'several'} servos",
                "tighten the plugs, keep the cable away from motors and mains, shorten it, or "
                "choose a lower baud rate",
            )


def held_back(
    pulses: dict[int, Pulse], baud: int, protocols: dict[int, int], delays: dict[int, float]
) -> float:
    """Give at ticks of what time something hands answers over, s; 0: not noticeably.

    Asked without a pause, servos behind such a thing answer once a tick.

    Args:
        pulses: By id how the servos answered.
        baud: Bits per second.
        protocols: By id the protocol.
        delays: By id the servo's own delay before an answer, s.
    """
    times: list[float] = []
    excess: list[float] = []
    for servo_id, pulse in pulses.items():
        wire = sum(_PING_BYTES[protocols.get(servo_id, 2)]) * BITS_PER_BYTE / baud
        own = wire + delays.get(servo_id, 0.0)
        times += pulse.seconds
        excess += [seconds - own for seconds in pulse.seconds]
    if len(excess) < 4 or quantiles(excess, n=4)[0] < _HELD:
        return 0.0
    return quantiles(times, n=4)[0]
