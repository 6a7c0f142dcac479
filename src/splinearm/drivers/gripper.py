"""A gripper on the bus of an arm: opened and closed by position, with a limited force.

It shares the bus, and the thread, with the arm. Nothing is asked of its servo before its first use.
From then on it has torque and keeps its last goal, whatever becomes of the arm or of this program:
its own bus watchdog stays off, as that would let go what it holds.
"""

import time
from collections.abc import Callable

import numpy as np

from splinearm.errors import BusError, ServoError

from . import grip_start
from .asking import read_all
from .bus import Reply, ServoBus, loss_error
from .chain import ServoChain, ServoSpec
from .cyclic import GroupRead
from .gauge import Gauge
from .grip_force import force_register
from .grip_line import GripLine
from .grip_line import GripState as GripState
from .groups import BulkRead
from .health import HealthReading, HealthWatch, health_limits
from .packets import ALERT_BIT
from .recover import Fault, recover_servos, restore
from .startup import hardware_error

_GOAL, _PRESENT, _TORQUE = "Goal Position", "Present Position", "Torque Enable"
_LONGEST = 5.0
"""How long a motion may take beyond what its servo's profile takes, s, before it is an error."""
_LATE = 0.1
"""How much later than its servo's profile it counts as blocked, s."""
_MOVED = 3.0
"""So far it must have come, percent, to count as blocked before."""
_AGREEING = 3
"""So many looks in a row must say the same."""
_GLANCE = 0.02
"""Time between two looks while waiting, s."""
_WATCH = 0.2
"""Time between two looks on the way of the arm, s."""
_SOON = 0.05
"""The same while it may be losing what it held."""
_PATIENCE = 3
"""How often in a row it may be silent before it counts as lost."""


class Gripper:
    """A gripper's servo.

    Args:
        bus: The bus it hangs on, open; the arm that owns it closes it.
        servo: The servo, of the role gripper.

    Raises:
        ValueError: If it is of another role, or cannot be a gripper.
    """

    def __init__(self, bus: ServoBus, servo: ServoSpec) -> None:
        if servo.grip is None:
            raise ValueError(f"servo {servo.name!r}: want a gripper, got a {servo.role.value}")
        force_register(servo)
        self._bus = bus
        self._servo = servo
        self._grip = servo.grip
        self._gauge = Gauge.of(servo.servo_model)
        first = self._gauge.registers[0].address
        request = BulkRead(servo.servo_id, first, self._gauge.length)
        self._reader = GroupRead([request], fast=False)
        self._line: GripLine | None = None
        self._health: HealthWatch | None = None
        self._goal = 0
        self._limit = 0
        self._state: GripState | None = None
        self._begin: GripState | None = None
        self._due = 0.0
        self._agreed = 0
        self._holds = False
        self._missed = 0

    @property
    def name(self) -> str:
        """What the arm's file calls it."""
        return self._servo.name

    @property
    def ready(self) -> bool:
        """Whether it was taken, and has torque from here on."""
        return self._line is not None

    @property
    def settled(self) -> bool:
        """Whether it has arrived, or stands because something is in its way, by the last looks."""
        state = self._state
        if state is None or self._agreed < _AGREEING:
            return False
        return state.arrived or (state.holding and self._has_begun(state))

    @property
    def health(self) -> HealthReading:
        """How its servo fares; all NaN before its first use."""
        if self._health is None:
            return HealthReading()
        return self._health.readings[self._servo.servo_id]

    def take(self) -> None:
        """Check the servo and switch its torque on where it stands; the first use does it too.

        One that has torque is left as it is, also what it holds. No register of the EEPROM is
        written.

        Raises:
            ServoError: If it is not calibrated, not as the file says, or has stopped itself.
            BusError: If it does not answer.
        """
        self._take()

    def _take(self, *, recovered: bool = False) -> GripLine:
        bus, servos = self._bus, [self._servo]
        self._line = None
        line = grip_start.begin(bus, self._servo, self._gauge, recovered=recovered)
        self._health = HealthWatch(bus, servos, 1, health_limits(bus, servos))
        self._goal, self._limit = self._ask(_GOAL), abs(self._ask(line.force.name))
        self._line = line
        self._forget()
        for _ in range(_AGREEING + 1):  # whether it holds something by now
            self.look()
        return line

    def open(self, force: float | None = None) -> GripState:
        """Open it, and wait until it is open or stands; see ``move``."""
        return self.move(100.0, force)

    def close(self, force: float | None = None, *, current: float | None = None) -> GripState:
        """Close it, and wait until it is closed or holds something; see ``move``.

        Args:
            force: How hard, a share of the servo's stall torque; None: as the arm's file says.
            current: The same as a current, A, of servos that measure it.

        Raises:
            ValueError: If both are given, or the servo measures no current.
        """
        if current is not None:
            if force is not None:
                raise ValueError("current: want a force or a current, got both")
            amps = self._taken().force.stall_current
            if amps is None:
                raise ValueError(f"current: {self._servo.model} measures none; give a force")
            force = current / amps
        return self.move(0.0, force)

    def move(
        self,
        percent: float,
        force: float | None = None,
        *,
        wait: Callable[[float], object] | None = None,
    ) -> GripState:
        """Move it, and wait until it has arrived or stands because something is in its way.

        Args:
            percent: How far it shall be open: 0 is closed, 100 is open.
            force: How hard it may press, a share of the servo's stall torque; None: as the arm's
                file says.
            wait: Lets a number of seconds go by; None: ``time.sleep``.

        Returns:
            Where it is and whether it holds something.

        Raises:
            ValueError: If a number is out of its range.
            ServoError: If its servo has stopped itself, or it neither arrives nor stands.
            HealthError: If its servo is too hot or badly fed.
            BusError: If it does not answer.
        """
        self.send(percent, force)
        begun = time.monotonic()
        while True:
            state = self.look()
            if self.settled:
                return state
            self.require_going(state, state.t - begun)
            (wait or time.sleep)(_GLANCE)

    def require_going(self, state: GripState, since: float) -> None:
        """Refuse a motion that has taken too long.

        Args:
            state: How it fares.
            since: How long ago it was sent, s.

        Raises:
            ServoError: If it was too long ago.
        """
        if since > _LONGEST + self._taken().duration:
            raise self._refused(
                f"it neither arrives nor stands after {since:.0f} s ({state.words}); look for what "
                "is in the way of its fingers and gears, or close with more force"
            )

    def send(self, percent: float, force: float | None = None) -> None:
        """Tell it where to go and return at once; ``look`` says how it fares.

        Raises:
            ValueError: If a number is out of its range.
            ServoError: If it is not ready; see ``take``.
            BusError: If it does not answer.
        """
        line = self._taken()
        limit = self.check(percent, force)
        if limit != self._limit:
            self._write(line.force.name, limit)
            self._limit = limit
        before, self._goal = self._goal, line.ticks(percent)
        self._write(_GOAL, self._goal)
        self._forget()
        share = abs(self._goal - before) / abs(line.travel)
        self._due = time.monotonic() + share * line.duration + _LATE

    def check(self, percent: float, force: float | None = None) -> int:
        """Refuse, before anything moves, what ``send`` would refuse; takes the servo.

        Returns:
            What its register holds for that force.

        Raises:
            ValueError: If a number is out of its range.
            BusError: As ``take``.
        """
        if not 0.0 <= percent <= 100.0:
            raise ValueError(f"percent: want 0 (closed) to 100 (open), got {percent}")
        return self._taken().force.raw(self._grip.force if force is None else force)

    def look(self) -> GripState:
        """Ask how it fares: one transaction, now and then two.

        Raises:
            ServoError: If its servo has latched a hardware error or has lost its torque.
            HealthError: If it is too hot or badly fed.
            BusTimeoutError: If it was silent three times in a row.
        """
        line = self._taken()
        while (reply := self._reply()) is None:
            pass
        return self._understand(line, reply)

    def _understand(self, line: GripLine, reply: Reply) -> GripState:
        t = time.monotonic()
        measured = self._gauge.read(reply.data)
        state = line.state(t, measured, self._goal, self._limit)
        if self._health is not None:
            self._health.look(t, np.array([line.effort_of(measured.load)]))
        before, self._state = self._state, state
        self._begin = self._begin or state
        same = before is not None and _kind(before) == _kind(state)
        self._agreed = self._agreed + 1 if same else 1
        if self.settled:
            self._holds |= state.holding
        return state

    def watch(self, t: float) -> str | None:
        """Look after it on the way of the arm, five times a second; call it in every cycle.

        Args:
            t: The present on the monotonic clock, s.

        Returns:
            A line if it has lost what it held, else None.

        Raises:
            BusError: As ``look``.
        """
        if self._line is None:
            return None
        pause = _SOON if self.in_doubt else _WATCH
        if self._state is not None and t - self._state.t < pause:
            return None
        reply = self._reply()
        if reply is None:  # it is asked again in the next cycle
            return None
        state = self._understand(self._line, reply)
        if not self._holds or state.holding or state.moving or self._agreed < 2:
            return None
        self._holds = False
        return f"{self.name} has lost what it held: it {state.words}"

    @property
    def in_doubt(self) -> bool:
        """Whether it may just be losing what it held; the next looks will tell."""
        return self._holds and self._state is not None and not self._state.holding

    @property
    def holds(self) -> bool:
        """Whether it has held something since it was last sent somewhere, and not lost it."""
        return self._holds

    def hold(self) -> None:
        """Stop a motion where it is; what it presses against it goes on pressing against.

        Raises:
            BusError: If it does not answer.
        """
        if self._line is None or self.settled or self.look().holding:
            return
        ends = sorted((self._line.ticks(0.0), self._line.ticks(100.0)))
        self._goal = min(max(self._ask(_PRESENT), ends[0]), ends[1])
        self._write(_GOAL, self._goal)
        self._forget()

    def release(self) -> None:
        """Switch its torque off: it lets go. The next use takes it again.

        Raises:
            BusError: If it does not answer.
        """
        self._line = None
        self._forget()
        self._write(_TORQUE, 0)

    def recover(self) -> tuple[Fault, ...]:
        """Bring it back after its servo has stopped itself or its port was gone; it then holds.

        What it held may have fallen meanwhile: tell it to close again.

        Returns:
            The hardware errors that were latched.

        Raises:
            BusError: If something still is in the way; it says what helps.
        """
        servos = [self._servo]
        faults = recover_servos(self._bus, servos, health_limits(self._bus, servos))
        if faults:  # it has no torque now
            restore(self._bus, servos)
        self._take(recovered=bool(faults))
        return faults

    def _taken(self) -> GripLine:
        """Give how it is read; take it first if that was not done."""
        return self._take() if self._line is None else self._line

    def _has_begun(self, state: GripState) -> bool:
        """Tell whether it was, or must have been, on its way: until then it presses as before.

        Its servo's profile begins at its last goal, which it may not have reached.
        """
        begin = state if self._begin is None else self._begin
        return state.t > self._due or abs(state.percent - begin.percent) > _MOVED

    def _forget(self) -> None:
        """Know nothing of how it fares."""
        self._state = self._begin = None
        self._due = 0.0
        self._agreed = 0
        self._holds = False

    def _reply(self) -> Reply | None:
        """Ask for its motion once; None if the answer was lost, but not too often in a row."""
        servo = self._servo
        reply = self._bus.sync_read(self._reader)[servo.servo_id]
        if reply.loss is not None:
            self._missed += 1
            if self._missed < _PATIENCE:
                return None
            self._missed = 0
            raise loss_error(reply, servo.servo_id, _PRESENT, port=self._bus.port, name=servo.name)
        self._missed = 0
        if reply.error & ALERT_BIT:
            raise self._latched(reply.latched)
        return reply

    def _latched(self, told: int) -> BusError:
        register = self._servo.servo_model.table.get("Hardware Error Status")
        status = told if register is None else self._bus.read(self._servo.servo_id, register)
        return hardware_error(self._servo, status)

    def _ask(self, name: str) -> int:
        return read_all(self._bus, [self._servo], name)[self._servo.servo_id]

    def _write(self, name: str, value: int) -> None:
        self._bus.write(self._servo.servo_id, self._servo.servo_model.table[name], value)

    def _refused(self, reason: str) -> ServoError:
        return ServoError(self._servo.servo_id, reason, name=self._servo.name)


def gripper_on(chain: ServoChain, bus: ServoBus) -> Gripper | None:
    """Give the gripper of a chain on its bus, None without one; nothing is asked of it yet."""
    servo = chain.gripper
    return None if servo is None else Gripper(bus, servo)


def _kind(state: GripState) -> tuple[bool, bool, bool]:
    return state.moving, state.arrived, state.holding
