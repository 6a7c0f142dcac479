"""Which of the servos that answered is which of the arm's file."""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

from splinearm.doctor.roll import FACTORY_ID
from splinearm.drivers.chain import ServoChain, ServoSpec
from splinearm.errors import ServoError

from .bench import Found
from .search import factory_baud, target_of


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Match:
    """Who is who."""

    named: Mapping[str, Found]
    """By the name of a servo of the file who it is."""
    missing: tuple[ServoSpec, ...]
    """Servos of the file that nobody is known to be."""
    unknown: tuple[Found, ...]
    """Servos that may be one of several that are missing."""
    strangers: tuple[Found, ...]
    """Servos that the file does not name."""


def match(
    found: Sequence[Found],
    chain: ServoChain,
    settled: Collection[str] = (),
    *,
    one_by_one: bool = False,
) -> Match:
    """Tell servos by their ids and models; of those that have no id yet, by their models alone.

    An id counts, at any rate, unless it is the one that every servo has from the factory. A servo
    without one is told by its model where only one such is missing and only one is there.

    Args:
        found: The servos that answered.
        chain: The servos of the file.
        settled: Names of servos that are where they shall be, if they are there at all.
        one_by_one: Whether to believe the ids of no others.

    Raises:
        ServoError: If in the place of a servo there is one of another model, with both.
    """
    waiting = {servo.name: servo for servo in chain.servos}
    named: dict[str, Found] = {}
    left = list(found)
    firm = {s.name for s in chain.servos if s.name in settled and not _looks_fresh(s, chain)}

    def take(servo: ServoSpec, one: Found) -> None:
        named[servo.name] = one
        left.remove(one)
        del waiting[servo.name]

    for is_it in (_is_in_place, _has_its_id):
        for servo in tuple(waiting.values()):
            if servo.name in firm:
                ones = [one for one in left if one.address == target_of(servo, chain)]
            else:
                ones = [one for one in left if is_it(servo, one, chain) and not one_by_one]
            if len(ones) == 1:
                take(servo, ones[0])
    if not one_by_one:
        for servo, one in _by_model(waiting.values(), left, firm):
            take(servo, one)
    missing = list(waiting.values())
    _refuse_other_models(missing, left, chain)
    numbers = {servo.servo_model.number for servo in missing}
    return Match(
        named=named,
        missing=tuple(missing),
        unknown=tuple(one for one in left if one.model_number in numbers),
        strangers=tuple(one for one in left if one.model_number not in numbers),
    )


def _is_in_place(servo: ServoSpec, one: Found, chain: ServoChain) -> bool:
    """Tell whether a servo answers where the file says, and not just because all do at first."""
    if one.address != target_of(servo, chain) or not _is_model(servo, one):
        return False
    return not _may_be_fresh(servo, one) or len(chain.servos) == 1


def _has_its_id(servo: ServoSpec, one: Found, _: ServoChain) -> bool:
    """Tell whether a servo has the id of the file, at another rate or in another protocol."""
    same = one.address.servo_id == servo.servo_id and _is_model(servo, one)
    return same and not _may_be_fresh(servo, one)


def _by_model(
    waiting: Iterable[ServoSpec], left: Sequence[Found], firm: Collection[str]
) -> list[tuple[ServoSpec, Found]]:
    """Tell those of whose model there is one only."""
    open_ones = [servo for servo in waiting if servo.name not in firm]
    there = Counter(one.model_number for one in left)
    wanted = Counter(servo.servo_model.number for servo in open_ones)
    return [
        (servo, one)
        for servo in open_ones
        for one in left
        if one.model_number == servo.servo_model.number
        and there[one.model_number] == wanted[one.model_number] == 1
    ]


def _refuse_other_models(
    missing: Sequence[ServoSpec], left: Sequence[Found], chain: ServoChain
) -> None:
    """Refuse a servo in the place of one of another model, if it cannot be one that is missing."""
    numbers = {servo.servo_model.number for servo in missing}
    for servo in missing:
        for one in left:
            in_place = one.address.servo_id == servo.servo_id and not _may_be_fresh(servo, one)
            if in_place and one.model_number not in numbers:
                raise other_model(servo, one)


def other_model(servo: ServoSpec, one: Found) -> ServoError:
    """Make the error of a servo that is of another model than the file says."""
    return ServoError(
        one.address.servo_id,
        f"found a {one.model_words} ({one.address}), the arm's file says {servo.model}: put the "
        "right servo there, or correct the model in the arm's file",
        name=servo.name,
    )


def _is_model(servo: ServoSpec, one: Found) -> bool:
    return one.model_number == servo.servo_model.number


def _looks_fresh(servo: ServoSpec, chain: ServoChain) -> bool:
    """Tell whether a servo is, set up, where every one of its model is fresh out of the box."""
    is_first = servo.servo_id == FACTORY_ID
    return is_first and chain.baud == factory_baud(servo.servo_model)


def _may_be_fresh(servo: ServoSpec, one: Found) -> bool:
    """Tell whether a servo answers as every one of its model does fresh out of the box."""
    address = one.address
    return address.servo_id == FACTORY_ID and address.baud == factory_baud(servo.servo_model)
