"""Every instruction that a servo knows, sent and answered on a link, in the protocol it speaks."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from splinearm.errors import BusTimeoutError, PacketError, ServoError

from .bus import PingReply, ReadGroup, Reply, WriteGroup
from .cyclic import GroupRead
from .cyclic_v1 import GroupWriteV1, OneRead
from .dialect import DIALECTS, Dialect
from .link import BITS_PER_BYTE, SerialLink
from .model import servo_model_by_number
from .packets import ALERT_BIT, BROADCAST_ID, ERROR_TEXTS, Instruction, Packet
from .registers import Register
from .sending import Block, GroupWrite, shares

_TRIES = 3
_PATIENCE = 0.034  # s: what a servo that does something first gets beyond the time on the wire
_PING_BYTES = 14
# to a broadcast ping a servo answers in a time slot of its own, by id: 3 ms and one answer each, as
# the SDK's time limit for all 252 of them has it (Protocol2PacketHandler.broadcastPing)
_PING_SLOT = 3e-3
QUIET_SLOTS = 40
"""After how many ids without a servo a scan gives up."""
_HIGHEST_ID_V1 = 253
_SLACK = 1e-3  # s: how much later yet an answer to a ping of a scan may come
_USUAL_FIRMWARE = {1: 2, 2: 6}  # where unknown models have their firmware's version
_CLEAR_TURNS = b"\x01\x44\x58\x4c\x22"  # e-Manual, "Clear": position, then a key
_KEEP_ID, _KEEP_ID_AND_BAUD, _ALL = 0x01, 0x02, 0xFF


class ServoClient:
    """Speaks to servos on a link.

    Args:
        link: The link.
        protocols: By id the protocol of each servo that does not speak 2.0.
    """

    def __init__(self, link: SerialLink, protocols: Mapping[int, int] | None = None) -> None:
        self._link = link
        self._protocols: dict[int, int] = {}
        self._retries: Counter[int] = Counter()
        self.speak(protocols or {})

    @property
    def port(self) -> str:
        """Name of the port."""
        return self._link.port

    @property
    def baud(self) -> int:
        """Bits per second."""
        return self._link.baud

    @property
    def margin(self) -> float:
        """How long an answer may come later than the wire needs before it counts as lost, s."""
        return self._link.margin

    @property
    def retries(self) -> Mapping[int, int]:
        """By id how many single instructions had to be sent again; ids without any lack."""
        return self._retries

    def speak(self, protocols: Mapping[int, int]) -> None:
        """Say which protocol servos speak; those never named speak 2.0.

        Args:
            protocols: 1 or 2, by id.
        """
        for servo_id, number in protocols.items():
            if number not in DIALECTS:
                raise ValueError(f"protocols: want 1 or 2 for servo {servo_id}, got {number}")
            if number == 1:
                self._protocols[servo_id] = number
            else:
                self._protocols.pop(servo_id, None)

    def ping(self, servo_id: int, *, tries: int = _TRIES) -> PingReply:
        """Ask one servo what it is.

        Args:
            servo_id: The servo.
            tries: How often to ask before giving up.

        Raises:
            BusTimeoutError: If it does not answer.
            PacketError: If what it answers is damaged.
        """
        protocol = self._dialect(servo_id).number
        answer = 3 if protocol == 2 else 0
        packet = self._do(servo_id, Instruction.PING, tries=tries, answer=answer)
        if protocol == 2:
            number = packet.params[0] | packet.params[1] << 8
            return PingReply(servo_id, number, packet.params[2])
        number = int.from_bytes(self._read(servo_id, 0, 2, "Model Number"), "little")
        try:
            at = servo_model_by_number(number).table["Firmware Version"].address
        except ValueError:
            at = _USUAL_FIRMWARE[protocol]
        firmware = self._read(servo_id, at, 1, "Firmware Version")[0]
        return PingReply(servo_id, number, firmware, protocol)

    def scan(self, *, quiet_slots: int = QUIET_SLOTS) -> tuple[PingReply, ...]:
        """Ask every servo of Protocol 2.0 what it is; give those that answer, by id.

        Servos answer one after the other by id, each in its slot of 3 ms and one answer's time.

        Args:
            quiet_slots: After how many empty slots to give up. A servo whose id is further from
                that of the servo before it is not found; 252 finds all.
        """
        slot = _PING_SLOT + _PING_BYTES * BITS_PER_BYTE / self.baud
        dialect = DIALECTS[2]
        frame = dialect.frame(BROADCAST_ID, Instruction.PING)
        deadline = self._link.send(frame, 1, _PING_BYTES)
        listener = dialect.listener()
        found: dict[int, PingReply] = {}
        while data := self._link.receive_some(deadline + quiet_slots * slot):
            for packet in listener.feed(data):
                if len(packet.params) == 3:
                    number = packet.params[0] | packet.params[1] << 8
                    reply = PingReply(packet.servo_id, number, packet.params[2])
                    found[packet.servo_id] = reply
            deadline = self._link.deadline()
        return tuple(found[servo_id] for servo_id in sorted(found))

    def scan_v1(self, *, quiet_slots: int = QUIET_SLOTS) -> tuple[PingReply, ...]:
        """Ask every id whether a servo of Protocol 1.0 is there; give those that answer, by id.

        Args:
            quiet_slots: After how many ids without a servo to give up.
        """
        dialect, link = DIALECTS[1], self._link
        found: set[int] = set()
        last = -1
        for servo_id in range(_HIGHEST_ID_V1 + 1):
            if servo_id > last + quiet_slots:
                break
            frame = dialect.frame(servo_id, Instruction.PING)
            listener = dialect.listener()
            link.send(frame)
            deadline = link.soon(1, len(frame) + dialect.status_length) + _SLACK
            came = b""
            while not found & {servo_id} and (data := link.receive_some(deadline)):
                came += data
                heard = listener.feed(data if not frame.startswith(came) else b"")
                found |= {p.servo_id for p in heard if p.servo_id <= servo_id}
            last = max(found, default=-1)
        before = dict(self._protocols)
        self.speak(dict.fromkeys(found, 1))
        try:
            return tuple(self.ping(servo_id) for servo_id in sorted(found))
        finally:
            self._protocols = before

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
            PacketError: If what it answers is damaged.
            ServoError: If it refuses.
        """
        dialect = self._dialect(servo_id)
        params = dialect.write_params(register.address, register.encode(value))
        self._do(servo_id, Instruction.WRITE, params, about=f"{register.name} = {value}")

    def sync_read(self, group: ReadGroup) -> dict[int, Reply]:
        """Read from many servos at once; a lost answer is a ``Reply`` with its loss, no error.

        Those that speak Protocol 1.0 are asked one by one, whatever the group says.

        Raises:
            PortError: If the port is gone.
        """
        old = self._old(group.ids)
        if old and isinstance(group, GroupRead):
            modern = [r for r in group.requests if r.servo_id not in old]
            replies = self.sync_read(GroupRead(modern, fast=group.fast)) if modern else {}
            for request in group.requests:
                if request.servo_id in old:
                    replies |= self.sync_read(OneRead(request, 1))
            return {servo_id: replies[servo_id] for servo_id in group.ids}
        answer = self.fetch(group)
        return group.replies(answer) if isinstance(answer, bytes) else answer

    def fetch(self, group: ReadGroup) -> bytes | dict[int, Reply]:
        """Read from many servos at once: as ``sync_read``, but a flawless answer as it came.

        Raises:
            PortError: If the port is gone.
        """
        link = self._link
        deadline = link.send(group.request, len(group.ids), group.reply_length)
        data = link.receive(group.sure_length, deadline)
        if group.settled and group.is_flawless(data):
            return data
        left = group.reply_length - group.sure_length
        if left:  # for those that were lost last time nobody else shall wait for long
            deadline = min(deadline, link.soon(len(group.ids), left))
        replies, unfinished = group.parse(data)
        if unfinished and len(data) >= group.reply_length:  # damaged, or there was noise before it
            deadline = min(deadline, link.soon(0, 0))
        while unfinished and (more := link.receive_some(deadline)):
            data += more
            replies, unfinished = group.parse(data)
        group.learn(replies)
        return replies

    def sync_write(self, group: WriteGroup, values: Sequence[int]) -> None:
        """Write to many servos at once; nobody answers.

        Those that speak Protocol 1.0 are written to one by one, whatever the group says.

        Raises:
            PortError: If the port is gone.
        """
        old = self._old(group.ids)
        if not (old and isinstance(group, GroupWrite)):
            self._link.send(group.frame(values))
            return
        group.frame(values)  # refuses what cannot be written
        modern: list[Block] = []
        for_modern: list[int] = []
        for block, own in zip(group.blocks, shares(group.blocks, values), strict=True):
            if block.servo_id in old:
                self._link.send(GroupWriteV1([block]).frame(own))
            else:
                modern.append(block)
                for_modern += own
        if modern:
            self._link.send(GroupWrite(modern).frame(for_modern))

    def reboot(self, servo_id: int) -> None:
        """Let a servo start anew; its torque goes off, latched errors and turn counts are gone.

        Raises:
            BusTimeoutError: If it does not answer.
            ServoError: If it refuses.
        """
        self._do(servo_id, Instruction.REBOOT, tries=1)

    def clear_turns(self, servo_id: int) -> None:
        """Let a servo forget whole turns: its position is within one turn from here on.

        Raises:
            BusTimeoutError: If it does not answer.
            ServoError: If it refuses, as it does while it moves.
        """
        self._do(servo_id, Instruction.CLEAR, _CLEAR_TURNS)

    def factory_reset(self, servo_id: int, *, keep_id: bool = True, keep_baud: bool = True) -> None:
        """Give a servo back what it was set to in the factory.

        A servo of Protocol 1.0 keeps nothing, whatever is asked.

        Raises:
            ValueError: If what it shall keep no such servo can keep.
            BusTimeoutError: If it does not answer.
        """
        old = self._dialect(servo_id).number == 1
        if keep_baud and not keep_id:
            raise ValueError("keep_baud: want False too where keep_id is False, got True")
        if old and keep_id:
            raise ValueError("keep_id: want False for a servo of Protocol 1.0, got True")
        option = _KEEP_ID_AND_BAUD if keep_baud else _KEEP_ID if keep_id else _ALL
        params = b"" if old else bytes((option,))
        self._do(servo_id, Instruction.FACTORY_RESET, params, tries=1)

    def _old(self, ids: Sequence[int]) -> set[int]:
        """Give those of some servos that speak Protocol 1.0."""
        return {i for i in ids if self._protocols.get(i, 2) == 1} if self._protocols else set()

    def _dialect(self, servo_id: int) -> Dialect:
        return DIALECTS[self._protocols.get(servo_id, 2)]

    def _read(self, servo_id: int, address: int, size: int, name: str) -> bytes:
        """Read bytes of one servo."""
        params = self._dialect(servo_id).read_params(address, size)
        return self._do(servo_id, Instruction.READ, params, about=name, answer=size).params

    def _do(
        self,
        servo_id: int,
        instruction: Instruction,
        params: bytes = b"",
        about: str = "",
        *,
        answer: int = 0,
        tries: int = _TRIES,
    ) -> Packet:
        """Send one instruction and give the status that answers it, trying again if it is lost."""
        dialect = self._dialect(servo_id)
        frame = dialect.frame(servo_id, instruction, params)
        heard = _Heard()
        for attempt in range(tries):
            self._retries[servo_id] += attempt > 0
            heard = self._hear(dialect, servo_id, frame, answer)
            if heard.answer is not None:
                _refuse(heard.answer, about or instruction.name.lower().replace("_", " "))
                return heard.answer
        if heard.other is not None:
            actual = f"one with {len(heard.other.params)}"
            raise PacketError(f"a status with {answer} bytes of servo {servo_id}", actual)
        if heard.damaged:
            raise PacketError(f"an answer of servo {servo_id}", "a damaged packet")
        raise BusTimeoutError(servo_id, about, port=self.port)

    def _hear(self, dialect: Dialect, servo_id: int, frame: bytes, answer: int) -> "_Heard":
        """Send a packet; give the status that answers it, or what came instead.

        A status with other than ``answer`` bytes answers something else: an instruction before it
        that was given up too soon.
        """
        link = self._link
        deadline = link.send(frame, 1, dialect.status_length + answer)
        deadline += max(_PATIENCE - link.margin, 0.0)
        came, heard = b"", _Heard()
        while data := link.receive_some(deadline):
            came += data
            listener = dialect.listener()
            # an adapter may echo; in Protocol 1.0 nothing else tells an echo from an answer
            other = None
            for packet in listener.feed(came.removeprefix(frame)):
                if packet.servo_id != servo_id:
                    continue
                if len(packet.params) == answer or _number(packet):
                    return _Heard(answer=packet)
                other = packet
            heard = _Heard(other=other, damaged=listener.damaged)
        return heard


class _Heard(NamedTuple):
    """What came after an instruction."""

    answer: Packet | None = None
    """The status that answers it."""
    other: Packet | None = None
    """A status of that servo that answers something else."""
    damaged: bool = False
    """Whether something came that was damaged."""


def _number(packet: Packet) -> int:
    """Give the error number of a status; 0: none."""
    return packet.error & ~ALERT_BIT & 0xFF


def _refuse(packet: Packet, what: str) -> None:
    """Raise if the error byte of a status holds an error number."""
    number = _number(packet)
    if number:
        text = ERROR_TEXTS.get(number, f"error {number}")
        reason = f"{what} refused: {text}"
        raise ServoError(packet.servo_id, reason, code=number, alert=packet.alert)
