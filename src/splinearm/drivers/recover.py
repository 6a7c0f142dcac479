"""Bringing back servos that have stopped themselves: reboot, settings, nothing that moves.

A servo that finds itself too hot, overloaded or badly fed latches a hardware error and cuts its
torque; only a reboot clears that. It then is as after a loss of power: its RAM has initial values,
its turns are forgotten. The other servos are not touched and go on holding.
Source: ROBOTIS e-Manual, "Shutdown", "Hardware Error Status", "Reboot".
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from splinearm.errors import BusError, BusTimeoutError, ServoError

from .ability import can_reboot, having, voltage_register
from .asking import read_all, read_latched
from .bus import ServoBus
from .chain import ServoSpec
from .health_limit import HealthLimits
from .startup import check_settings, hardware_error, let_all_answer, write_ram_settings
from .watchdog import let_go

BOOT_TIMEOUT = 3.0
"""How long a servo may take to answer after a reboot, s; most take 0.2 to 0.5 s."""

_TRIES = 3
_PAUSE = 0.05
_SETTLED = 0.15
"""After that time a servo has looked at its supply and temperature again, s: an estimate."""

_LIMIT, _MOST = "Torque Limit", "Max Torque"
_HOT, _FED, _ENCODER = "overheating", "input voltage", "motor encoder"


@dataclass(frozen=True, slots=True, eq=False)
class Fault:
    """A hardware error that a servo has latched."""

    servo: ServoSpec
    """The servo."""
    status: int
    """Its Hardware Error Status."""

    @property
    def causes(self) -> tuple[str, ...]:
        """What it says is wrong, in words."""
        return self.servo.servo_model.hardware_errors(self.status)

    def __str__(self) -> str:
        where = f"joint {self.servo.joint!r}" if self.servo.joint else "the gripper"
        causes = " and ".join(self.causes) or f"unknown (0x{self.status:02X})"
        return f"servo {self.servo.servo_id} ({self.servo.name}) at {where}: {causes}"


def find_faults(bus: ServoBus, servos: Sequence[ServoSpec]) -> tuple[Fault, ...]:
    """Give the hardware errors that servos have latched.

    Raises:
        BusError: If a servo does not answer.
    """
    status = read_latched(bus, servos)
    return tuple(Fault(s, status[s.servo_id]) for s in servos if status[s.servo_id])


def require_recoverable(
    bus: ServoBus, faults: Sequence[Fault], limits: Mapping[int, HealthLimits]
) -> None:
    """Refuse faults that a reboot would not mend, or that a person must look at first.

    Args:
        bus: The bus.
        faults: The faults.
        limits: By id what is borne, with a number in every field.

    Raises:
        ServoError: With what helps: of a servo that is still as hot as a warning is worth, whose
            supply is still outside its limits, or whose encoder has failed.
        BusError: If a servo does not answer.
    """
    for fault in faults:
        servo, borne = fault.servo, limits[fault.servo.servo_id]
        if _ENCODER in fault.causes:
            raise _refused(
                fault,
                "its encoder cannot be trusted: support the arm, switch the servo's power off and "
                "on, see that Present Position follows the joint moved by hand, and replace the "
                "servo if it does not",
            )
        if _HOT in fault.causes:
            degrees = read_all(bus, [servo], "Present Temperature")[servo.servo_id]
            if degrees >= borne.temperature_warn:
                raise _refused(
                    fault,
                    f"it is still at {degrees} degC: let it cool down below "
                    f"{borne.temperature_warn:g} degC, then try again",
                )
        if _FED in fault.causes:
            supply = voltage_register(servo.servo_model).name
            volts = read_all(bus, [servo], supply)[servo.servo_id] / 10.0
            if not borne.voltage_low_stop < volts < borne.voltage_high_stop:
                raise _refused(
                    fault,
                    f"its supply is {volts:g} V, outside {borne.voltage_low_stop:g} to "
                    f"{borne.voltage_high_stop:g} V: mend the supply, then try again",
                )


def recover_servos(
    bus: ServoBus, servos: Sequence[ServoSpec], limits: Mapping[int, HealthLimits]
) -> tuple[Fault, ...]:
    """Reboot the servos that have latched a hardware error; none of them has torque after that.

    Returns:
        What was wrong; empty if nothing was.

    Raises:
        ServoError: Before anything is rebooted, if a fault would not be mended by that or a person
            must look at it first; after it, if a servo is as ill as before.
        BusError: If a servo does not answer.
    """
    faults = find_faults(bus, servos)
    require_recoverable(bus, faults, limits)
    reboot(bus, [fault.servo for fault in faults])
    return faults


def reboot(bus: ServoBus, servos: Sequence[ServoSpec]) -> None:
    """Let servos start anew and wait until they answer, rid of their errors.

    A shadow that obeys its leader's id too starts anew with its leader. Servos that know no reboot
    are left to ``restore``.

    Raises:
        BusTimeoutError: If a servo does not come back.
        ServoError: If it is as ill as before.
    """
    able = [servo for servo in servos if can_reboot(servo.servo_model)]
    for servo in able:
        _begin_anew(bus, servo)
    deadline = time.monotonic() + BOOT_TIMEOUT
    for servo in able:
        _await_answer(bus, servo, deadline)
    time.sleep(_SETTLED if able else 0.0)
    for fault in find_faults(bus, able):  # others say so until their torque is on again
        raise hardware_error(fault.servo, fault.status)


def _begin_anew(bus: ServoBus, servo: ServoSpec) -> None:
    """Tell a servo to reboot; if that is not answered, see whether it was heard."""
    for _ in range(_TRIES):
        try:
            bus.reboot(servo.servo_id)
        except BusTimeoutError:
            _await_answer(bus, servo, time.monotonic() + BOOT_TIMEOUT)
            if not find_faults(bus, [servo]):
                return
        else:
            return


def restore(
    bus: ServoBus, servos: Sequence[ServoSpec], leaders: Mapping[int, ServoSpec] | None = None
) -> None:
    """Give servos that have lost their RAM all that the arm's file says, but no torque.

    Args:
        bus: The bus.
        servos: The servos, leaders before their shadows.
        leaders: As for ``write_ram_settings``.

    Raises:
        BusError: If a servo does not answer.
        ServoError: If its EEPROM is not as the file says any more.
    """
    if not servos:
        return
    let_all_answer(bus, servos)
    check_settings(bus, servos)
    let_go(bus, servos)
    _lift_torque_limit(bus, servos)
    write_ram_settings(bus, servos, leaders)


def _lift_torque_limit(bus: ServoBus, servos: Sequence[ServoSpec]) -> None:
    """Give servos back the Torque Limit that a hardware error took, with their torque off.

    One that does not reboot would go for its old goal otherwise.
    """
    limited = having(servos, _LIMIT)
    most = read_all(bus, limited, _MOST)
    for servo in limited:
        table = servo.servo_model.table
        bus.write(servo.servo_id, table["Torque Enable"], 0)
        bus.write(servo.servo_id, table[_LIMIT], most[servo.servo_id])


def _await_answer(bus: ServoBus, servo: ServoSpec, deadline: float) -> None:
    """Ping a servo until it answers."""
    while True:
        time.sleep(_PAUSE)
        try:
            bus.ping(servo.servo_id)
        except BusTimeoutError as error:
            if time.monotonic() > deadline:
                raise BusTimeoutError(servo.servo_id, port=bus.port, name=servo.name) from error
        except BusError:  # bytes of a servo that is just waking up
            if time.monotonic() > deadline:
                raise
        else:
            return


def _refused(fault: Fault, remedy: str) -> ServoError:
    return ServoError(
        fault.servo.servo_id,
        f"it reports {' and '.join(fault.causes)} and is not recovered: {remedy}",
        alert=True,
        name=fault.servo.name,
    )
