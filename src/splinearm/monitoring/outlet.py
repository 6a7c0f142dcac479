"""Where samples go: JSON lines, a CSV file, datagrams."""

import csv
import json
import socket
from pathlib import Path
from types import TracebackType
from typing import IO, Protocol, Self

from splinearm.errors import ConfigError

from .document import Document, flat


class Outlet(Protocol):
    """Something that takes the documents of samples; closed at the end."""

    def take(self, document: Document) -> None:
        """Take one."""
        ...

    def close(self) -> None:
        """Take no more."""
        ...


def line_of(document: Document) -> str:
    """Give a document as one line of JSON, without its end."""
    return json.dumps(document, separators=(",", ":"), allow_nan=False)


class JsonLines:
    """One object a line.

    Args:
        stream: Where the lines go; it is flushed after each.
    """

    def __init__(self, stream: IO[str]) -> None:
        self._stream = stream

    def take(self, document: Document) -> None:
        """Write one."""
        self._stream.write(line_of(document) + "\n")
        self._stream.flush()

    def close(self) -> None:
        """Do nothing: the stream is somebody else's."""


class CsvFile:
    """One row a sample, under the names of its columns.

    Args:
        file: Where to write; it must not be there yet, and without a sample it will not be.

    Raises:
        ConfigError: If it is there already or cannot be written.
    """

    def __init__(self, file: Path) -> None:
        self._file = file
        self._columns: list[str] = []
        try:
            self._stream = file.open("x", newline="", encoding="utf-8")
        except FileExistsError as error:
            reason = "is there already and is not overwritten; name another"
            raise ConfigError(file, "", reason) from error
        except OSError as error:
            raise ConfigError(file, "", f"cannot be written: {error.strerror}") from error
        self._writer = csv.writer(self._stream)

    def take(self, document: Document) -> None:
        """Write one."""
        row = flat(document)
        if not self._columns:
            self._columns = list(row)
            self._writer.writerow(self._columns)
        self._writer.writerow([row[name] for name in self._columns])
        self._stream.flush()

    def close(self) -> None:
        """Close the file."""
        self._stream.close()
        if not self._columns:
            self._file.unlink(missing_ok=True)


class Datagrams:
    """One datagram a sample, with the same object as a line of JSON has: for PlotJuggler.

    Who does not listen misses them; nothing waits for anybody.

    Args:
        where: "HOST:PORT", or "[::1]:PORT".

    Raises:
        ConfigError: If there is no such address.
    """

    def __init__(self, where: str) -> None:
        host, port = _host_and_port(where)
        try:
            found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
        except OSError as error:
            raise ConfigError(
                "--udp", "", f"{host!r} is not known here: {error.strerror}"
            ) from error
        family, kind, protocol, _, address = found[0]
        self._address = address
        self._socket = socket.socket(family, kind, protocol)
        self._socket.settimeout(0.0)
        self.unsent = 0
        """How many this computer could not send."""

    def take(self, document: Document) -> None:
        """Send one."""
        try:
            self._socket.sendto(line_of(document).encode(), self._address)
        except OSError:  # no room or no way now; the next may have one
            self.unsent += 1

    def close(self) -> None:
        """Send no more."""
        self._socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _host_and_port(where: str) -> tuple[str, int]:
    host, colon, port = where.rpartition(":")
    if not (colon and host and port.isdigit() and 0 < int(port) < 65536):
        reason = f"want HOST:PORT with a port of 1 to 65535, as in localhost:9870, got {where!r}"
        raise ConfigError("--udp", "", reason)
    return host.removeprefix("[").removesuffix("]"), int(port)
