"""A unix stream socket as a port: quicker and steadier than a pseudo terminal, for our own clients.

Clients connect to the path in ``name``, one at a time: the next is served once the last has left.
A socket knows no baud rate: clients speak at the rate that the port is given.
"""

import contextlib
import os
import select
import socket
import tempfile
from pathlib import Path

PREFIX = "unix:"
"""What a port's name begins with that is the path of a socket."""

_CHUNK = 4096


class SocketPort:
    """The servos' end of a unix stream socket in a private folder."""

    def __init__(self, baud: int) -> None:
        """Listen.

        Args:
            baud: The rate at which clients speak.

        Raises:
            OSError: If there is no room for it.
        """
        self.baud = baud
        """The rate at which clients speak."""
        self.lost_bytes = 0
        """Bytes that were thrown away because no client fetched those before them."""
        self._folder = Path(tempfile.mkdtemp(prefix="splinearm-"))
        path = self._folder / "bus"
        self.name = f"{PREFIX}{path}"
        """What a client opens."""
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._listener.bind(str(path))
        self._listener.listen(8)
        self._listener.settimeout(0.0)
        self._client: socket.socket | None = None
        self._coming: list[socket.socket] = []
        self._wake_read, self._wake_write = os.pipe()

    def connect(self) -> socket.socket:
        """Give one end of a socket pair whose other end is served once the last client has left."""
        ours, theirs = socket.socketpair()
        ours.settimeout(0.0)
        self._coming.append(ours)
        self.wake()
        return theirs

    def close(self) -> None:
        """Close it; clients see it hang up."""
        for each in (self._listener, self._client, *self._coming):
            if each is not None:
                each.close()
        os.close(self._wake_read)
        os.close(self._wake_write)
        with contextlib.suppress(FileNotFoundError):
            Path(self.name.removeprefix(PREFIX)).unlink()
            self._folder.rmdir()

    def wake(self) -> None:
        """Let a waiting ``read`` return; may be called from any thread."""
        os.write(self._wake_write, b"\0")

    def read(self, timeout: float) -> bytes:
        """Give what has come, waiting for it for at most ``timeout`` seconds; empty: nothing."""
        if self._client is None and self._coming:
            self._client = self._coming.pop(0)
        client = self._client
        end = (self._listener if client is None else client).fileno()
        ready, _, _ = select.select((end, self._wake_read), (), (), timeout)
        if self._wake_read in ready:
            os.read(self._wake_read, _CHUNK)
        if end not in ready:
            return b""
        if client is None:
            self._accept()
            return b""
        return self._receive(client)

    def write(self, data: bytes) -> None:
        """Send bytes; those for which there is no room, or no client, are lost."""
        sent = 0
        if self._client is not None:
            with contextlib.suppress(BlockingIOError, BrokenPipeError, ConnectionError):
                sent = self._client.send(data)
        self.lost_bytes += len(data) - sent

    def _accept(self) -> None:
        with contextlib.suppress(BlockingIOError):
            self._client, _ = self._listener.accept()
            self._client.settimeout(0.0)

    def _receive(self, client: socket.socket) -> bytes:
        """Give what a client sent; nothing if it has left."""
        data = b""
        with contextlib.suppress(ConnectionError):
            data = client.recv(_CHUNK)
        if not data:
            client.close()
            self._client = None
        return data
