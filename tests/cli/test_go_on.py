"""A person at a terminal stops a motion and lets it go on."""

import os
import pty
import select
import subprocess
import sys
import time

import pytest

from splinearm.cli.main import DONE, INTERRUPTED
from splinearm.config import load_cell
from splinearm.sim.virtual_bus import VirtualBus

CTRL_C = b"\x03"


class Terminal:
    """A program at a pseudo terminal."""

    def __init__(self, *words):
        self.text = ""
        self.near, far = pty.openpty()
        command = [sys.executable, "-m", "splinearm", *map(str, words)]
        self.process = subprocess.Popen(
            ["setsid", "-c", "-w", *command],
            stdin=far,
            stdout=far,
            stderr=far,
            env={**os.environ, "TERM": "dumb"},
        )
        os.close(far)

    def wait_for(self, words):
        """Read until words have been printed."""
        give_up = time.monotonic() + 60.0
        while words not in self.text:
            assert time.monotonic() < give_up, self.text
            if select.select([self.near], [], [], 0.1)[0]:
                try:
                    self.text += os.read(self.near, 4096).decode(errors="replace")
                except OSError:
                    pytest.fail(f"it ended before it said {words!r}: {self.text}")

    def type(self, keys):
        os.write(self.near, keys)

    def end(self):
        """Read to the end and give the exit code."""
        try:
            while data := os.read(self.near, 4096):
                self.text += data.decode(errors="replace")
        except OSError:  # the other end is closed
            pass
        os.close(self.near)
        return self.process.wait(timeout=30)


@pytest.mark.sim
def test_a_person_is_asked_whether_a_stopped_motion_goes_on(cli):
    terminal = Terminal(
        "run", cli.job(), "--on", "mujoco", "--realtime", "--rate", 20, "--json", "r.json"
    )
    terminal.wait_for("motion of 3.00 s begins")
    for answer in (b"y\n", b"\n"):
        terminal.wait_for(" s begins")
        time.sleep(0.3)
        terminal.text = ""
        terminal.type(CTRL_C)
        terminal.wait_for("go on from where it rests? [y/N]")
        assert "stop asked for: stopping along the path" in terminal.text
        terminal.type(answer)
    assert terminal.end() == INTERRUPTED
    assert "outcome: finished" not in terminal.text


@pytest.mark.slow
@pytest.mark.bus
def test_an_arm_that_a_fault_has_stopped_is_taken_up_again_when_a_person_says_so(cli):
    cell = load_cell("planar_2r")
    with VirtualBus(cell.arm, cell.chain, cell.poses["home"], transport="socket") as bus:
        terminal = Terminal("run", cli.job(), "--on", bus.port, "--rate", "50")
        terminal.wait_for("motion of 3.00 s begins")
        time.sleep(0.5)
        with bus.lock:
            bus.servos[2].temperature = 85.0
            bus.servos[2].fail("overheating")
        terminal.wait_for("go on from where it rests? [y/N]")
        assert "servo 2 (joint2): it reports overheating" in terminal.text
        terminal.text = ""
        terminal.type(b"y\n")
        terminal.wait_for("go on from where it rests? [y/N]")
        assert "let it cool down" in terminal.text
        with bus.lock:
            bus.servos[2].temperature = 30.0
        terminal.type(b"y\n")
        assert terminal.end() == DONE
    assert "outcome: finished" in terminal.text
