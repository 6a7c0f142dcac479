"""The checksum of Protocol 2.0: CRC-16/UMTS."""


def _table_entry(high: int) -> int:
    """Give what eight shifts make of a high byte."""
    crc = high << 8
    for _ in range(8):
        crc = (crc << 1) ^ (0x8005 if crc & 0x8000 else 0)
    return crc & 0xFFFF


_TABLE = tuple(_table_entry(high) for high in range(256))


def crc16(data: bytes | bytearray | memoryview, crc: int = 0) -> int:
    """Give the CRC of ``data``, going on from ``crc``.

    Polynomial 0x8005, initial value 0, not reflected, no final xor; on the wire the low byte comes
    first. It covers a packet from its first header byte to its last parameter, after stuffing.
    """
    table = _TABLE
    for byte in data:
        crc = (crc << 8 & 0xFF00) ^ table[crc >> 8 ^ byte]
    return crc
