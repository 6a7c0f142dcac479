"""A pseudo terminal as a serial port: bytes in and out, and the baud rate that the client set."""

import contextlib
import fcntl
import os
import select
import struct
import termios
import tty

_TCGETS2 = 0x802C542A  # Linux; where it is another number, the ioctl fails and we ask as others do
_TERMIOS2 = struct.Struct("4IB19s2I")
_CHUNK = 4096


class PtyPort:
    """The servos' end of a pseudo terminal. Clients open ``name``, as often as they like."""

    def __init__(self) -> None:
        """Open it.

        Raises:
            OSError: If the system has no pseudo terminal left.
        """
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self._wake_read, self._wake_write = os.pipe()
        self._ends = (self._master, self._wake_read)
        self.name = os.ttyname(self._slave)
        """What a client opens."""
        self.lost_bytes = 0
        """Bytes that were thrown away because no client fetched those before them."""

    def close(self) -> None:
        """Close it; clients see it hang up."""
        for end in (self._master, self._slave, self._wake_read, self._wake_write):
            os.close(end)

    def wake(self) -> None:
        """Let a waiting ``read`` return; may be called from any thread."""
        os.write(self._wake_write, b"\0")

    def read(self, timeout: float) -> bytes:
        """Give what has come, waiting for it for at most ``timeout`` seconds; empty: nothing."""
        ready, _, _ = select.select(self._ends, (), (), timeout)
        if self._wake_read in ready:
            os.read(self._wake_read, _CHUNK)
        if self._master not in ready:
            return b""
        return os.read(self._master, _CHUNK)

    def write(self, data: bytes) -> None:
        """Send bytes; those for which there is no room are lost, as on a wire nobody listens to."""
        sent = 0
        with contextlib.suppress(BlockingIOError):
            sent = os.write(self._master, data)
        self.lost_bytes += len(data) - sent

    @property
    def baud(self) -> int:
        """The baud rate that the client set."""
        with contextlib.suppress(OSError):
            raw = fcntl.ioctl(self._slave, _TCGETS2, bytes(_TERMIOS2.size))
            return int(_TERMIOS2.unpack(raw)[-1])
        code: int = termios.tcgetattr(self._slave)[5]
        return _BAUDS.get(code, code)


_BAUDS: dict[int, int] = {
    getattr(termios, name): int(name[1:])
    for name in dir(termios)
    if name.startswith("B") and name[1:].isdigit()
}
"""Baud rate of each of the system's codes."""
