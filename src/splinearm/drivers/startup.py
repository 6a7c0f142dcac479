"""What must be so before an arm of servos may be switched on.

Everything is asked of all servos at once; the first thing that is not as the arm's file says is
raised with the servo, the register, what was found, what was wanted and what helps.
"""

import logging
from collections.abc import Mapping, Sequence

from splinearm.errors import BusTimeoutError, ServoError

from .ability import broken_promises, can_reboot, having
from .asking import read_all, read_latched
from .bus import PingReply, ServoBus
from .chain import ServoSpec
from .cyclic import GroupWrite
from .model import servo_model_by_number
from .registers import Area
from .scaling import operating_mode

_log = logging.getLogger(__name__)

_NO_SECONDARY_ID = 253
"""From here on the Secondary(Shadow) ID means that there is none."""
_DECISIVE = ("Drive Mode", "Operating Mode", "Control Mode", "Secondary(Shadow) ID")
"""Registers that decide where a goal sends the arm, besides Homing Offset."""
_JOINT_MODE = 2
"""What Control Mode of an XL-320 is for a joint."""
_PROFILE = ("Profile Acceleration", "Profile Velocity", "Moving Speed")
_ANSWER_ALL = 2
"""Status Return Level at which every instruction is answered."""


def warn_of_promises(servos: Sequence[ServoSpec]) -> None:
    """Say once what is promised of servos in general and cannot be of those with a small table."""
    told: dict[str, list[str]] = {}
    for servo in servos:
        for words in broken_promises(servo):
            told.setdefault(f"{servo.model} has {words}", []).append(servo.name)
    for words, names in told.items():
        _log.warning("%s: %s", ", ".join(names), words)


def require_calibration(leaders: Sequence[ServoSpec]) -> None:
    """Refuse leaders whose joint zero is not known."""
    for servo in leaders:
        if servo.zero_ticks is None:
            raise ServoError(
                servo.servo_id,
                f"where joint {servo.joint!r} is zero is not known; find it by `splinearm "
                "calibrate`, or write its zero_ticks into the arm's file",
                name=servo.name,
            )


def call_roll(bus: ServoBus, servos: Sequence[ServoSpec]) -> dict[int, PingReply]:
    """Ping every servo; give by id what it says of itself.

    A shadow must be there like its leader: without it half of the torque is missing, and one that
    only lost its data line would go on holding against its leader.

    Raises:
        BusTimeoutError: If a servo does not answer.
        ServoError: If a servo is of another model.
    """
    return {servo.servo_id: _ping(bus, servo) for servo in servos}


def _ping(bus: ServoBus, servo: ServoSpec) -> PingReply:
    """Ping a servo and see that it is what the file says."""
    try:
        reply = bus.ping(servo.servo_id)
    except BusTimeoutError as error:
        raise BusTimeoutError(servo.servo_id, port=bus.port, name=servo.name) from error
    wanted = servo.servo_model
    if reply.model_number != wanted.number:
        try:
            found = servo_model_by_number(reply.model_number).name
        except ValueError:
            found = f"model number {reply.model_number}"
        raise ServoError(
            servo.servo_id,
            f"found a {found}, wanted a {wanted.name}; correct the model in the arm's file, or "
            "the id of the servo",
            name=servo.name,
        )
    return reply


def let_all_answer(bus: ServoBus, servos: Sequence[ServoSpec]) -> None:
    """Make every servo answer every instruction, also one that was told not to."""
    name = "Status Return Level"
    targets = [(servo.servo_id, servo.servo_model.table[name]) for servo in servos]
    bus.sync_write(GroupWrite(targets), [_ANSWER_ALL] * len(targets))


def check_settings(bus: ServoBus, servos: Sequence[ServoSpec]) -> None:
    """Refuse servos that are not set as the arm's file says.

    Drive Mode, Operating Mode, Homing Offset and Secondary ID decide where a goal sends the arm:
    they must agree. What else the file says of the EEPROM is compared too, and told by a warning.

    Raises:
        ServoError: With servo, register, what was found, what was wanted, and what helps.
    """
    for name in _DECISIVE:
        found = read_all(bus, having(servos, name), name)
        for servo in having(servos, name):
            _agree(servo, name, _known(name, found[servo.servo_id]), _wanted(servo, name))
    homing = read_all(bus, having(servos, "Homing Offset"), "Homing Offset")
    for servo in having(servos, "Homing Offset"):
        if is_coupled(servo) and "Homing Offset" not in servo.settings:
            continue  # it makes up for how the shadow is mounted; where it stands is compared
        wanted = servo.settings.get("Homing Offset", 0)
        _agree(servo, "Homing Offset", homing[servo.servo_id], wanted)
    _tell_other_settings(bus, servos)


def is_coupled(servo: ServoSpec) -> bool:
    """Say whether a servo also obeys what is sent to another id."""
    return servo.settings.get("Secondary(Shadow) ID", 255) < _NO_SECONDARY_ID


def _wanted(servo: ServoSpec, name: str) -> int:
    """Give what a register must hold that decides where a goal sends the arm."""
    if name == "Operating Mode":
        return operating_mode(servo)
    usual = {"Control Mode": _JOINT_MODE, "Secondary(Shadow) ID": _NO_SECONDARY_ID}
    return _known(name, servo.settings.get(name, usual.get(name, 0)))


def _known(name: str, value: int) -> int:
    """Take all values of a register alike that mean the same."""
    return min(value, _NO_SECONDARY_ID) if name == "Secondary(Shadow) ID" else value


def _agree(servo: ServoSpec, register: str, found: int, wanted: int) -> None:
    """Refuse a servo whose register holds something else."""
    if found != wanted:
        raise ServoError(
            servo.servo_id,
            f"{register} is {found}, wanted {wanted}; with its torque off set the servo to "
            f"{wanted}, or correct the arm's file",
            name=servo.name,
        )


def _tell_other_settings(bus: ServoBus, servos: Sequence[ServoSpec]) -> None:
    """Warn of EEPROM settings that differ from the file."""
    told = (*_DECISIVE, "Homing Offset")
    names = {
        name
        for servo in servos
        for name in servo.settings
        if name not in told and servo.servo_model.table[name].area is Area.EEPROM
    }
    for name in sorted(names):
        concerned = [servo for servo in servos if name in servo.settings]
        found = read_all(bus, concerned, name)
        for servo in concerned:
            have, want = found[servo.servo_id], servo.settings[name]
            if have != want:
                _log.warning(
                    "servo %d (%s): %s is %d, the arm's file says %d",
                    servo.servo_id,
                    servo.name,
                    name,
                    have,
                    want,
                )


def check_health(bus: ServoBus, servos: Sequence[ServoSpec]) -> None:
    """Refuse servos that have latched a hardware error.

    Raises:
        ServoError: With the errors by name.
    """
    status = read_latched(bus, servos)
    for servo in servos:
        if status[servo.servo_id]:
            raise hardware_error(servo, status[servo.servo_id])


def hardware_error(servo: ServoSpec, status: int) -> ServoError:
    """Make the error of a servo that reports a hardware error."""
    model = servo.servo_model
    faults = " and ".join(model.hardware_errors(status)) or "an unknown fault"
    how = "reboots it" if can_reboot(model) else "gives it its Torque Limit again"
    return ServoError(
        servo.servo_id,
        f"it reports {faults} (Hardware Error Status 0x{status:02X}) and may have cut its torque; "
        f"remove the cause, support the arm, then recover it, which {how}, or switch its power "
        "off and on",
        alert=True,
        name=servo.name,
    )


def write_ram_settings(
    bus: ServoBus, servos: Sequence[ServoSpec], leaders: Mapping[int, ServoSpec] | None = None
) -> None:
    """Write what the arm's file says of the RAM: gains, profile and the like.

    Unless the file says otherwise a servo goes to a goal at once (profile 0): the motion's profile
    is in its setpoints, and a second one would only lag behind.

    Args:
        bus: The bus.
        servos: The servos, leaders before their shadows.
        leaders: By id of each shadow that also obeys its leader's id that leader: what is written
            to the one reaches the other, so that a shadow has its leader's settings where the file
            says none of its own.
    """
    for servo in servos:
        table = servo.servo_model.table
        wanted = {name: 0 for name in _PROFILE if name in table}
        leader = (leaders or {}).get(servo.servo_id)
        for source in (servo,) if leader is None else (leader, servo):
            settings = source.settings.items()
            wanted |= {k: v for k, v in settings if k in table and table[k].area is Area.RAM}
        for name, value in wanted.items():
            bus.write(servo.servo_id, table[name], value)
