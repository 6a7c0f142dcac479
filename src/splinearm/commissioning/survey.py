"""A look at everyone on the line: who is who, and what each holds."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass

from splinearm.drivers.chain import ServoChain, ServoSpec
from splinearm.errors import BusTimeoutError, PacketError

from .bench import Address, Bench, Found
from .identify import Match, match
from .image import ControlImage, read_image
from .search import call_at, call_everyone, call_file, factory_baud, rare_rates, usual_rates


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Look:
    """Who is on the line and what they hold."""

    match: Match
    """Who is who."""
    images: dict[Address, ControlImage]
    """By address what servos hold."""
    garbled: tuple[Address, ...]
    """From where only damaged answers come."""
    mute: tuple[Found, ...]
    """Servos that answer pings alone."""

    @property
    def missing(self) -> tuple[ServoSpec, ...]:
        """The servos of the file of which nothing at all is heard."""
        heard = {one.address.servo_id for one in self.mute}
        return tuple(servo for servo in self.match.missing if servo.servo_id not in heard)


class Survey:
    """Looks at a line for the servos of an arm's file.

    Args:
        bench: The line.
        chain: The servos.
        settled: Names of servos that are where they shall be; whoever looks adds to them.
        one_by_one: Whether to believe the ids of no others.
    """

    def __init__(
        self,
        bench: Bench,
        chain: ServoChain,
        settled: Collection[str] = (),
        *,
        one_by_one: bool = False,
    ) -> None:
        self._bench = bench
        self._chain = chain
        self._settled = settled
        self.one_by_one = one_by_one
        """Whether to believe the ids of no others than those that are settled."""

    def everywhere(self) -> Look:
        """Look where all should be; if they are not all there, everywhere.

        Raises:
            BusError: If the port is gone, or a servo is of another model than the file says.
        """
        look = self.in_place()
        if look is not None:
            return look
        presence = call_everyone(self._bench, self._chain, until_all=True)
        look = self._understood(presence.found, presence.garbled)
        crowded = bool(look.garbled)  # they are to be connected one by one, wherever others are
        if not look.match.missing or not presence.found or crowded:
            return look
        return self.far()

    def in_place(self) -> Look | None:
        """Look where all should be, which takes a moment; None: they are not all there."""
        presence = call_file(self._bench, self._chain)
        if len(presence.found) < len(self._chain.servos):
            return None
        look = self._understood(presence.found, presence.garbled)
        return None if look.match.missing else look

    def near(self, *, alone: bool = False) -> Look:
        """Look at the rates at which servos are before and after they are set up.

        Args:
            alone: Whether one servo shall be there alone. It may be a new one in the place of one
                that is settled, where no ids are believed.
        """
        rates = (*(factory_baud(s.servo_model) for s in self._chain.servos), self._chain.baud)
        presence = call_everyone(
            self._bench, self._chain, tuple(dict.fromkeys(rates)), thorough=False
        )
        return self._understood(presence.found, presence.garbled, alone=alone)

    def far(self, *, alone: bool = False) -> Look:
        """Look at all rates that the servos have; as ``near``."""
        rates = (*usual_rates(self._chain), *rare_rates(self._chain))
        presence = call_everyone(self._bench, self._chain, rates)
        return self._understood(presence.found, presence.garbled, alone=alone)

    def _understood(
        self, found: Iterable[Found], garbled: Iterable[Address], *, alone: bool = False
    ) -> Look:
        """Read everyone, and say who is who."""
        images: dict[Address, ControlImage] = {}
        clear: list[Found] = []
        shared = list(garbled)
        mute: list[Found] = []
        for one in found:
            try:
                if one.model is not None:
                    images[one.address] = self._image(one)
                clear.append(one)
            except PacketError:
                shared.append(one.address)
            except BusTimeoutError:
                mute += call_at(self._bench, [one.address]).found  # or it was just unplugged
        settled = () if alone and self.one_by_one else self._settled
        return Look(
            match=match(clear, self._chain, settled, one_by_one=self.one_by_one),
            images=images,
            garbled=tuple(shared),
            mute=tuple(mute),
        )

    def _image(self, one: Found) -> ControlImage:
        """Read a servo, once more if it was just about to wake up."""
        try:
            return read_image(self._bench, one)
        except BusTimeoutError:
            if not call_at(self._bench, [one.address]).found:
                raise
            return read_image(self._bench, one)
