"""Taking hold of a serial port, with a clear word when it cannot be had."""

import errno
import fcntl
import os
import stat
import weakref
from pathlib import Path

from splinearm.errors import PortError


class PortLock:
    """The exclusive right to a serial port, from construction to ``release`` or its own end.

    It is an advisory lock (flock): it keeps out other arms of this package and every program that
    asks, as pyserial does with ``exclusive=True``. It is taken before the port is touched.

    Raises:
        PortError: If the port is missing, forbidden, no serial port, or in use.
    """

    def __init__(self, port: str) -> None:
        try:
            fd = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK | os.O_CLOEXEC)
        except OSError as error:
            raise open_error(port, error) from error
        self._close = weakref.finalize(self, os.close, fd)
        try:
            _require_serial_port(port, fd)
            fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            self.release()
            raise open_error(port, error) from error
        except PortError:
            self.release()
            raise

    def release(self) -> None:
        """Give the right back. Giving it back twice is no error."""
        self._close()


def _require_serial_port(port: str, fd: int) -> None:
    """Refuse a file that is no terminal."""
    if not stat.S_ISCHR(os.fstat(fd).st_mode) or not os.isatty(fd):
        raise PortError(port, "it is not a serial port", _name_the_device())


def open_error(port: str, error: OSError) -> PortError:
    """Say why a port cannot be opened, and what helps."""
    number = error.errno
    if number in (errno.ENOENT, errno.ENXIO, errno.ENODEV, errno.EIO):
        return PortError(port, "there is no such port", _name_the_device())
    if number in (errno.EACCES, errno.EPERM):
        return PortError(
            port,
            "you may not open it",
            "run `sudo usermod -aG dialout $USER`, then log out and in again",
        )
    if number in (errno.EBUSY, errno.EAGAIN, errno.EWOULDBLOCK):
        return PortError(port, "another program uses it", "close that program, then start again")
    return PortError(port, os.strerror(number) if number else str(error), _name_the_device())


def latency_file(port: str) -> Path:
    """Give the kernel's file that says how long a port's USB adapter holds bytes back.

    Args:
        port: Name of the port; links are followed.
    """
    return Path(f"/sys/class/tty/{Path(os.path.realpath(port)).name}/device/latency_timer")


def usb_latency(path: Path) -> float:
    """Give the time that such a file says, s; 0 without a file, as for ports of no adapter."""
    try:
        return int(path.read_text(encoding="ascii")) * 1e-3
    except (OSError, ValueError):
        return 0.0


def by_id_link(port: str, folder: Path = Path("/dev/serial/by-id")) -> Path | None:
    """Give the link that udev keeps for the adapter of a port, by maker, kind and serial number.

    It leads to the adapter whatever its port is called when it is plugged in again.

    Args:
        port: Name of the port; links are followed.
        folder: Where udev keeps those links.
    """
    if not folder.is_dir():
        return None
    device = os.path.realpath(port)
    links = (link for link in sorted(folder.iterdir()) if os.path.realpath(link) == device)
    return next(links, None)


def _name_the_device() -> str:
    """Say what to do about a wrong or missing port."""
    present = sorted(
        str(path)
        for pattern in ("ttyUSB*", "ttyACM*", "ttyDXL*")
        for path in Path("/dev").glob(pattern)
    )
    found = f"; found: {', '.join(present)}" if present else ""
    return f"plug the adapter in, switch its power on, or name another port{found}"
