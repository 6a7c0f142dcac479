"""A serial port or a socket as bytes: send a packet, wait for exactly the bytes that answer it.

Waiting sleeps in the kernel; it ends with the last byte or at a deadline that follows from the time
the bytes take on the wire.
"""

import contextlib
import os
import select
import socket
import stat
import termios
import time
from pathlib import Path

from splinearm.errors import PortError

BITS_PER_BYTE = 10
"""Start bit, eight data bits, stop bit."""
RETURN_DELAY = 5e-4
"""Longest time a servo waits before it answers (factory setting of Return Delay Time), s."""
PROMPT = 1e-3
"""How late an answer comes where no adapter holds it back, s."""
_CHUNK = 4096
_GONE = select.POLLHUP | select.POLLERR | select.POLLNVAL


SOCKET_PREFIX = "unix:"
"""What the name of a port begins with that is the path of a socket."""


def is_socket(port: str) -> bool:
    """Say whether a port is a socket, by its name or by what lies there."""
    if port.startswith(SOCKET_PREFIX):
        return True
    try:
        return stat.S_ISSOCK(Path(port).stat().st_mode)
    except OSError:
        return False


class SerialLink:
    """An open serial port.

    Args:
        port: Its name, for errors.
        fd: Its file descriptor, in raw mode and not blocking.
        baud: Bits per second.
        margin: How long an answer may come later than the wire needs, s.
        prompt: How long one of a servo that has not answered of late may, s.
    """

    def __init__(
        self, port: str, fd: int, baud: int, margin: float, prompt: float = PROMPT
    ) -> None:
        self.port = port
        self.baud = baud
        self.margin = margin
        self.prompt = min(prompt, margin)
        self._fd = fd
        self._ends_empty = False
        self._poll = select.poll()
        self._poll.register(fd, select.POLLIN)

    def close(self) -> None:
        """Forget the port, so that nothing is ever sent to what gets its number next."""
        if self._fd >= 0:
            self._poll.unregister(self._fd)
            self._fd = -1

    def deadline(self) -> float:
        """Say until when to wait for bytes that should be here now, monotonic clock, s."""
        return time.monotonic() + self.margin

    def soon(self, answers: int, answer_bytes: int) -> float:
        """Say until when to wait for bytes of servos that may be dead, monotonic clock, s."""
        wire = answer_bytes * BITS_PER_BYTE / self.baud
        return time.monotonic() + self.prompt + wire + answers * RETURN_DELAY

    def send(self, frame: bytes, answers: int = 0, answer_bytes: int = 0) -> float:
        """Send a packet, after throwing away what came unasked before.

        Args:
            frame: The packet.
            answers: How many servos will answer it.
            answer_bytes: How many bytes they will send in all.

        Returns:
            Until when the answer must have come, on the monotonic clock, s.

        Raises:
            PortError: If the port is gone.
        """
        try:
            self._drain()
            sent = self._write(frame)
            while sent < len(frame):
                sent += self._write(frame[sent:])
        except (OSError, termios.error, ValueError) as error:
            raise self.gone(error) from error
        wire = (len(frame) + answer_bytes) * BITS_PER_BYTE / self.baud
        return self.deadline() + wire + answers * RETURN_DELAY

    def receive(self, count: int, deadline: float) -> bytes:
        """Give the next ``count`` bytes, or as many as come until the deadline; perhaps a few more.

        Raises:
            PortError: If the port is gone.
        """
        data = self.receive_some(deadline)
        if not data or len(data) >= count:
            return data
        pieces, length = [data], len(data)
        while length < count:
            data = self.receive_some(deadline)
            if not data:
                break
            pieces.append(data)
            length += len(data)
        return b"".join(pieces)

    def receive_some(self, deadline: float) -> bytes:
        """Give what comes next; nothing if nothing comes until the deadline.

        Raises:
            PortError: If the port is gone.
        """
        if self._fd < 0:
            raise self.gone("it was closed")
        while True:
            left = deadline - time.monotonic()
            events: list[tuple[int, int]] = []
            try:
                events = self._poll.poll(max(left, 0.0) * 1e3)
                data = os.read(self._fd, _CHUNK) if events else b""
            except BlockingIOError:
                data = b""
            except (OSError, ValueError) as error:
                raise self.gone(error) from error
            if data:
                return data
            if events and (events[0][1] & _GONE or self._ends_empty):
                raise self.gone("the device hung up")
            if not events or left <= 0.0:
                return b""

    def _drain(self) -> None:
        """Throw away what came unasked."""
        termios.tcflush(self._fd, termios.TCIFLUSH)

    def _write(self, data: bytes) -> int:
        """Give the port as many bytes as it takes, after waiting for room if it takes none."""
        try:
            return os.write(self._fd, data)
        except BlockingIOError:
            writable = select.poll()
            writable.register(self._fd, select.POLLOUT)
            writable.poll(self.margin * 1e3)
            return os.write(self._fd, data)

    def gone(self, cause: object) -> PortError:
        """Make the error of a port that is not there any more."""
        return PortError(
            self.port,
            f"the connection is lost ({cause})",
            "check the cable and the power of the adapter, then reconnect, or start again",
        )


class SocketLink(SerialLink):
    """A unix socket that stands for a serial port; open from construction to ``close``.

    Args:
        port: Its name: ``unix:`` and the path.
        baud: Bits per second that the other end counts with.
        margin: How long an answer may come later than the wire needs, s.

    Raises:
        PortError: If nobody serves that path.
    """

    def __init__(self, port: str, baud: int, margin: float) -> None:
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self._socket.connect(port.removeprefix(SOCKET_PREFIX))
        except OSError as error:
            self._socket.close()
            raise PortError(
                port, f"nobody serves it ({error.strerror})", "start what serves it, then this"
            ) from error
        os.set_blocking(self._socket.fileno(), False)
        super().__init__(port, self._socket.fileno(), baud, margin)
        self._ends_empty = True

    def close(self) -> None:
        """Leave; leaving twice is no error."""
        super().close()
        self._socket.close()

    def _drain(self) -> None:
        with contextlib.suppress(BlockingIOError):
            while os.read(self._fd, _CHUNK):
                pass
