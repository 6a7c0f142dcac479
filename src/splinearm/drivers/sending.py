"""Writes to many servos, prebuilt: what a control loop sends in every cycle."""

import struct
from collections.abc import Sequence
from typing import NamedTuple

from .crc import crc16
from .gauge import pack_code
from .layout import Field, block_length
from .packets import BROADCAST_ID, HEADER, Instruction, encode
from .registers import Register

_MARK = b"\xff\xff\xfd"  # bytes that need stuffing
_PLAIN_LENGTH = 2048  # longer ones are for the encoder to judge


class Block(NamedTuple):
    """What a group write gives to one servo."""

    servo_id: int
    """The servo."""
    address: int
    """Where it begins."""
    fields: tuple[Field, ...]
    """The registers that it fills, and bytes that mean nothing."""


class GroupWrite:
    """One write of values to registers of each of many servos.

    Args:
        targets: Id and register of each servo, or a block of registers; ids differ. The same place
            in every servo makes a sync write, different places a bulk write.
    """

    def __init__(self, targets: Sequence[tuple[int, Register] | Block]) -> None:
        blocks = [_block(target) for target in targets]
        self.blocks = tuple(blocks)
        """What is written to each servo."""
        self.ids = tuple(block.servo_id for block in blocks)
        """Ids in the order of the values."""
        if not self.ids or len(set(self.ids)) != len(self.ids):
            raise ValueError(f"targets: want one for each of some servos, got {self.ids}")
        lengths = [block_length(block.fields) for block in blocks]
        same = len({(b.address, n) for b, n in zip(blocks, lengths, strict=True)}) == 1
        self.instruction = Instruction.SYNC_WRITE if same else Instruction.BULK_WRITE
        """What is sent."""
        first = struct.pack("<HH", blocks[0].address, lengths[0]) if same else b""
        self._fixed = bytes((self.instruction,)) + first
        self._params: list[int] = []
        self._places: list[int] = []
        code = "<"
        for block, length in zip(blocks, lengths, strict=True):
            self._params += [block.servo_id] if same else [block.servo_id, block.address, length]
            code += ("B" if same else "BHH") + pack_code(block.fields)
            values = sum(isinstance(field, Register) for field in block.fields)
            self._places += range(len(self._params), len(self._params) + values)
            self._params += [0] * values
        self._pack = struct.Struct(code)
        size = len(self._fixed) + self._pack.size + 2
        self._head = HEADER + bytes((BROADCAST_ID, size & 0xFF, size >> 8 & 0xFF)) + self._fixed
        self.values = len(self._places)
        """How many values it takes."""

    def frame(self, values: Sequence[int]) -> bytes:
        """Give the bytes that write these values, servo by servo in the order of ``ids``.

        Raises:
            ValueError: If there are not as many values as registers, or one cannot hold its value.
        """
        if len(values) != self.values:
            raise ValueError(f"values: want {self.values} of them, got {len(values)}")
        params = self._params
        for place, value in zip(self._places, values, strict=True):
            params[place] = value
        try:
            blocks = self._pack.pack(*params)
        except struct.error as error:
            raise ValueError(f"values: {error}, got {list(values)}") from error
        if _MARK in self._fixed[-2:] + blocks or len(blocks) > _PLAIN_LENGTH:
            return encode(BROADCAST_ID, self.instruction, self._fixed[1:] + blocks)
        frame = self._head + blocks
        return frame + crc16(frame).to_bytes(2, "little")


def shares(blocks: Sequence[Block], values: Sequence[int]) -> list[Sequence[int]]:
    """Give the values of each block."""
    rest = iter(values)
    return [[next(rest) for f in b.fields if isinstance(f, Register)] for b in blocks]


def _block(target: tuple[int, Register] | Block) -> Block:
    if isinstance(target, Block):
        return target
    servo_id, register = target
    return Block(servo_id, register.address, (register,))
