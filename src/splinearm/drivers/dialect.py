"""The two protocols as a client speaks them: what to send to one servo, and what comes back."""

from collections.abc import Sequence
from typing import Protocol

from . import packets_v1
from .chain import ServoChain, ServoSpec
from .packets import Decoder, Instruction, Packet, encode
from .packets import read_params as read_params_v2
from .packets import write_params as write_params_v2

_STATUS_V2, _STATUS_V1 = 11, 6
_HIGHEST_V1 = 0xFF


class Listener(Protocol):
    """Takes bytes as they come and finds the status packets in them."""

    def feed(self, data: bytes) -> Sequence[Packet]:
        """Give the status packets that the bytes complete, oldest first."""
        ...

    @property
    def damaged(self) -> bool:
        """Whether something came that was no good packet."""
        ...


class Dialect(Protocol):
    """One protocol, for a client."""

    number: int
    """1 or 2."""
    status_length: int
    """Bytes of a status packet without parameters."""

    def frame(self, servo_id: int, instruction: int, params: bytes = b"") -> bytes:
        """Give the bytes of an instruction packet."""
        ...

    def read_params(self, address: int, length: int) -> bytes:
        """Give the parameters of a read."""
        ...

    def write_params(self, address: int, data: bytes) -> bytes:
        """Give the parameters of a write."""
        ...

    def listener(self) -> Listener:
        """Give something that understands the answers."""
        ...


class ListenerV2:
    """Finds status packets of Protocol 2.0."""

    def __init__(self) -> None:
        self._decoder = Decoder()

    def feed(self, data: bytes) -> list[Packet]:
        """Give the status packets that the bytes complete, oldest first."""
        return [packet for packet in self._decoder.feed(data) if packet.is_status]

    @property
    def damaged(self) -> bool:
        """Whether something came that was no good packet."""
        return bool(self._decoder.crc_errors or self._decoder.pending)


class ListenerV1:
    """Finds status packets of Protocol 1.0, with their errors in the way of 2.0."""

    def __init__(self) -> None:
        self._decoder = packets_v1.Decoder(status=True)

    def feed(self, data: bytes) -> list[Packet]:
        """Give the status packets that the bytes complete, oldest first."""
        return [
            Packet(p.servo_id, Instruction.STATUS, p.params, packets_v1.modern_error(p.error))
            for p in self._decoder.feed(data)
        ]

    @property
    def damaged(self) -> bool:
        """Whether something came that was no good packet."""
        return bool(self._decoder.checksum_errors)


class DialectV2:
    """Protocol 2.0."""

    number = 2
    status_length = _STATUS_V2

    def frame(self, servo_id: int, instruction: int, params: bytes = b"") -> bytes:
        """Give the bytes of an instruction packet."""
        return encode(servo_id, instruction, params)

    def read_params(self, address: int, length: int) -> bytes:
        """Give the parameters of a read."""
        return read_params_v2(address, length)

    def write_params(self, address: int, data: bytes) -> bytes:
        """Give the parameters of a write."""
        return write_params_v2(address, data)

    def listener(self) -> ListenerV2:
        """Give something that understands the answers."""
        return ListenerV2()


class DialectV1:
    """Protocol 1.0: addresses are one byte."""

    number = 1
    status_length = _STATUS_V1

    def frame(self, servo_id: int, instruction: int, params: bytes = b"") -> bytes:
        """Give the bytes of an instruction packet."""
        return packets_v1.encode(servo_id, instruction, params)

    def read_params(self, address: int, length: int) -> bytes:
        """Give the parameters of a read."""
        return bytes((_reachable(address + length - 1) - length + 1, length))

    def write_params(self, address: int, data: bytes) -> bytes:
        """Give the parameters of a write."""
        return bytes((_reachable(address),)) + data

    def listener(self) -> ListenerV1:
        """Give something that understands the answers."""
        return ListenerV1()


DIALECTS: dict[int, Dialect] = {1: DialectV1(), 2: DialectV2()}
"""Both, by number."""


def protocol_of(servo: ServoSpec, usual: float) -> int:
    """Say which protocol a servo speaks.

    Args:
        servo: The servo.
        usual: The protocol of its chain, for models that can speak both and are not told which.
    """
    told = servo.settings.get("Protocol Type")
    if told is not None:
        return told
    known = servo.servo_model.protocols
    return int(usual) if int(usual) in known else known[0]


def protocols_of(chain: ServoChain) -> dict[int, int]:
    """Give by id the protocol of each servo of a chain."""
    return {servo.servo_id: protocol_of(servo, chain.protocol) for servo in chain.servos}


def _reachable(address: int) -> int:
    """Refuse an address that Protocol 1.0 cannot say."""
    if address > _HIGHEST_V1:
        raise ValueError(f"address: Protocol 1.0 reaches 0..{_HIGHEST_V1}, got {address}")
    return address
