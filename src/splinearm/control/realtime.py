"""What lets a thread wake on time on a computer that has other things to do.

Under SCHED_FIFO nothing of normal priority holds it up, locked memory is never fetched from a disk,
and sleeps end when they should. Each of these is taken where the system permits it, told where it
does not, and given back in the end.
"""

import ctypes
import logging
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from types import ModuleType

from .collector import collector_suspended

resource: ModuleType | None
try:
    import resource
except ImportError:  # Windows
    resource = None

_log = logging.getLogger(__name__)

PRIORITY = 50
"""As ros2_control has it: above everything normal, below the kernel's own urgent threads."""

SPIN = 150e-6
"""So long before it is due the last sleep of a loop under SCHED_FIFO ends, s."""

_MCL_CURRENT, _MCL_FUTURE, _MCL_ONFAULT = 1, 2, 4
_PR_SET_TIMERSLACK, _PR_GET_TIMERSLACK = 29, 30
_SWITCH = 50e-6
"""How long another thread may keep Python's lock when the loop asks for it, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Footing:
    """What the system permitted."""

    fifo: bool
    """Whether this thread goes before everything of normal priority."""
    locked: bool
    """Whether the memory stays where it is."""

    @property
    def words(self) -> str:
        """What there is, and what would help if something is missing, in one line."""
        if self.fifo and self.locked:
            return f"real-time priority {PRIORITY}, memory locked"
        if sys.platform != "linux":
            return "no real-time priority: that is known here for Linux only"
        has = f"real-time priority {PRIORITY}, memory not locked" if self.fifo else None
        return (
            f"{has or 'no real-time priority'}; to permit it, give your user 'rtprio 50' and "
            "'memlock unlimited' in /etc/security/limits.conf and log in again (see: ulimit -r), "
            f"or run: sudo setcap cap_sys_nice,cap_ipc_lock+ep {os.path.realpath(sys.executable)}"
        )


@contextmanager
def real_time(priority: int = PRIORITY) -> Iterator[Footing]:
    """Let this thread be on time, as far as the system permits, while the with-block lasts.

    What it starts meanwhile, threads or processes, is of normal priority. A thread at this priority
    must sleep now and then: the kernel stops one that does not for 50 ms of every second.

    Args:
        priority: Of SCHED_FIFO, 1 to 99.
    """
    with ExitStack() as stack:
        stack.enter_context(collector_suspended())
        stack.enter_context(_quick_switches())
        footing = Footing(fifo=False, locked=False)
        if sys.platform == "linux":
            locked = stack.enter_context(_locked_memory())
            stack.enter_context(_sharp_sleeps())
            fifo = stack.enter_context(_first_in_first_out(priority))
            footing = Footing(fifo=fifo, locked=locked)
        yield footing


@contextmanager
def _quick_switches() -> Iterator[None]:
    """Let other threads of this program give way sooner than after 5 ms."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(_SWITCH)
    try:
        yield
    finally:
        sys.setswitchinterval(before)


@contextmanager
def _first_in_first_out(priority: int) -> Iterator[bool]:
    """Take SCHED_FIFO for this thread; give whether it was permitted."""
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        wanted = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
        os.sched_setscheduler(0, wanted, os.sched_param(priority))
    except OSError as error:
        _log.debug("SCHED_FIFO: %s", error)
        yield False
        return
    try:
        yield True
    finally:
        try:
            os.sched_setscheduler(0, *before)
        except PermissionError:  # that children are of normal priority is not given up again
            os.sched_setscheduler(0, before[0] | os.SCHED_RESET_ON_FORK, before[1])


@contextmanager
def _locked_memory() -> Iterator[bool]:
    """Keep every page that was touched; give whether it was permitted."""
    locked = _may_lock_all() and _call("mlockall", _MCL_CURRENT | _MCL_FUTURE | _MCL_ONFAULT)
    try:
        yield locked
    finally:
        if locked:
            _call("munlockall")


def _may_lock_all() -> bool:
    """Tell whether later pages may be locked as well: else allocating memory would fail."""
    assert resource is not None  # noqa: S101 - Linux has it
    unlimited: bool = resource.getrlimit(resource.RLIMIT_MEMLOCK)[0] == resource.RLIM_INFINITY
    return unlimited or os.geteuid() == 0


@contextmanager
def _sharp_sleeps() -> Iterator[None]:
    """Let sleeps of this thread end on time; unless told so Linux lets them end 50 us late."""
    before = _libc("prctl")(_PR_GET_TIMERSLACK, 0, 0, 0, 0)
    _call("prctl", _PR_SET_TIMERSLACK, 1, 0, 0, 0)
    try:
        yield
    finally:
        _call("prctl", _PR_SET_TIMERSLACK, max(before, 0), 0, 0, 0)


def _libc(name: str) -> Callable[..., int]:
    function: Callable[..., int] = getattr(ctypes.CDLL(None, use_errno=True), name)
    return function


def _call(name: str, *words: int) -> bool:
    """Call the system; give whether it did what it was asked for."""
    done = _libc(name)(*words) == 0
    if not done:
        _log.debug("%s: %s", name, os.strerror(ctypes.get_errno()))
    return done
