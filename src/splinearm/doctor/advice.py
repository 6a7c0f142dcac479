"""Words of advice that several checks give."""

from splinearm.drivers.model import ServoModel


def setup(port: str, arm: str | None) -> str:
    """Give the command that sets servos as the arm's file says."""
    return f"run `splinearm setup {arm or 'ARM'} --port {port}`"


def set_register(mend: str, model: ServoModel, servo_id: int, name: str, value: int) -> str:
    """Say how a register of a servo comes to hold what setup writes.

    Args:
        mend: The command, as ``setup`` gives it.
        model: Its model.
        servo_id: Its id.
        name: The register.
        value: What it shall hold.
    """
    address = model.table[name].address
    return f"{mend}: it sets {name} (address {address}) of servo {servo_id} to {value}"


def set_by_hand(model: ServoModel, servo_id: int, name: str, value: int) -> str:
    """Say how a register of a servo is set that no arm's file knows; arguments as above."""
    return (
        f"in DYNAMIXEL Wizard 2 set {name} (address {model.table[name].address}) of servo "
        f"{servo_id} to {value}, with its torque off"
    )


def recover(port: str, arm: str | None) -> str:
    """Give the command that brings servos back."""
    return f"run `splinearm recover {arm or 'ARM'} --port {port}`, with the arm supported"
