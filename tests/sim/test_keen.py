import subprocess
import sys

import pytest

from splinearm.sim.keen import Spin


def test_a_spin_ends_at_its_instant_or_after_it():
    now = 0.0

    def clock() -> float:
        nonlocal now
        now += 3e-6
        return now

    late = Spin(clock).until(1e-4)
    assert 0.0 <= late < 3e-6
    assert now == pytest.approx(1e-4 + late)
    assert Spin(clock).until(0.0) > 0.0


def test_the_margin_grows_with_late_sleeps_and_shrinks_with_good_ones():
    spin = Spin()
    for _ in range(100):
        spin.learn(1e-3)
    high = spin.margin
    for _ in range(1000):
        spin.learn(1e-6)
    assert spin.margin < 50e-6 < high <= 150e-6
    assert spin.margin >= 15e-6


ASK = """
import os, threading
from splinearm.sim.keen import PRIORITY, go_first, sleep_sharply

def work():
    sleep_sharply()
    refused = go_first()
    policy, priority = os.sched_getscheduler(0), os.sched_getparam(0).sched_priority
    granted = policy == os.SCHED_FIFO and priority == PRIORITY
    assert granted is not any(text.startswith("SCHED_FIFO: ") for text in refused), refused

thread = threading.Thread(target=work)
thread.start()
thread.join()
assert os.sched_getscheduler(0) != os.SCHED_FIFO  # of the thread alone
print("all is well")
"""


def test_what_is_refused_is_said_and_what_is_granted_holds():
    # in a process of its own, for it locks memory
    said = subprocess.run(
        [sys.executable, "-c", ASK], capture_output=True, text=True, timeout=60, check=False
    )
    assert said.stdout == "all is well\n", said.stderr
