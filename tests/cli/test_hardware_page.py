"""The page for new owners: each of its commands, in its order, on servos fresh from the box."""

import re
import shlex
import time
from pathlib import Path

import numpy as np
import pytest

from splinearm.backends import centred
from splinearm.cli.main import build_parser
from splinearm.config import load_cell, load_job
from splinearm.sim.virtual_bus import VirtualBus
from splinearm.units import DEG

PAGE = (Path(__file__).parents[2] / "docs" / "hardware.md").read_text(encoding="utf-8")
SHOWN = "koch_v1_1"
PORT = "/dev/ttyUSB0"
COMMANDS = [
    shlex.split(line)[1:]
    for block in re.findall(r"```\n(.*?)```", PAGE, re.DOTALL)
    for line in block.splitlines()
]

pytestmark = [pytest.mark.bus, pytest.mark.sim]


class Owner:
    """A person with an arm from the box: connects its servos, turns its joints, answers."""

    def __init__(self, arm, terminal, cli, folder):
        self.cell = load_cell(arm)
        self.terminal, self.cli, self.folder = terminal, cli, folder
        home = self.cell.poses["home"]
        self.bus = VirtualBus(self.cell.arm, centred(self.cell.chain), home, fresh=True)

    def follow(self, words):
        """Type a command of the page, and do what it asks."""
        here = {SHOWN: self.cell.name, PORT: self.bus.port}
        typed = [here.get(word, word) for word in words]
        return getattr(self, words[0].replace("-", "_"))(typed)

    def open(self, words, **size):
        return self.terminal(*words, **({"rows": 50, "columns": 120} | size))

    def doctor(self, words):
        assert self.cli(*words) == (1 if len(words) == 2 else 0), self.cli.out
        if len(words) == 2:
            assert "L01" in self.cli.out
            self.bus.harness.connect()
            time.sleep(0.6)

    def scan(self, words):
        assert self.cli(*words) == 1
        assert "several servos have this id" in self.cli.out
        self.bus.harness.disconnect()

    def setup(self, words):
        if "--check" in words:
            assert self.cli(*words) == 0, self.cli.out
            return
        seen = self.open(words)
        for servo in self.cell.chain.servos:
            seen.wait_for(f"Connect only servo {servo.name} ", 20.0)
            self.bus.harness.disconnect()
            self.bus.harness.connect(servo.name)
            seen.wait_for(f"{servo.name}: {servo.model}", 20.0)
            seen.wait_for(r"into 1 servo\?.*y/N")
            seen.type("y\n")
        seen.wait_for("Now connect all servos", 20.0)
        self.bus.harness.connect()
        seen.wait_for("all servos are set up", 30.0)
        assert seen.exit_code == 0

    def turn(self, joint, angle):
        """Turn a joint by hand, or the gripper: None; no farther at once than can be followed."""
        i = None if joint is None else self.cell.arm.joint_names.index(joint)
        here = 0.0 if i is None else self.bus.q[i]
        for goal in np.linspace(here, angle, max(2, int(abs(angle - here) / 0.8)))[1:]:
            with self.bus.lock:
                if i is None:
                    self.bus.all_servos[-1].shaft.angle = float(goal)
                else:
                    q = self.bus.plant.q
                    q[i] = goal
                    self.bus.plant.stand(q)
            time.sleep(0.05)

    def calibrate(self, words):
        limits, zero = self.cell.arm.limits, self.cell.poses["zero"]
        seen = self.open(words)
        seen.wait_for("Turn each joint", 20.0)
        for i, joint in enumerate(self.cell.arm.joint_names):
            for angle in (limits.q_min[i] + DEG, limits.q_max[i] - DEG, zero[i]):
                self.turn(joint, angle)
                time.sleep(0.1)
        if self.cell.chain.gripper is not None:
            self.turn(None, 0.7)
        seen.press("enter")
        for i, joint in enumerate(self.cell.arm.joint_names):
            seen.wait_for(f"Joint {joint}: turn it", 20.0)
            self.turn(joint, zero[i] + 20.0 * DEG)
            seen.wait_for("the numbers go", 20.0)
            seen.press("enter")
            self.turn(joint, zero[i])
        seen.wait_for("The pose 'zero'", 20.0)
        seen.press("enter")
        if self.cell.chain.gripper is not None:
            seen.wait_for("Open the gripper")
            seen.press("enter")
            seen.wait_for("Close the gripper")
            self.turn(None, 0.0)
            seen.press("enter")
        seen.wait_for("y: write that", 20.0)
        seen.press("y")
        seen.wait_for("The torque is still off", 20.0)
        assert seen.exit_code == 0

    def monitor(self, words):
        seen = self.open(words)
        seen.wait_for(self.cell.chain.servos[-1].name, 20.0)
        seen.press("q")
        assert seen.exit_code == 0

    def jog(self, words):
        before = self.bus.q
        # the servos are threads of this test: on a busy computer they may be silent for too long
        for _ in range(3):
            seen = self.open(words)
            seen.wait_for("the arm holds", 20.0)
            for _ in range(8):
                seen.press("right")
                time.sleep(0.05)
            if seen.wait_for("the arm holds|no feedback for", 20.0) == "the arm holds":
                break
        seen.press("q")
        assert seen.exit_code == 0
        assert np.abs(self.bus.q - before).max() > 1.0 * DEG

    def lead(self, angle, seconds):
        """Pull the first joint along as with a spring, there and back."""
        start, before, begun = self.bus.q, self.bus.q, time.monotonic()
        then = begun - 0.01
        while (t := time.monotonic() - begun) < seconds:
            wanted = start.copy()
            wanted[0] += angle * np.sin(np.pi * t / seconds) ** 2
            q, now = self.bus.q, time.monotonic()
            self.bus.push(30.0 * (wanted - q) - 0.6 * (q - before) / (now - then))
            before, then = q, now
            time.sleep(0.005)

    def teach(self, words):
        seen = self.open(words)
        seen.wait_for("it is carried|NO TORQUE", 20.0)
        if "NO TORQUE" in seen.screen:
            seen.press("y")
            seen.wait_for("it holds", 20.0)
        seen.press(" ")
        seen.wait_for("RECORDING", 20.0)
        self.lead(12.0 * DEG, 1.0)
        seen.press(" ")
        seen.wait_for("taken: .* samples", 20.0)
        self.bus.push(None)
        seen.press("enter")
        assert seen.exit_code == 0, seen.screen
        assert load_job(self.folder / words[words.index("-o") + 1]).pieces

    def play(self, words):
        assert self.cli(*words) == 0, self.cli.out + self.cli.err

    def recover(self, words):
        assert self.cli(*words) == 0, self.cli.out + self.cli.err

    def virtual_bus(self, words):
        """It stands for the bus of this test, whose servos are the same: nothing is left to try
        but its words."""
        build_parser().parse_args(words)


def test_every_command_of_the_page_is_one_that_the_owner_knows():
    assert {words[0] for words in COMMANDS} == {
        *("virtual-bus", "doctor", "scan", "setup", "calibrate"),
        *("monitor", "jog", "teach", "play", "recover"),
    }


@pytest.mark.parametrize("arm", ["planar_2r", pytest.param(SHOWN, marks=pytest.mark.slow)])
def test_an_owner_comes_from_the_box_to_the_first_motion(arm, terminal, cli, tmp_path, monkeypatch):
    monkeypatch.setenv("SPLINEARM_HOME", str(tmp_path / "home"))
    owner = Owner(arm, terminal, cli, cli.folder)
    with owner.bus:
        owner.bus.harness.disconnect()
        for words in COMMANDS:
            owner.follow(words)
