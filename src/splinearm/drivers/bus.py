"""The bus: what every way to a line of servos must be able to do, and what comes back."""

from collections.abc import Sequence
from enum import Enum
from typing import TYPE_CHECKING, NamedTuple, Protocol

from splinearm.errors import BusError, BusTimeoutError, PacketError, ServoError

from .packets import ALERT_BIT, ERROR_TEXTS

if TYPE_CHECKING:
    from .cyclic import GroupRead, GroupWrite
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


class Reply(NamedTuple):
    """What a group read got from one servo."""

    data: bytes
    """What it read; empty if lost."""
    error: int = 0
    """Its error byte: an error number and the alert bit."""
    loss: Loss | None = None
    """Why there are no data; None: there are."""


class PingReply(NamedTuple):
    """What a servo says of itself."""

    servo_id: int
    """Its id."""
    model_number: int
    """Its model, as a number; see ``servo_model_by_number``."""
    firmware: int
    """Version of its firmware."""


class ServoBus(Protocol):
    """A line of servos. Whatever fails is a ``BusError``."""

    @property
    def port(self) -> str:
        """Name of the port, for errors."""
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

    def sync_read(self, group: "GroupRead") -> dict[int, Reply]:
        """Read from many servos at once; a lost answer is a ``Reply`` with its loss, no error."""
        ...

    def sync_write(self, group: "GroupWrite", values: Sequence[int]) -> None:
        """Write to many servos at once; nobody answers."""
        ...

    def reboot(self, servo_id: int) -> None:
        """Let a servo start anew; its torque goes off, latched errors and turn counts are gone."""
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
    return PacketError(f"{register} of servo {servo_id} ({name})", "a damaged packet")
