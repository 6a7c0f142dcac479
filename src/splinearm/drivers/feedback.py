"""What the servos of an arm say of themselves in every cycle, and how often they failed to."""

import struct
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import BusError
from splinearm.joints import JointState

from .bus import Loss, Reply, ServoBus, loss_error
from .chain import ServoSpec
from .cyclic import GroupRead
from .groups import BulkRead
from .model import ServoModel
from .packets import ALERT_BIT
from .scaling import JointScale
from .startup import hardware_error

_LAYOUT = struct.Struct("<hii")  # current or load, velocity, position
_ASKED = "Present Position"


@dataclass(slots=True)
class ServoStats:
    """How one servo has answered so far."""

    reads: int = 0
    """Reads that it was asked for; some may be hidden by the loss of another servo."""
    timeouts: int = 0
    """Reads that it did not answer."""
    crc_errors: int = 0
    """Answers that came damaged."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class LastSeen:
    """The last that each joint said, also of joints that the last read has lost."""

    t: FloatArray
    """When, shape (n,), s on the monotonic clock; -inf: never."""
    q: FloatArray
    """Position, shape (n,), rad; NaN: never seen."""
    qd: FloatArray
    """Velocity, shape (n,), rad/s; NaN: never seen."""
    current: FloatArray
    """Current, shape (n,), A; NaN: never seen, or not measured."""


class Feedback:
    """Reads position, velocity and current of the leaders, all in one exchange.

    Args:
        bus: The bus.
        leaders: One servo a joint.
        scale: How their registers are to be read.
        fast: Whether all of them know fast reads.

    Raises:
        ValueError: If a model does not have the three registers side by side.
    """

    def __init__(
        self, bus: ServoBus, leaders: Sequence[ServoSpec], scale: JointScale, *, fast: bool
    ) -> None:
        self._bus = bus
        self._leaders = tuple(leaders)
        self._group = GroupRead(
            [BulkRead(s.servo_id, feedback_address(s.servo_model), _LAYOUT.size) for s in leaders],
            fast=fast,
        )
        self.scale = scale
        """How the registers are read; may be replaced when a turn count changes."""
        self.stats = {servo.servo_id: ServoStats() for servo in leaders}
        """How each servo has answered so far, by id."""
        self._places = {servo.servo_id: i for i, servo in enumerate(leaders)}
        n = len(self._leaders)
        self._t = np.full(n, -np.inf)
        self._raw = np.full((3, n), np.nan)

    @property
    def last_seen(self) -> LastSeen:
        """The last that each joint said."""
        load, velocity, position = self._raw
        return LastSeen(
            t=self._t.copy(),
            q=self.scale.to_q(position),
            qd=self.scale.to_qd(velocity),
            current=self.scale.to_current(load),
        )

    def read(self) -> JointState:
        """Measure the joints, at the moment of asking.

        Raises:
            BusTimeoutError: If a servo does not answer; what the others said is in ``last_seen``.
            PacketError: If its answer is damaged.
            ServoError: If it refuses, or reports a hardware error.
        """
        t = time.monotonic()
        replies = self._bus.sync_read(self._group)
        trouble = self._take(replies, t)
        if trouble is not None:
            raise self._error(*trouble)
        load, velocity, position = self._raw
        scale = self.scale
        return JointState(
            t=t,
            q=scale.to_q(position),
            qd=scale.to_qd(velocity),
            current=scale.to_current(load),
        )

    def _take(self, replies: dict[int, Reply], t: float) -> tuple[ServoSpec, Reply] | None:
        """Keep what came; give the first servo asked that was lost or reports an error."""
        trouble: tuple[ServoSpec, Reply] | None = None
        for servo_id, reply in replies.items():
            i = self._places[servo_id]
            stats = self.stats[servo_id]
            stats.reads += 1
            if reply.loss is None:
                self._raw[:, i] = _LAYOUT.unpack(reply.data)
                self._t[i] = t
            elif reply.loss is Loss.SILENT:
                stats.timeouts += 1
            elif reply.loss is Loss.DAMAGED:
                stats.crc_errors += 1
            if trouble is None and (reply.loss is not None or reply.error & ALERT_BIT):
                trouble = self._leaders[i], reply
        return trouble

    def _error(self, servo: ServoSpec, reply: Reply) -> BusError:
        """Make the error of a servo in trouble; of one with a latched error, ask which."""
        if reply.loss is not None:
            return loss_error(reply, servo.servo_id, _ASKED, port=self._bus.port, name=servo.name)
        register = servo.servo_model.table["Hardware Error Status"]
        try:
            status = self._bus.read(servo.servo_id, register)
        except BusError:
            status = 0
        return hardware_error(servo, status)


def feedback_address(model: ServoModel) -> int:
    """Give where current (or load), velocity and position begin.

    Raises:
        ValueError: If the model does not have them side by side, as wide as they should be.
    """
    names = ("Present Current" if model.has_current else "Present Load", "Present Velocity", _ASKED)
    if all(name in model.table for name in names):
        first, second, third = (model.table[name] for name in names)
        sizes = (first.size, second.size, third.size)
        if sizes == (2, 4, 4) and (first.end, second.end) == (second.address, third.address):
            return first.address
    raise ValueError(
        f"{model.name} cannot be a joint: want its load, velocity and position side by side"
    )
