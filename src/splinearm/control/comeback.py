"""An arm that a fault has stopped, taken up again as far as that needs no hands."""

from typing import Protocol, runtime_checkable

from splinearm.drivers.base import ArmDriver
from splinearm.errors import (
    BusTimeoutError,
    HealthError,
    MotionError,
    PacketError,
    PortError,
    ServoError,
    SilentBusError,
)


@runtime_checkable
class Reviving(Protocol):
    """An arm that can be taken up again, as ``ServoArm``."""

    def recover(self) -> object:
        """Bring back servos that have stopped themselves or have lost their torque."""
        ...

    def reconnect(self) -> object:
        """Take up the arm again after its port, or servos, were gone."""
        ...


def take_up(driver: ArmDriver, fault: MotionError | None) -> None:
    """Take up an arm again whose motion ended with a fault; it then holds.

    After a port or servos that were gone it is reconnected, after servos that have stopped
    themselves these are recovered. After any other fault, or none, there is nothing to be done.

    Raises:
        BusError: If something still is in the way; it says what helps.
    """
    cause = None if fault is None else fault.__cause__
    if not isinstance(driver, Reviving) or isinstance(cause, HealthError):
        return
    if isinstance(cause, PortError | BusTimeoutError | SilentBusError | PacketError):
        driver.reconnect()
    elif isinstance(cause, ServoError):
        driver.recover()
