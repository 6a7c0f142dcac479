"""The group reads that ask those who are there, and who gets which answer."""

from collections.abc import Mapping, Sequence

from splinearm.doctor.stethoscope import Stethoscope
from splinearm.drivers.bus import ReadGroup, Reply
from splinearm.drivers.cyclic import GroupRead
from splinearm.drivers.cyclic_v1 import BulkReadV1, OneRead
from splinearm.drivers.groups import BulkRead

from .block import Block
from .watched import Watched


class Round:
    """The reads of some servos: one group read in every cycle where the servos permit it.

    Args:
        servos: Those who are there; each has a motion block.
    """

    def __init__(self, servos: Sequence[Watched]) -> None:
        self.servos = list(servos)
        """Those who are asked."""
        self._alone = [servo.is_alone for servo in servos]
        self._motion = _groups(self.servos, {s.servo_id: _motion_of(s) for s in self.servos})
        self.slow_count = max((len(servo.slow) for servo in self.servos), default=0)
        """How many reads what changes slowly takes."""
        self._blocks = [
            {s.servo_id: s.slow[k] for s in self.servos if k < len(s.slow)}
            for k in range(self.slow_count)
        ]
        self._slow = [_groups(self.servos, blocks) for blocks in self._blocks]

    def is_for(self, servos: Sequence[Watched]) -> bool:
        """Say whether it asks just these, in the way that they answer."""
        return self.servos == servos and self._alone == [servo.is_alone for servo in servos]

    def ask_motion(self, bus: Stethoscope, t: float) -> None:
        """Ask all how they move; t on the monotonic clock, s.

        Raises:
            PortError: If the port is gone.
        """
        replies = _ask(bus, self._motion)
        for servo in self.servos:
            servo.take_motion(replies[servo.servo_id], t)

    def ask_slow(self, bus: Stethoscope, turn: int) -> list[Watched]:
        """Ask for one of the blocks that change slowly.

        Returns:
            Those whose registers should be read anew.

        Raises:
            PortError: If the port is gone.
        """
        if turn >= self.slow_count:
            return []
        blocks, replies = self._blocks[turn], _ask(bus, self._slow[turn])
        for servo in self.servos:
            servo.is_stale = False  # of who did not answer just now more is known in a second
        return [
            servo
            for servo in self.servos
            if servo.servo_id in blocks
            and servo.take_slow(blocks[servo.servo_id], replies[servo.servo_id])
        ]


def _motion_of(servo: Watched) -> Block:
    if servo.motion is None:
        raise ValueError(f"servos: want those who are there, got {servo.name}")
    return servo.motion.block


def _groups(servos: Sequence[Watched], blocks: Mapping[int, Block]) -> list[ReadGroup]:
    """Make the reads that bring a block of each servo."""
    asked = [servo for servo in servos if servo.servo_id in blocks]
    modern = [s for s in asked if s.protocol == 2 and not s.is_alone]
    old = [s for s in asked if s.protocol == 1 and not s.is_alone and _knows_bulk(s)]
    groups: list[ReadGroup] = []
    if modern:
        fast = all(s.model is not None and s.model.has_fast_read(s.firmware) for s in modern)
        groups.append(GroupRead([_request(s, blocks) for s in modern], fast=fast))
    if old:
        groups.append(BulkReadV1([_request(s, blocks) for s in old]))
    single = [s for s in asked if s not in modern and s not in old]
    groups += [OneRead(_request(s, blocks), s.protocol) for s in single]
    return groups


def _knows_bulk(servo: Watched) -> bool:
    """Say whether a servo may know bulk reads in Protocol 1.0: of the old models only MX do."""
    return servo.model is not None and 2 in servo.model.protocols


def _request(servo: Watched, blocks: Mapping[int, Block]) -> BulkRead:
    block = blocks[servo.servo_id]
    return BulkRead(servo.servo_id, block.address, block.length)


def _ask(bus: Stethoscope, groups: Sequence[ReadGroup]) -> dict[int, Reply]:
    """Ask, and give by id what came."""
    replies: dict[int, Reply] = {}
    for group in groups:
        replies |= bus.sync_read(group)
    return replies
