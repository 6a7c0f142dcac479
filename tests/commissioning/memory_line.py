"""Servos and a person without port, thread or time, to be stopped before any write."""

from splinearm.commissioning.bench import Bench
from splinearm.commissioning.setup import Setup
from splinearm.config import load_cell
from splinearm.drivers.client import ServoClient
from splinearm.drivers.packets import Instruction
from splinearm.errors import PortError
from splinearm.sim.choice import Choices
from splinearm.sim.ear import Ear
from splinearm.sim.line import Line
from splinearm.sim.shaft import Shaft
from splinearm.sim.virtual_servo import VirtualServo

QUIET = frozenset(
    (Instruction.PING, Instruction.READ, Instruction.SYNC_READ, Instruction.BULK_READ)
)


class KilledError(BaseException):
    """The program is gone."""


class MemoryLine:
    """The servos of an arm, and the wire to them."""

    def __init__(self, cell, *, fresh=True):
        self.servos = {}
        for k, spec in enumerate(cell.chain.servos):
            servo = VirtualServo.of(spec, cell.chain.baud, Shaft())
            servo.choices = Choices(boot_time=0.0)
            servo.shaft.angle = 0.01 + 0.1 * k
            if fresh:
                servo.swap()
            servo.unplugged = fresh
            self.servos[spec.name] = servo
        self.line = Line(self.servos.values())
        self.writes = 0
        self.kill_at = None
        self.loss_at, self.loss = None, ""
        self.now = 0.0
        self.later = None

    def connect(self, *names):
        for name, servo in self.servos.items():
            plugged = name in names or not names
            if plugged and servo.unplugged:
                servo.power_cycle()
            servo.unplugged = not plugged

    def lose_at(self, writes, loss):
        """Before a write let a servo, the power, the port, or the power for a moment be lost."""
        self.loss_at, self.loss = writes, loss

    def _lose(self):
        servos = list(self.servos.values())
        if self.loss == "the port":
            raise PortError("/dev/ttyMEM", "it is gone", "plug it in")
        if self.loss == "a moment":
            for servo in servos:
                if not servo.unplugged:
                    servo.power_cycle()
            return
        for servo in servos if self.loss == "the power" else [servos[self.writes % len(servos)]]:
            servo.unplugged = True

    def hear(self, heard, baud):
        if heard.packet.instruction not in QUIET:
            if self.writes == self.kill_at:
                raise KilledError
            if self.writes == self.loss_at:
                self.loss_at = None
                self._lose()
            self.writes += 1
        replies = self.line.answer(heard.packet, baud, heard.protocol, damaged=heard.damaged)
        return b"".join(reply.data for reply in replies)

    def bench(self):
        def sleep(seconds):
            self.now += seconds
            if self.later is not None:
                names, self.later = self.later, None
                self.connect(*names)

        return Bench("/dev/ttyMEM", opener=self._open, clock=lambda: self.now, sleep=sleep)

    def _open(self, port, baud):
        if baud > 4_500_000:
            raise PortError(port, f"it does not run at {baud} baud", "choose another")
        return _Client(_Link(self, port, baud))

    def tables(self, *, skip=()):
        """What every servo holds that is written and not measured, by name."""
        return {
            name: {
                r.name: servo.memory[r.name]
                for r in servo.model.table.registers
                if r.writable and r.name not in skip and not r.name.startswith(("Goal", "Indirect"))
            }
            for name, servo in self.servos.items()
        }


class _Link:
    margin = 0.01

    def __init__(self, line, port, baud):
        self.port, self.baud = port, baud
        self._line, self._ear, self._came = line, Ear(), b""

    def send(self, frame, answers=0, answer_bytes=0):
        self._came = b""
        for heard in (*self._ear.feed(frame), *self._ear.pause(1.0)):
            self._came += self._line.hear(heard, self.baud)
        return 0.0

    def receive_some(self, deadline):
        came, self._came = self._came, b""
        return came

    def receive(self, count, deadline):
        return self.receive_some(deadline)

    def deadline(self):
        return 0.0

    def soon(self, answers, answer_bytes):
        return 0.0


class _Client(ServoClient):
    def close(self):
        pass


class Helper:
    """A person who does as asked, and remembers."""

    def __init__(self, line, *, falls=True, agrees=True):
        self.line, self.falls, self.will = line, falls, agrees
        self.told, self.asked, self.tables, self.let_fall = [], [], [], []

    def tell(self, words):
        self.told.append(words)

    def agrees(self, tasks):
        self.tables.append(tasks)
        return self.will

    def allows(self, words):
        self.asked.append(words)
        return self.will

    def lets_fall(self, names):
        self.let_fall.append(tuple(names))
        return self.falls

    def connects(self, servo):
        self.asked.append(servo.name)
        self.line.connect("nobody")
        self.line.later = (servo.name,)

    def connects_all(self, names):
        self.asked.append("all")
        self.line.later = ()

    def is_it(self, servo, one):
        real = self.line.servos[servo.name]
        return not real.unplugged and (real.baud, real.servo_id) == (one.address[0], one.address[2])


def set_up(line, cell, person=None, **options):
    """Run setup once on a line; give the report."""
    person = person or Helper(line)
    with line.bench() as bench:
        return Setup(bench, cell, person, **options).run()


def checked(line, cell):
    """Look what is left to do."""
    with line.bench() as bench:
        return Setup(bench, cell, Helper(line)).check()


__all__ = ["Helper", "KilledError", "MemoryLine", "checked", "load_cell", "set_up"]
