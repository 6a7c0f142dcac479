"""The port of a bus whose cable is out of the computer: servos live on, nobody speaks to them."""

from threading import Event


class NoPort:
    """Nothing comes, and what is sent is lost."""

    baud = 0
    """No rate."""

    def __init__(self) -> None:
        self._woken = Event()
        self.lost_bytes = 0
        """Bytes that were thrown away."""

    @property
    def name(self) -> str:
        """There is none.

        Raises:
            RuntimeError: Always.
        """
        raise RuntimeError("the virtual bus is unplugged")

    def close(self) -> None:
        """Do nothing."""

    def wake(self) -> None:
        """Let a waiting ``read`` return; may be called from any thread."""
        self._woken.set()

    def read(self, timeout: float) -> bytes:
        """Give nothing, after at most ``timeout`` seconds."""
        if self._woken.wait(timeout):
            self._woken.clear()
        return b""

    def write(self, data: bytes) -> None:
        """Lose bytes."""
        self.lost_bytes += len(data)
