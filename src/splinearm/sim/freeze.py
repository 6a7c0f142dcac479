"""A computer that is busy elsewhere: a process that does nothing for a while, and goes on."""

import os
import signal
import time


def freeze(pid: int, seconds: float) -> None:
    """Stop another process for so long, as a scheduler does that gives others its turn.

    Args:
        pid: The process; not this one, which could not wake itself.
        seconds: For how long.

    Raises:
        ValueError: If it is this process.
        ProcessLookupError: If there is none of that number.
    """
    if pid == os.getpid():
        raise ValueError(f"pid: want another process than this one, {pid}")
    os.kill(pid, signal.SIGSTOP)
    try:
        time.sleep(seconds)
    finally:
        os.kill(pid, signal.SIGCONT)
