"""A line of DYNAMIXEL servos behind a serial port: the only file that knows the maker's SDK.

The SDK opens the port, for which its list of rates is good. All that goes out and comes in goes
through our own codec on that port: the SDK (4.1.0) throws the result of its byte stuffing away,
polls without sleeping, and one servo that does not answer costs it the answers of all others.
"""

import logging
import termios
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Self

from splinearm.errors import PortError

from .bus import PingReply
from .chain import MAX_SERVO_ID
from .client import QUIET_SLOTS, ServoClient
from .link import PROMPT, SerialLink, SocketLink, is_socket
from .model import servo_model_by_number
from .port import PortLock, by_id_link, latency_file, open_error, usb_latency

if TYPE_CHECKING:
    from dynamixel_sdk import PortHandler

_log = logging.getLogger(__name__)

DEFAULT_BAUDS = (57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000)
"""Rates at which servos are usually found."""
_SDK_RATES = (9_600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000)
_SDK_TOO_FAST = (4_500_000, 6_000_000, 10_500_000)  # servos have them, the SDK's list has not
_SHORT_LATENCY = 1.5e-3  # s: adapters hold bytes back for 1 ms at least


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundServo:
    """A servo that answered a scan."""

    servo_id: int
    """Its id."""
    model: str
    """Its model, as in "XM430-W350"; "unknown (1234)" for a number that is not known."""
    model_number: int
    """Its model, as a number."""
    firmware: int
    """Version of its firmware."""
    baud: int
    """The rate at which it answered."""
    protocol: int = 2
    """The protocol in which it answered, 1 or 2."""


class DynamixelBus(ServoClient):
    """Servos on a serial port or a socket; open from construction to ``close``.

    Args:
        port: The serial port, such as /dev/ttyUSB0, or ``unix:`` and the path of a socket, as a
            virtual bus has it.
        baud: Bits per second.
        margin: How long an answer may come later than the wire needs before it counts as lost, s;
            what the USB adapter holds back is added. In single exchanges it is at least 34 ms.
        protocols: By id the protocol, 1 or 2, of servos that do not speak 2.0.

    Raises:
        PortError: If the port cannot be had, or does not have that rate.
    """

    def __init__(
        self,
        port: str,
        baud: int = 1_000_000,
        *,
        margin: float = 0.008,
        protocols: Mapping[int, int] | None = None,
    ) -> None:
        if not margin > 0.0:
            raise ValueError(f"margin: want a time above zero, got {margin}")
        self._margin = margin
        self._hold = _Hold(port, baud, margin)
        super().__init__(self._hold.link, protocols)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the port; servos go on as they are. Closing twice is no error."""
        self._hold.release()

    def reopen(self, port: str | None = None) -> None:
        """Let go of the port, if it is still there, and take it again.

        Args:
            port: Its name, if that is another now; None: an adapter that udev knows by its serial
                number is found under any name, every other by the name it had.

        Raises:
            PortError: If it is not there, or not yet.
        """
        last = self._hold
        last.release()
        name = last.link.port if port is None else port
        if port is None and last.by_id is not None and last.by_id.exists():
            name = str(last.by_id)
        self._hold = _Hold(name, self.baud, self._margin)
        if self._hold.by_id is None:
            self._hold.by_id = last.by_id
        self._link = self._hold.link


class _Hold:
    """A port that is ours: its link, and what must be given back."""

    def __init__(self, port: str, baud: int, margin: float) -> None:
        self._lock: PortLock | None = None
        self._handler: PortHandler | None = None
        self.by_id = None
        if is_socket(port):
            if not baud > 0:
                raise _no_rate(port, baud)
            self.link: SerialLink = SocketLink(port, baud, margin)
            return
        self._lock = PortLock(port)
        try:
            self._handler = _open(port, baud)
        except PortError:
            self._lock.release()
            raise
        latency = usb_latency(latency_file(port))
        if latency > _SHORT_LATENCY:
            _log.warning(
                "%s: its adapter holds bytes back for %.0f ms; for a faster loop run "
                "`echo 1 | sudo tee %s`",
                port,
                latency * 1e3,
                latency_file(port),
            )
        self.by_id = by_id_link(port)
        fd = self._handler.ser.fileno()
        held = 2.0 * latency
        self.link = SerialLink(port, fd, baud, margin + held, PROMPT + held)

    def release(self) -> None:
        """Give the port back; twice is no error."""
        self.link.close()
        if self._handler is not None and self._handler.is_open:
            self._handler.closePort()
        if self._lock is not None:
            self._lock.release()


def scan(port: str, bauds: Iterable[int] = DEFAULT_BAUDS) -> tuple[FoundServo, ...]:
    """Give the servos that answer on a port, rate by rate, those of Protocol 2.0 first, by id.

    It listens for servos whose ids lie within 40 of each other, starting at 0; only if it finds
    none at any rate it waits for all ids.

    Args:
        port: The serial port.
        bauds: The rates to try.

    Raises:
        PortError: If the port cannot be had.
    """
    rates = tuple(bauds)
    if is_socket(port):  # it knows no rate: every servo would be found at all of them
        rates = rates[:1]
    found: list[FoundServo] = []
    for quiet_slots in (QUIET_SLOTS, MAX_SERVO_ID):
        for baud in rates:
            with DynamixelBus(port, baud) as bus:
                replies = bus.scan(quiet_slots=quiet_slots) + bus.scan_v1(quiet_slots=quiet_slots)
            found += [_found(reply, baud) for reply in replies]
        if found:
            break
    return tuple(found)


def _found(reply: PingReply, baud: int) -> FoundServo:
    """Put a name to what answered."""
    try:
        model = servo_model_by_number(reply.model_number).name
    except ValueError:
        model = f"unknown ({reply.model_number})"
    return FoundServo(
        servo_id=reply.servo_id,
        model=model,
        model_number=reply.model_number,
        firmware=reply.firmware,
        baud=baud,
        protocol=reply.protocol,
    )


def _no_rate(port: str, baud: int) -> PortError:
    rates = ", ".join(map(str, (*_SDK_RATES, *_SDK_TOO_FAST)))
    return PortError(port, f"no servo speaks at {baud} baud", f"choose one of {rates}")


def _open(port: str, baud: int) -> "PortHandler":
    """Give the SDK's handler of the port, open at that rate."""
    from dynamixel_sdk import PortHandler

    handler = PortHandler(port)
    first = max(_SDK_RATES) if baud in _SDK_TOO_FAST else baud
    if handler.getCFlagBaud(first) <= 0:
        raise _no_rate(port, baud)
    try:
        handler.setBaudRate(first)
        if first != baud:
            handler.ser.baudrate = baud
            handler.baudrate = baud
    except (OSError, ValueError, termios.error) as error:
        if handler.is_open:
            handler.closePort()
            raise PortError(
                port, f"it does not run at {baud} baud ({error})", "choose another rate"
            ) from error
        cause = error if isinstance(error, OSError) else OSError(str(error))
        raise open_error(port, cause) from error
    return handler
