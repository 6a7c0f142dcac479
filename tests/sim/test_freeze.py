import os
import subprocess
import sys
import time

import pytest

from splinearm.sim.freeze import freeze

TICK = "import time\nwhile True:\n    print(time.monotonic(), flush=True)\n    time.sleep(0.002)\n"


def test_a_frozen_process_does_nothing_and_goes_on_afterwards():
    with subprocess.Popen([sys.executable, "-c", TICK], stdout=subprocess.PIPE, text=True) as clock:
        assert clock.stdout is not None
        clock.stdout.readline()
        begun = time.monotonic()
        freeze(clock.pid, 0.2)
        after = time.monotonic()
        times = [float(clock.stdout.readline())]
        while times[-1] < after:
            times.append(float(clock.stdout.readline()))
        clock.kill()
    gap = max(b - a for a, b in zip([begun, *times], times, strict=False))
    assert gap >= 0.15


def test_a_process_cannot_freeze_itself():
    with pytest.raises(ValueError, match="want another process"):
        freeze(os.getpid(), 0.1)
