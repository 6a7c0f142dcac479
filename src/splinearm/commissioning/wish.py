"""What the registers of a servo shall hold, by the arm's file, and what its firmware cannot."""

from splinearm.drivers.chain import ServoChain, ServoRole, ServoSpec
from splinearm.drivers.dialect import protocol_of
from splinearm.drivers.registers import Area
from splinearm.drivers.scaling import ONE_TURN_MODE, operating_mode
from splinearm.drivers.startup import is_coupled
from splinearm.errors import ServoError

from .image import ControlImage
from .task import ADDRESSING, ANSWER_ALL, LEVEL, SECONDARY_ID, STARTUP, TORQUE_AT_START, Change

_NO_SECONDARY = 253
_JOINT_MODE = 2
_RANGE = (("Min Position Limit", "Max Position Limit"), ("CW Angle Limit", "CCW Angle Limit"))
_STRENGTHS = ("PWM Limit", "Current Limit", "Max Torque")
_DRIVE = "Drive Mode"
_TIME_BASED, _BY_GOAL = 4, 8
_FIRST_TIME_BASED, _FIRST_BY_GOAL, _FIRST_BY_GOAL_X330 = 42, 45, 46
_FIRST_STARTUP = 45
"""First firmwares with these (e-Manual, "Drive Mode" and "Startup Configuration")."""


def wishes(
    servo: ServoSpec, chain: ServoChain, image: ControlImage, reach: tuple[int, int] | None
) -> dict[str, int]:
    """Give by name what registers shall hold that outlive the power, and how it answers.

    Args:
        servo: The servo.
        chain: The servos of its arm.
        image: What it holds now.
        reach: Lowest and highest position that its joint may go to, ticks; None: not known.
    """
    table = servo.servo_model.table
    wanted = {
        "ID": servo.servo_id,
        "Baud Rate": servo.servo_model.baud_code(chain.baud),
        "Protocol Type": protocol_of(servo, chain.protocol),
        "Return Delay Time": 0,
        LEVEL: ANSWER_ALL,
    }
    if servo.joint is not None:
        wanted |= _of_joint(servo)
    wanted |= {name: v for name, v in servo.settings.items() if table[name].area is Area.EEPROM}
    wanted |= _wider(servo, image, reach, wanted)
    wanted |= _stronger(image, wanted)
    if STARTUP not in wanted:  # torque comes from who moves the arm, not with the power
        wanted[STARTUP] = (image.value(STARTUP) or 0) & ~TORQUE_AT_START
    secondary = image.value(SECONDARY_ID)
    if secondary is not None and min(secondary, wanted.get(SECONDARY_ID, 0)) >= _NO_SECONDARY:
        wanted[SECONDARY_ID] = secondary  # all of them mean that there is none
    return {name: value for name, value in wanted.items() if name in table}


def changes_of(image: ControlImage, wanted: dict[str, int]) -> tuple[Change, ...]:
    """Give what is to be written: where it is reached first, a second id last.

    A servo that has its id is known again from then on, whatever comes in between.
    """
    table = image.model.table

    def order(name: str) -> tuple[int, int]:
        if name in ADDRESSING:
            return 0, ADDRESSING.index(name)
        return 2 if name == SECONDARY_ID else 1, table[name].address

    values = {name: image.value(name) for name in sorted(wanted, key=order)}
    return tuple(
        Change(table[name], have, wanted[name])
        for name, have in values.items()
        if have is not None and have != wanted[name]
    )


def require_firmware(name: str, image: ControlImage, wanted: dict[str, int]) -> None:
    """Refuse values that a servo's firmware does not know.

    Raises:
        ServoError: With the register, the firmware and the one that is needed.
    """
    model, firmware = image.model, image.found.firmware
    if model.name.startswith(("P", "AX", "XL320")):
        return
    mode = wanted.get(_DRIVE, 0)
    by_goal = _FIRST_BY_GOAL_X330 if "330-" in model.name else _FIRST_BY_GOAL
    for is_wanted, first, what in (
        (mode & _TIME_BASED, _FIRST_TIME_BASED, f"{_DRIVE} {mode} (profiles by time)"),
        (mode & _BY_GOAL, by_goal, f"{_DRIVE} {mode} (torque on by a goal)"),
        (wanted.get(STARTUP, 0), _FIRST_STARTUP, STARTUP),
    ):
        if is_wanted and firmware < first:
            raise ServoError(
                image.address.servo_id,
                f"{what} needs firmware {first} or newer; its firmware is {firmware}: update it "
                "with DYNAMIXEL Wizard 2, or change the arm's file",
                name=name,
            )


def _of_joint(servo: ServoSpec) -> dict[str, int]:
    """Give what decides where a goal sends a joint."""
    wanted = {_DRIVE: 0, "Control Mode": _JOINT_MODE, SECONDARY_ID: 255}
    if "Operating Mode" in servo.servo_model.table:
        wanted["Operating Mode"] = operating_mode(servo)
    if not is_coupled(servo):  # a coupled shadow's offset makes up for how it is mounted
        wanted["Homing Offset"] = 0
    return wanted


def _wider(
    servo: ServoSpec,
    image: ControlImage,
    reach: tuple[int, int] | None,
    wanted: dict[str, int],
) -> dict[str, int]:
    """Give position limits as from the factory where they cut the range of a joint off."""
    if reach is None or servo.role is not ServoRole.LEADER:
        return {}
    if operating_mode(servo) != ONE_TURN_MODE:
        return {}
    table = servo.servo_model.table
    low_name, high_name = next(names for names in _RANGE if names[0] in table)
    low, high = image.value(low_name), image.value(high_name)
    wider: dict[str, int] = {}
    for name, cuts in (
        (low_name, low is not None and low > reach[0] + 1),
        (high_name, high is not None and high < reach[1] - 1),
    ):
        initial = table[name].initial
        if cuts and name not in wanted and isinstance(initial, int):
            wider[name] = initial
    return wider


def _stronger(image: ControlImage, wanted: dict[str, int]) -> dict[str, int]:
    """Give the factory's limit to a servo that may not push at all."""
    table = image.model.table
    weak = [name for name in _STRENGTHS if image.value(name) == 0 and name not in wanted]
    initials = {name: table[name].initial for name in weak}
    return {name: initial for name, initial in initials.items() if isinstance(initial, int)}
