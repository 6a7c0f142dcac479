"""The bus: what every way to a line of servos must be able to do, and what comes back."""

from collections.abc import Mapping, Sequence
from enum import Enum
from typing import TYPE_CHECKING, NamedTuple, Protocol

from splinearm.errors import BusError, BusTimeoutError, PacketError, ServoError

from .packets import ALERT_BIT, ERROR_TEXTS, Instruction
from .packets_v1 import RAW_SHIFT

if TYPE_CHECKING:
    from .registers import Register


class Loss(Enum):
    """Why a servo's answer is missing from a group read."""

    SILENT = "no answer"
    """Nothing came from it."""

    DAMAGED = "a damaged answer"
    """Something came from it, but with a wrong CRC or cut short."""

    HIDDEN = "nothing that can be trusted, after the loss of another"
    """In a fast read: it was to answer after one that was lost; nothing is known of it."""

    REFUSED = "a refusal"
    """It answered with an error and without data."""

    ADRIFT = "data from elsewhere"
    """It has begun anew: where the registers were gathered are others now."""


class Reply(NamedTuple):
    """What a group read got from one servo."""

    data: bytes
    """What it read; empty if lost."""
    error: int = 0
    """Its error byte: an error number and the alert bit; that of Protocol 1.0 above it."""
    loss: Loss | None = None
    """Why there are no data; None: there are."""

    @property
    def latched(self) -> int:
        """The hardware errors that a status of Protocol 1.0 says by itself; of 2.0 it says none."""
        return self.error >> RAW_SHIFT


class PingReply(NamedTuple):
    """What a servo says of itself."""

    servo_id: int
    """Its id."""
    model_number: int
    """Its model, as a number; see ``servo_model_by_number``."""
    firmware: int
    """Version of its firmware."""
    protocol: int = 2
    """The protocol in which it answered, 1 or 2."""


class ReadGroup(Protocol):
    """A read of many servos, prebuilt."""

    @property
    def instruction(self) -> Instruction:
        """What is asked or sent."""
        ...

    @property
    def ids(self) -> tuple[int, ...]:
        """Ids in the order in which they are asked."""
        ...

    @property
    def request(self) -> bytes:
        """The bytes to send."""
        ...

    @property
    def reply_length(self) -> int:
        """How many bytes come back if nothing is lost or stuffed."""
        ...

    @property
    def sure_length(self) -> int:
        """How many of them come if those are lost again that were lost last time."""
        ...

    @property
    def settled(self) -> bool:
        """Whether the next read is the one that a flawless answer would lead to again."""
        ...

    def is_flawless(self, data: bytes) -> bool:
        """Say whether an answer is whole, in order and undamaged."""
        ...

    def replies(self, data: bytes) -> dict[int, Reply]:
        """Take a flawless answer apart."""
        ...

    def parse(self, data: bytes) -> tuple[dict[int, Reply], bool]:
        """Understand what came back, as far as it came, and whether more may still come."""
        ...

    def learn(self, replies: dict[int, Reply]) -> None:
        """Take from an outcome how to ask next time."""
        ...

    def forget(self) -> None:
        """Begin anew, as if nothing had ever come back."""
        ...


class WriteGroup(Protocol):
    """A write to many servos, prebuilt."""

    @property
    def instruction(self) -> Instruction:
        """What is asked or sent."""
        ...

    @property
    def ids(self) -> tuple[int, ...]:
        """Ids in the order of the values."""
        ...

    def frame(self, values: Sequence[int]) -> bytes:
        """Give the bytes that write these values, servo by servo."""
        ...


class ServoBus(Protocol):
    """A line of servos. Whatever fails is a ``BusError``."""

    @property
    def port(self) -> str:
        """Name of the port, for errors."""
        ...

    @property
    def baud(self) -> int:
        """Bits per second."""
        ...

    @property
    def margin(self) -> float:
        """How long an answer may come later than the wire needs before it counts as lost, s."""
        ...

    @property
    def retries(self) -> Mapping[int, int]:
        """By id how many single instructions had to be sent again; ids without any may lack."""
        ...

    def speak(self, protocols: Mapping[int, int]) -> None:
        """Say which protocol servos speak, 1 or 2, by id; those never named speak 2.0."""
        ...

    def ping(self, servo_id: int) -> PingReply:
        """Ask one servo what it is.

        Raises:
            BusTimeoutError: If it does not answer.
        """
        ...

    def scan(self) -> tuple[PingReply, ...]:
        """Ask every servo what it is; give those that answer, by id."""
        ...

    def read(self, servo_id: int, register: "Register") -> int:
        """Read a register.

        Raises:
            BusTimeoutError: If the servo does not answer.
            ServoError: If it refuses.
        """
        ...

    def write(self, servo_id: int, register: "Register", value: int) -> None:
        """Write a register and wait until the servo has said that it took it.

        Raises:
            ValueError: If the register cannot hold the value.
            BusTimeoutError: If the servo does not answer.
            ServoError: If it refuses.
        """
        ...

    def sync_read(self, group: "ReadGroup") -> dict[int, Reply]:
        """Read from many servos at once; a lost answer is a ``Reply`` with its loss, no error."""
        ...

    def fetch(self, group: "ReadGroup") -> bytes | dict[int, Reply]:
        """Read from many servos at once: as ``sync_read``, but a flawless answer as it came."""
        ...

    def sync_write(self, group: "WriteGroup", values: Sequence[int]) -> None:
        """Write to many servos at once; nobody answers."""
        ...

    def reboot(self, servo_id: int) -> None:
        """Let a servo start anew; its torque goes off, latched errors and turn counts are gone."""
        ...

    def reopen(self, port: str | None = None) -> None:
        """Let go of the port, if it is still there, and take it again.

        Args:
            port: Its name, if that is another now.

        Raises:
            PortError: If it is not there, or not yet.
        """
        ...

    def close(self) -> None:
        """Let go of the port; servos go on as they are. Closing twice is no error."""
        ...


def loss_error(reply: Reply, servo_id: int, register: str, *, port: str, name: str) -> BusError:
    """Make the error of a lost reply.

    Args:
        reply: A reply with a loss.
        servo_id: The servo it should have come from.
        register: What was asked of it.
        port: The port it was asked on.
        name: What the arm file calls the servo.
    """
    if reply.loss in (Loss.SILENT, Loss.HIDDEN):
        return BusTimeoutError(servo_id, register, port=port, name=name)
    if reply.loss is Loss.REFUSED:
        number = reply.error & ~ALERT_BIT
        text = ERROR_TEXTS.get(number, f"error {number}")
        alert = bool(reply.error & ALERT_BIT)
        reason = f"{register} refused: {text}"
        return ServoError(servo_id, reason, code=number, alert=alert, name=name)
    if reply.loss is Loss.ADRIFT:
        reason = "it has started anew (power or reset); its torque is off: recover it"
        return ServoError(servo_id, reason, name=name)
    return PacketError(f"{register} of servo {servo_id} ({name})", "a damaged packet")
