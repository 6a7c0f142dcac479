"""Words of advice that several checks give."""

from splinearm.drivers.model import ServoModel


def set_register(model: ServoModel, servo_id: int, name: str, value: int) -> str:
    """Say how a register of a servo is set.

    Args:
        model: Its model.
        servo_id: Its id.
        name: The register.
        value: What it shall hold.
    """
    register = model.table[name]
    return (
        f"in DYNAMIXEL Wizard 2 set {name} (address {register.address}) of servo {servo_id} to "
        f"{value}, with its torque off"
    )


def recover(port: str, arm: str | None) -> str:
    """Give the command that brings servos back."""
    return f"run `splinearm recover {arm or 'ARM'} --port {port}`, with the arm supported"
