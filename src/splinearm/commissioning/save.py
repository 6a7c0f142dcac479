"""The control tables of all servos on a line, read to be kept."""

from collections import Counter
from typing import NamedTuple

from splinearm.drivers.chain import ServoChain
from splinearm.errors import BusTimeoutError, PacketError, SilentBusError

from .backup import Backup, SavedServo
from .bench import Bench, Found
from .image import read_image
from .search import Presence, call_everyone
from .survey import Survey


class Saved(NamedTuple):
    """A backup, and what is not in it."""

    backup: Backup
    """What was read."""
    lacking: tuple[str, ...]
    """What could not be read, in words."""


def save_arm(bench: Bench, arm: str, chain: ServoChain) -> Saved:
    """Read all servos of an arm, and others that hang on its line.

    Raises:
        SilentBusError: If nobody answers.
        BusError: If the port is gone, or a servo is of another model than the file says.
    """
    look = Survey(bench, chain).everywhere()
    names = {one.address: name for name, one in look.match.named.items()}
    servos = tuple(
        SavedServo(names.get(address, str(address)), image)
        for address, image in look.images.items()
    )
    lacking = [f"{servo.name}: no answer as id {servo.servo_id}" for servo in look.missing]
    lacking += [f"{address}: damaged answers only" for address in look.garbled]
    lacking += [f"{one.address}: answers pings alone" for one in look.mute]
    return _saved(bench, arm, servos, lacking)


def save_everyone(bench: Bench) -> Saved:
    """Read whoever is on a line, where no arm's file says who should be.

    Raises:
        SilentBusError: If nobody answers.
        PortError: If the port is gone.
    """
    presence = call_everyone(bench, None)
    servos: list[SavedServo] = []
    lacking = [f"{address}: damaged answers only" for address in presence.garbled]
    names = _names(presence)
    for one in presence.found:
        if one.model is None:
            lacking.append(f"{one.address}: a {one.model_words}, which is not known here")
            continue
        try:
            servos.append(SavedServo(names[one], read_image(bench, one)))
        except (BusTimeoutError, PacketError) as error:
            lacking.append(f"{one.address}: {error}")
    return _saved(bench, "", tuple(servos), lacking)


def _names(presence: Presence) -> dict[Found, str]:
    """Call servos by their ids, and where two have one at different rates by that too."""
    count = Counter(one.address.servo_id for one in presence.found)
    return {
        one: f"servo {one.address.servo_id}"
        if count[one.address.servo_id] == 1
        else str(one.address)
        for one in presence.found
    }


def _saved(bench: Bench, arm: str, servos: tuple[SavedServo, ...], lacking: list[str]) -> Saved:
    if not servos:
        raise SilentBusError(bench.port)
    return Saved(Backup(arm=arm, port=bench.port, servos=servos), tuple(lacking))
