"""A line of DYNAMIXEL servos behind a serial port: the only file that knows the maker's SDK.

The SDK opens the port, pings, reads single registers, reboots and resets. What goes out with data
goes through our own codec on the same port: the SDK (4.1.0) throws the result of its byte stuffing
away. So do reads of many servos: the SDK polls without sleeping, and one servo that does not answer
costs it the answers of all others.
"""

import logging
import select
import termios
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Self, TypeVar

from splinearm.errors import BusTimeoutError, PacketError, PortError, ServoError

from .bus import PingReply, Reply
from .chain import MAX_SERVO_ID
from .cyclic import GroupRead, GroupWrite
from .link import BITS_PER_BYTE, SerialLink
from .model import servo_model_by_number
from .packets import (
    ALERT_BIT,
    BROADCAST_ID,
    ERROR_TEXTS,
    Decoder,
    Instruction,
    Packet,
    encode,
    write_params,
)
from .port import PortLock, latency_file, open_error, usb_latency
from .registers import Register

if TYPE_CHECKING:
    from dynamixel_sdk import PortHandler

_log = logging.getLogger(__name__)
_T = TypeVar("_T")

DEFAULT_BAUDS = (57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000)
"""Rates at which servos are usually found."""
_SDK_RATES = (9_600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000)
_SDK_TOO_FAST = (4_500_000, 6_000_000, 10_500_000)  # servos have them, the SDK's list has not
_SDK_PATIENCE = 0.034  # s: what the SDK gives an answer beyond its time on the wire
_SHORT_LATENCY = 1.5e-3  # s: adapters hold bytes back for 1 ms at least
_TRIES = 3
_STATUS_BYTES = 11
_PING_BYTES = 14
# to a broadcast ping a servo answers in a time slot of its own, by id: 3 ms and one answer each, as
# the SDK's time limit for all 252 of them has it (Protocol2PacketHandler.broadcastPing)
_PING_SLOT = 3e-3
_QUIET_SLOTS = 40


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


class DynamixelBus:
    """Servos that speak Protocol 2.0 on a serial port; open from construction to ``close``.

    Args:
        port: The serial port, such as /dev/ttyUSB0.
        baud: Bits per second.
        margin: How long an answer may come later than the wire needs before it counts as lost, s;
            what the USB adapter holds back is added. In single exchanges it is at least 34 ms.

    Raises:
        PortError: If the port cannot be had, or does not have that rate.
    """

    def __init__(self, port: str, baud: int = 1_000_000, *, margin: float = 0.008) -> None:
        if not margin > 0.0:
            raise ValueError(f"margin: want a time above zero, got {margin}")
        from dynamixel_sdk import PacketHandler

        self._name = port
        self._sdk = PacketHandler(2.0)
        self._lock = PortLock(port)
        latency = usb_latency(latency_file(port))
        margin += 2.0 * latency
        self._patience = max(margin, _SDK_PATIENCE)
        try:
            self._handler = _open(port, baud)
        except PortError:
            self._lock.release()
            raise
        _let_it_sleep(self._handler, self._patience)
        if latency > _SHORT_LATENCY:
            _log.warning(
                "%s: its adapter holds bytes back for %.0f ms; for a faster loop run "
                "`echo 1 | sudo tee %s`",
                port,
                latency * 1e3,
                latency_file(port),
            )
        self._link = SerialLink(port, self._handler.ser.fileno(), baud, margin)

    @property
    def port(self) -> str:
        """Name of the port."""
        return self._name

    @property
    def baud(self) -> int:
        """Bits per second."""
        return self._link.baud

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
        self._link.close()
        if self._handler.is_open:
            self._handler.closePort()
        self._lock.release()

    def ping(self, servo_id: int) -> PingReply:
        """Ask one servo what it is.

        Raises:
            BusTimeoutError: If it does not answer.
        """
        number = self._ask(servo_id, "", lambda: self._sdk.ping(self._handler, servo_id))
        try:
            register = servo_model_by_number(number).table["Firmware Version"]
        except ValueError:  # a model that is not known: the place where nearly all have it
            return PingReply(servo_id, number, self._read(servo_id, 6, 1, "Firmware Version")[0])
        return PingReply(servo_id, number, self.read(servo_id, register))

    def scan(self, *, quiet_slots: int = _QUIET_SLOTS) -> tuple[PingReply, ...]:
        """Ask every servo what it is; give those that answer, by id.

        Servos answer one after the other by id, each in its slot of 3 ms and one answer's time.

        Args:
            quiet_slots: After how many empty slots to give up. A servo whose id is further from
                that of the servo before it is not found; 252 finds all.
        """
        slot = _PING_SLOT + _PING_BYTES * BITS_PER_BYTE / self.baud
        patience = quiet_slots * slot
        deadline = self._link.send(encode(BROADCAST_ID, Instruction.PING), 1, _PING_BYTES)
        decoder = Decoder()
        found: dict[int, PingReply] = {}
        while data := self._link.receive_some(deadline + patience):
            for packet in decoder.feed(data):
                if packet.is_status and len(packet.params) == 3:
                    number = packet.params[0] | packet.params[1] << 8
                    reply = PingReply(packet.servo_id, number, packet.params[2])
                    found[packet.servo_id] = reply
            deadline = self._link.deadline()
        return tuple(found[servo_id] for servo_id in sorted(found))

    def read(self, servo_id: int, register: Register) -> int:
        """Read a register.

        Raises:
            BusTimeoutError: If the servo does not answer.
            PacketError: If what it answers is damaged.
            ServoError: If it refuses.
        """
        data = self._read(servo_id, register.address, register.size, register.name)
        return register.decode(data)

    def write(self, servo_id: int, register: Register, value: int) -> None:
        """Write a register and wait until the servo has said that it took it.

        Raises:
            ValueError: If the register cannot hold the value.
            BusTimeoutError: If the servo does not answer.
            ServoError: If it refuses.
        """
        params = write_params(register.address, register.encode(value))
        frame = encode(servo_id, Instruction.WRITE, params)
        packet = self._exchange(servo_id, frame, register.name)
        _refuse(servo_id, packet.error, f"{register.name} = {value} refused")

    def sync_read(self, group: GroupRead) -> dict[int, Reply]:
        """Read from many servos at once; a lost answer is a ``Reply`` with its loss, no error.

        Raises:
            PortError: If the port is gone.
        """
        link = self._link
        deadline = link.send(group.request, len(group.ids), group.reply_length)
        data = link.receive(group.reply_length, deadline)
        replies, unfinished = group.parse(data)
        while unfinished and (more := link.receive_some(deadline)):
            data += more
            replies, unfinished = group.parse(data)
        group.learn(replies)
        return replies

    def sync_write(self, group: GroupWrite, values: Sequence[int]) -> None:
        """Write to many servos at once; nobody answers.

        Raises:
            PortError: If the port is gone.
        """
        self._link.send(group.frame(values))

    def reboot(self, servo_id: int) -> None:
        """Let a servo start anew; its torque goes off, latched errors and turn counts are gone.

        Raises:
            BusTimeoutError: If it does not answer.
        """
        self._ask(servo_id, "", lambda: (0, *self._sdk.reboot(self._handler, servo_id)), tries=1)

    def factory_reset(self, servo_id: int, *, keep_id: bool = True, keep_baud: bool = True) -> None:
        """Give a servo back what it was set to in the factory.

        Raises:
            ValueError: If the id shall be lost but the rate kept: no servo can do that.
            BusTimeoutError: If it does not answer.
        """
        if keep_baud and not keep_id:
            raise ValueError("keep_baud: want False too where keep_id is False, got True")
        option = 0x02 if keep_baud else 0x01 if keep_id else 0xFF

        def reset() -> tuple[int, int, int]:
            return (0, *self._sdk.factoryReset(self._handler, servo_id, option))

        self._ask(servo_id, "", reset, tries=1)

    def _read(self, servo_id: int, address: int, size: int, name: str) -> bytes:
        """Read bytes with the SDK."""
        data: list[int] = self._ask(
            servo_id, name, lambda: self._sdk.readTxRx(self._handler, servo_id, address, size)
        )
        if len(data) != size:
            raise PacketError(f"{size} bytes of {name} of servo {servo_id}", f"{len(data)} bytes")
        return bytes(data)

    def _ask(
        self,
        servo_id: int,
        register: str,
        call: Callable[[], tuple[_T, int, int]],
        *,
        tries: int = _TRIES,
    ) -> _T:
        """Let the SDK do one exchange, again if it is lost; give what it got."""
        from dynamixel_sdk import COMM_RX_TIMEOUT, COMM_SUCCESS

        result = COMM_RX_TIMEOUT
        for _ in range(tries):
            try:
                value, result, error = call()
            except (OSError, termios.error) as cause:
                raise self._link.gone(cause) from cause
            finally:
                self._handler.is_using = False
            if result == COMM_SUCCESS:
                _refuse(servo_id, error, f"{register or 'the instruction'} refused")
                return value
        if result == COMM_RX_TIMEOUT:
            raise BusTimeoutError(servo_id, register, port=self._name)
        raise PacketError(f"an answer of servo {servo_id}", self._sdk.getTxRxResult(result))

    def _exchange(self, servo_id: int, frame: bytes, register: str) -> Packet:
        """Send one packet and give the status that answers it, trying again if it is lost."""
        for _ in range(_TRIES):
            deadline = self._link.send(frame, 1, _STATUS_BYTES) - self._link.margin + self._patience
            decoder = Decoder()
            while data := self._link.receive_some(deadline):
                for packet in decoder.feed(data):
                    if packet.is_status and packet.servo_id == servo_id:
                        return packet
        raise BusTimeoutError(servo_id, register, port=self._name)


def scan(port: str, bauds: Iterable[int] = DEFAULT_BAUDS) -> tuple[FoundServo, ...]:
    """Give the servos that answer on a port, rate by rate, by id.

    It listens for servos whose ids lie within 40 of each other, starting at 0; only if it finds
    none at any rate it waits for all ids.

    Args:
        port: The serial port.
        bauds: The rates to try.

    Raises:
        PortError: If the port cannot be had.
    """
    rates = tuple(bauds)
    found: list[FoundServo] = []
    for quiet_slots in (_QUIET_SLOTS, MAX_SERVO_ID):
        for baud in rates:
            with DynamixelBus(port, baud) as bus:
                replies = bus.scan(quiet_slots=quiet_slots)
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
    )


def _open(port: str, baud: int) -> "PortHandler":
    """Give the SDK's handler of the port, open at that rate."""
    from dynamixel_sdk import PortHandler

    handler = PortHandler(port)
    first = max(_SDK_RATES) if baud in _SDK_TOO_FAST else baud
    if handler.getCFlagBaud(first) <= 0:
        rates = ", ".join(map(str, (*_SDK_RATES, *_SDK_TOO_FAST)))
        raise PortError(port, f"no servo speaks at {baud} baud", f"choose one of {rates}")
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


def _let_it_sleep(handler: "PortHandler", patience: float) -> None:
    """Make the SDK's handler sleep until bytes come, where it polls, and wait as long as we do."""
    read_at_once = handler.readPort

    def read_port(length: int) -> bytes:
        left_ms = handler.packet_timeout - handler.getTimeSinceStart()
        select.select([handler.ser], [], [], max(left_ms, 0.0) * 1e-3)
        data: bytes = read_at_once(length)
        return data

    def set_packet_timeout(length: int) -> None:
        handler.setPacketTimeoutMillis(handler.tx_time_per_byte * length + patience * 1e3)

    handler.readPort = read_port
    handler.setPacketTimeout = set_packet_timeout


def _refuse(servo_id: int, error: int, what: str) -> None:
    """Raise if the error byte of a status holds an error number."""
    number = error & ~ALERT_BIT
    if number:
        text = ERROR_TEXTS.get(number, f"error {number}")
        alert = bool(error & ALERT_BIT)
        raise ServoError(servo_id, f"{what}: {text}", code=number, alert=alert)
