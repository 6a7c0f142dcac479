"""The cables to virtual servos: which of them hang on the line, and whether there is power."""

import threading
from collections.abc import Callable, Mapping

from .virtual_servo import VirtualServo


class Harness:
    """Cables and power switch of a virtual bus, for whoever plays the person.

    A cable brings data and power: a servo that is connected starts anew, one that is disconnected
    has neither torque nor voice.
    """

    def __init__(
        self,
        servos: Mapping[str, VirtualServo],
        lock: threading.Lock,
        catch_up: Callable[[], None],
    ) -> None:
        """Take servos that are all connected.

        Args:
            servos: The servos by name.
            lock: Held while they are touched.
            catch_up: Brings them up to the present; called with the lock held.
        """
        self._servos = dict(servos)
        self._lock = lock
        self._catch_up = catch_up
        self._connected = set(self._servos)
        self._powered = True

    @property
    def connected(self) -> tuple[str, ...]:
        """The names of the servos on the line, in the order of the chain."""
        return tuple(name for name in self._servos if name in self._connected)

    def connect(self, *names: str) -> None:
        """Plug servos in; all of them without a name.

        Raises:
            ValueError: If there is no such servo.
        """
        with self._lock:
            self._catch_up()
            for name in self._known(names):
                if name not in self._connected:
                    self._connected.add(name)
                    self._supply(name)

    def disconnect(self, *names: str) -> None:
        """Unplug servos; all of them without a name.

        Raises:
            ValueError: If there is no such servo.
        """
        with self._lock:
            self._catch_up()
            for name in self._known(names):
                self._connected.discard(name)
                self._supply(name)

    def power(self, *, on: bool) -> None:
        """Switch the power of all servos."""
        with self._lock:
            self._catch_up()
            if on is not self._powered:
                self._powered = on
                for name in self._connected:
                    self._supply(name)

    def _known(self, names: tuple[str, ...]) -> tuple[str, ...]:
        for name in names:
            if name not in self._servos:
                raise ValueError(f"no servo {name!r}; there are {', '.join(self._servos)}")
        return names or tuple(self._servos)

    def _supply(self, name: str) -> None:
        """Give a servo its power, or take it."""
        servo = self._servos[name]
        fed = self._powered and name in self._connected
        servo.unplugged = not fed
        if fed:
            servo.power_cycle()
        else:
            servo.release("no power")
            servo.stirred = True
