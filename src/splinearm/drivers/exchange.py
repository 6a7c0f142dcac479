"""What goes to the servos of an arm and comes back in every cycle: one write, one read.

Goals go out in one sync write, and what the leaders measure comes back in one fast sync read. Where
a model has its registers elsewhere, or more than the goal is to be sent, Indirect Data bring them
side by side at one address; where servos do not take that, or their torque keeps them from it, bulk
reads and a second write do as well. Fast reads are tried, not only looked up: who does not answer
them is asked plainly.
"""

import logging
import time
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from math import inf

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import BusError
from splinearm.joints import JointState

from .bus import Loss, PingReply, Reply, ServoBus, loss_error
from .crew import Crew
from .packets import ALERT_BIT, Instruction
from .pointing import point_at
from .scaling import IntArray, JointScale
from .servo_stats import LastSeen, ServoStats
from .startup import hardware_error
from .traffic import (
    Extras,
    ReadPart,
    WritePart,
    direct_traffic,
    gathered_traffic,
    single_reads,
)

_log = logging.getLogger(__name__)

_TRIALS = 8
_GOALS, _VELOCITIES, _CURRENTS = 0, 1, 2
_GOAL, _ASKED = "Goal Position", "Present Position"
_LOAD_UNIT = 1e-3


class Exchange:
    """The cyclic path to the servos of an arm and back, in SI but for goals in ticks.

    Before ``lay_out`` it works too, with registers where they are.

    Args:
        bus: The bus.
        crew: The servos; targets are sent goals, leaders are read.
        roll: By id what the servos answered to a ping.
        scale: How the registers of the targets are to be read, leaders first.
        velocity: Register that takes a velocity in every cycle beside the goal, such as "Goal
            Velocity"; None: none.
        current: Register that takes a current in every cycle, such as "Goal Current"; servos that
            have none get none. None: none.

    Raises:
        ValueError: If a servo has no position, velocity and load, or no goal.
    """

    def __init__(
        self,
        bus: ServoBus,
        crew: Crew,
        roll: Mapping[int, PingReply],
        scale: JointScale,
        *,
        velocity: str | None = None,
        current: str | None = None,
    ) -> None:
        self._bus = bus
        self._crew = crew
        self._roll = roll
        self._n = len(crew.leaders)
        extras = Extras(velocity, current)
        self._direct = direct_traffic(crew, roll, extras)
        self._gathered = gathered_traffic(crew, roll, extras, self._direct)
        self._kinds = frozenset(
            kind for kind, name in enumerate((_GOAL, velocity, current)) if name is not None
        )
        self._traffic = self._direct
        self._refused: set[int] = set()
        self._places = {servo.servo_id: i for i, servo in enumerate(crew.leaders)}
        self._t = np.full(self._n, -np.inf)
        self._raw = np.full((3, self._n), np.nan)
        loaded = [not servo.servo_model.has_current for servo in crew.leaders]
        self._load_unit = np.where(loaded, _LOAD_UNIT, np.nan)
        self._stats = {servo.servo_id: ServoStats() for servo in crew.leaders}
        self._reads = 0
        self._asked = -inf
        self._again: Counter[int] = Counter()
        self._singles: dict[int, ReadPart] = {}
        self._nothing = (0,) * len(crew.targets)
        self.scale = scale

    @property
    def scale(self) -> JointScale:
        """How the registers of the targets are read; may be replaced when a turn count changes."""
        return self._scale

    @scale.setter
    def scale(self, scale: JointScale) -> None:
        self._scale = scale
        self._of_leaders = scale.first(self._n)

    @property
    def stats(self) -> dict[int, ServoStats]:
        """By id of each leader how it has answered so far."""
        counts = self._bus.retries
        for servo_id, stats in self._stats.items():
            stats.reads = self._reads
            stats.retries = counts.get(servo_id, 0) + self._again[servo_id]
        return self._stats

    @property
    def last_seen(self) -> LastSeen:
        """The last that each joint said."""
        load, velocity, position = self._raw
        scale = self._of_leaders
        return LastSeen(
            t=self._t.copy(),
            q=scale.to_q(position),
            qd=scale.to_qd(velocity),
            current=scale.to_current(load),
        )

    @property
    def load(self) -> FloatArray:
        """Load of the last read, shape (n,), a share of the torque; NaN: current is measured."""
        load: FloatArray = self._raw[0] * self._load_unit
        return load

    @property
    def instructions(self) -> tuple[Instruction, ...]:
        """The instructions of a cycle, in order."""
        sent = [part.group.instruction for part in self._traffic.writes]
        asked = [part.group.instruction for part in self._traffic.reads]
        return (*sent, *asked)

    def lay_out(self, ids: Collection[int] | None = None) -> None:
        """Bring registers side by side, and find out which reads the servos answer.

        To be called at start, best with the torque off, and again for a servo that was rebooted.

        Args:
            ids: The servos concerned; None: all.

        Raises:
            BusError: If a servo does not answer.
        """
        places = self._gathered.places
        concerned = [s for s in self._crew.everyone if s.servo_id in places]
        if ids is not None:
            concerned = [servo for servo in concerned if servo.servo_id in ids]
        before = frozenset(self._refused)
        for servo in concerned:
            if point_at(self._bus, servo, places[servo.servo_id]):
                self._refused.discard(servo.servo_id)
            else:
                self._refused.add(servo.servo_id)
                _log.warning("%s: its registers stay apart, which costs bytes", servo.name)
        if ids is None or before != self._refused:
            self._traffic = self._direct if self._refused else self._gathered
            self._try_reads()

    def write(
        self,
        q_ticks: IntArray,
        velocity: FloatArray | None = None,
        current: FloatArray | None = None,
    ) -> None:
        """Send goals; nobody answers.

        Args:
            q_ticks: Goal Position of each target, shape (m,), ticks.
            velocity: What the register named ``velocity`` shall hold, shape (m,), rad/s; None: it
                is left as it is.
            current: What the register named ``current`` shall hold, shape (m,), A; where a servo
                has none it is ignored. None: it is left as it is.

        Raises:
            ValueError: If there are not as many as targets, or a register cannot hold one.
            PortError: If the port is gone.
        """
        rows: list[Sequence[int]] = [q_ticks.tolist(), self._nothing, self._nothing]
        given = {_GOALS}
        if velocity is not None:
            rows[_VELOCITIES] = self._scale.from_qd(velocity).tolist()
            given.add(_VELOCITIES)
        if current is not None:
            rows[_CURRENTS] = self._scale.from_current(current).tolist()
            given.add(_CURRENTS)
        if not given <= self._kinds:
            raise ValueError("velocity, current: want none where no register was named for it")
        if any(len(row) != len(self._nothing) for row in rows):
            raise ValueError(f"q_ticks: want {len(self._nothing)} values, got {len(rows[0])}")
        if given == self._kinds:
            parts: Sequence[WritePart] = self._traffic.writes
        else:
            parts = [part for part in self._direct.writes if part.kinds <= given]
        for part in parts:
            self._bus.sync_write(part.group, part.values(rows))

    def read(self) -> JointState:
        """Measure the joints, at the moment of asking.

        Raises:
            BusTimeoutError: If a servo does not answer; what the others said is in ``last_seen``.
            PacketError: If its answer is damaged.
            ServoError: If it refuses, has started anew, or reports a hardware error.
            PortError: If the port is gone.
        """
        t = time.monotonic()
        trouble = self.sample(t)
        if trouble:
            servo_id = min(trouble, key=lambda i: self._urgency(i, trouble[i]))
            raise self.error(servo_id, trouble[servo_id])
        load, velocity, position = self._raw
        scale = self._of_leaders
        return JointState(
            t=t,
            q=scale.to_q(position),
            qd=scale.to_qd(velocity),
            current=scale.to_current(load),
        )

    def sample(self, t: float | None = None) -> Mapping[int, Reply]:
        """Measure the joints into ``last_seen``; whatever the servos do is no error.

        Args:
            t: The present, on the monotonic clock, s.

        Returns:
            By id the replies in trouble: lost, or with an alert. Empty: all is well.

        Raises:
            PortError: If the port is gone.
        """
        t = time.monotonic() if t is None else t
        self._reads += 1
        trouble: dict[int, Reply] = {}
        for part in self._traffic.reads:
            answer = self._bus.fetch(part.group)
            if not isinstance(answer, bytes):
                self._take(part, answer, t, trouble)
            elif not part.take(answer, self._raw, self._t, t):
                self._take(part, part.group.replies(answer), t, trouble)
        before, self._asked = self._asked, t
        for servo_id in [i for i, reply in trouble.items() if reply.loss is Loss.DAMAGED]:
            if self._t[self._places[servo_id]] < before:  # for the second time in a row
                self._ask_again(servo_id, t, trouble)
        return trouble

    def error(self, servo_id: int, reply: Reply) -> BusError:
        """Make the error of a reply in trouble; of a servo with a latched error, ask which."""
        servo = self._crew.leaders[self._places[servo_id]]
        if reply.loss is not None:
            return loss_error(reply, servo_id, _ASKED, port=self._bus.port, name=servo.name)
        status = reply.error >> 8  # of Protocol 1.0
        register = servo.servo_model.table.get("Hardware Error Status")
        if register is not None:
            with suppress(BusError):
                status = self._bus.read(servo_id, register)
        return hardware_error(servo, status)

    def _ask_again(self, servo_id: int, t: float, trouble: dict[int, Reply]) -> None:
        """Ask one servo plainly whose answers came damaged: on a noisy line that often helps."""
        if servo_id not in self._singles:
            [self._singles[servo_id]] = single_reads(self._crew, self._roll, [servo_id])
        self._again[servo_id] += 1
        del trouble[servo_id]
        part = self._singles[servo_id]
        self._take(part, self._bus.sync_read(part.group), t, trouble)

    def _urgency(self, servo_id: int, reply: Reply) -> tuple[bool, float, bool]:
        """Say what comes first: hardware errors, who was not heard for longest, who is known."""
        seen = float(self._t[self._places[servo_id]])
        return reply.loss is not None, seen, reply.loss is Loss.HIDDEN

    def _take(
        self, part: ReadPart, replies: Mapping[int, Reply], t: float, trouble: dict[int, Reply]
    ) -> None:
        """Keep what came, reply by reply."""
        for servo_id, reply in replies.items():
            loss = reply.loss
            if loss is None and not part.gauges[servo_id].is_marked_well(reply.data):
                loss = Loss.ADRIFT
            if loss is None:
                i = self._places[servo_id]
                self._raw[:, i] = part.gauges[servo_id].read(reply.data)
                self._t[i] = t
            elif loss is Loss.SILENT:
                self._stats[servo_id].timeouts += 1
            elif loss is Loss.DAMAGED:
                self._stats[servo_id].crc_errors += 1
            if loss is not None or reply.error & ALERT_BIT:
                trouble[servo_id] = reply._replace(loss=loss)

    def _try_reads(self) -> None:
        """Ask until it is settled how the servos answer; that counts in no statistics."""
        counted = {i: replace(stats) for i, stats in self._stats.items()}, self._reads
        for part in self._traffic.reads:
            part.group.forget()
        lost: set[int] = set()
        for _ in range(_TRIALS):
            lost = {i for i, reply in self.sample().items() if reply.loss is not None}
            if not lost and all(part.group.settled for part in self._traffic.reads):
                break
        reads: list[ReadPart] = []
        for part in self._traffic.reads:
            reads += self._one_by_one(part, lost) if lost & part.gauges.keys() else (part,)
        self._traffic = replace(self._traffic, reads=tuple(reads))
        self._stats, self._reads = counted
        _log.info("a cycle is %s", ", ".join(step.name.lower() for step in self.instructions))

    def _one_by_one(self, part: ReadPart, lost: Collection[int]) -> tuple[ReadPart, ...]:
        """Give reads of single servos for a group read, if servos answer only those."""
        singles = single_reads(self._crew, self._roll, part.gauges)
        found = [
            servo_id
            for single in singles
            for servo_id, reply in self._bus.sync_read(single.group).items()
            if reply.loss is None and servo_id in lost
        ]
        if not found:
            return (part,)
        step = part.group.instruction.name.lower().replace("_", " ")
        _log.warning("servos %s do not answer a %s: they are asked one by one", found, step)
        return singles
