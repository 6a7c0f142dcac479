"""The one interface of every arm that moves, real or simulated."""

from types import TracebackType
from typing import Protocol, Self

from splinearm.arrays import FloatArray
from splinearm.joints import JointSetpoint, JointState


class ArmDriver(Protocol):
    """An arm that can be moved, used in a with-block.

    Entering makes the arm ready and lets it hold where it stands. Leaving, also by an exception,
    holds it where it stands: no arm drops because a program ended.
    """

    @property
    def n(self) -> int:
        """Number of joints."""
        ...

    @property
    def goal(self) -> FloatArray:
        """Where the arm was last told to be, shape (n,), rad; by its weight it may hang below.

        A motion that starts here, not where the arm was measured, starts without a jerk.
        """
        ...

    def __enter__(self) -> Self:
        """Make the arm ready; it holds its present position from here on."""
        ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Hold, then let go of the connection; never of the torque."""
        ...

    def read(self) -> JointState:
        """Measure the joints.

        Raises:
            BusError: If a joint gave no answer.
        """
        ...

    def write(self, setpoint: JointSetpoint) -> None:
        """Send a setpoint; it is valid until the next."""
        ...

    def hold(self) -> None:
        """Stay where the arm stands, with torque."""
        ...

    def release(self) -> None:
        """Switch the torque off. An arm without brakes falls."""
        ...


class Feedforward(Protocol):
    """What a driver of servos adds to a setpoint, so that the joints are where the setpoint says.

    A servo follows its goal late, and under a load it rests below it. Both can be foretold.
    """

    def lead(self, setpoint: JointSetpoint) -> FloatArray:
        """Give by how much each joint's goal shall be ahead of the setpoint, shape (n,), rad."""
        ...

    def current(self, setpoint: JointSetpoint) -> FloatArray | None:
        """Give the Goal Current of each joint, shape (n,), A; None: it is left as it is."""
        ...
