"""The checksum of Protocol 2.0: CRC-16/UMTS.

Where the package fastcrc is installed it does the work; else numpy does it for long packets and
plain Python for short ones.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
import numpy.typing as npt

_LONG = 64  # bytes from which the fixed cost of numpy pays
_CHUNK = 256  # bytes that numpy takes at once
_U16: npt.DTypeLike = np.uint16


def _table_entry(high: int) -> int:
    """Give what eight shifts make of a high byte."""
    crc = high << 8
    for _ in range(8):
        crc = (crc << 1) ^ (0x8005 if crc & 0x8000 else 0)
    return crc & 0xFFFF


_TABLE = tuple(_table_entry(high) for high in range(256))


def crc16_plain(data: bytes | bytearray | memoryview, crc: int = 0) -> int:
    """Give the CRC of ``data`` byte by byte, as the manual has it."""
    table = _TABLE
    for byte in data:
        crc = (crc << 8 & 0xFF00) ^ table[crc >> 8 ^ byte]
    return crc


def crc16_numpy(data: bytes | bytearray | memoryview, crc: int = 0) -> int:
    """Give the CRC of ``data`` with numpy: it is linear, so that each byte has a share of it."""
    rest = memoryview(data)
    while len(rest) >= _LONG:
        piece = np.frombuffer(rest[:_CHUNK], dtype=np.uint8)
        n = len(piece)
        shares = _shares()[_CHUNK - n :]
        total = int(np.bitwise_xor.reduce(shares[np.arange(n), piece]))
        # the CRC so far counts like two more bytes, added to the first two
        total ^= int(shares[0, crc >> 8]) ^ int(shares[1, crc & 0xFF])
        crc, rest = total, rest[_CHUNK:]
    return crc16_plain(rest, crc)


@cache
def _shares() -> "np.ndarray[tuple[int, int], np.dtype[np.uint16]]":
    """Give the share of each value of a byte, by how many of 256 bytes precede it."""
    table = np.array(_TABLE, dtype=_U16)
    shares = np.empty((_CHUNK, 256), dtype=np.uint16)
    shares[-1] = table
    for k in range(_CHUNK - 2, -1, -1):
        after = shares[k + 1]
        shares[k] = (after << 8) ^ table[after >> 8]
    return shares


def _quickest() -> Callable[..., int]:
    """Give the quickest of the three that there is."""
    try:
        from fastcrc.crc16 import umts
    except ImportError:
        return crc16_numpy
    return umts


_crc16 = _quickest()


def crc16(data: bytes | bytearray | memoryview, crc: int = 0) -> int:
    """Give the CRC of ``data``, going on from ``crc``.

    Polynomial 0x8005, initial value 0, not reflected, no final xor; on the wire the low byte comes
    first. It covers a packet from its first header byte to its last parameter, after stuffing.
    """
    return _crc16(data, crc)
