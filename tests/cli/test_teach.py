"""``splinearm teach`` and ``splinearm play``: a hand leads a virtual arm, the arm does it again."""

import json
import threading
import time

import numpy as np
import pytest

from splinearm.backends import centred
from splinearm.cli.main import main
from splinearm.config import load_cell, load_job
from splinearm.sim.virtual_bus import VirtualBus
from splinearm.teaching.recording import Recording
from splinearm.teaching.rows import read_rows, rows_text

pytestmark = pytest.mark.bus


class Hand:
    """Pulls a virtual arm along as with springs, in a thread."""

    def __init__(self, bus: VirtualBus, stiffness: float = 30.0, damping: float = 0.6) -> None:
        self._bus, self._stiffness, self._damping = bus, stiffness, damping
        self._wanted = bus.q
        self._holds = threading.Event()
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def lead(self, *steps: tuple[list[float], float]) -> None:
        """Lead to places, deg, each in a time, s."""
        self._holds.set()
        for goal_deg, seconds in steps:
            start, goal, begun = self._wanted, np.radians(goal_deg), time.monotonic()
            while (x := (time.monotonic() - begun) / seconds) < 1.0:
                self._wanted = start + (goal - start) * (10 * x**3 - 15 * x**4 + 6 * x**5)
                time.sleep(0.005)
            self._wanted = goal

    def let_go(self) -> None:
        self._holds.clear()
        time.sleep(0.05)
        self._bus.push(None)

    def end(self) -> None:
        self._ends.set()
        self._thread.join()
        self._bus.push(None)

    def _run(self) -> None:
        before, then = self._bus.q, time.monotonic()
        while not self._ends.is_set():
            time.sleep(0.005)
            q, now = self._bus.q, time.monotonic()
            if self._holds.is_set():
                speed = (q - before) / (now - then)
                self._bus.push(self._stiffness * (self._wanted - q) - self._damping * speed)
            before, then = q, now


@pytest.fixture
def bus():
    cell = load_cell("planar_2r")
    home = cell.poses["home"]
    with VirtualBus(cell.arm, centred(cell.chain), home, transport="socket") as made:
        yield made


@pytest.fixture
def hand(bus):
    made = Hand(bus)
    yield made
    made.end()


def test_what_a_hand_led_is_carried_out_again(terminal, bus, hand, tmp_path, kept):
    job, report, rows = (tmp_path / f"lesson.{ending}" for ending in ("toml", "json", "csv"))
    seen = terminal(
        *("teach", "planar_2r", "--port", bus.port, "-o", str(job), "--tables"),
        rows=24,
        columns=80,
    )
    seen.wait_for("it is carried", 20.0)
    seen.press(" ")
    seen.wait_for("RECORDING", 5.0)
    hand.lead(([-34.0, 84.0], 0.6), ([-34.0, 84.0], 0.5))
    kept("teach", seen.screen)
    hand.lead(([-40.0, 92.0], 0.5))
    seen.press(" ")
    seen.wait_for("taken: .* samples", 5.0)
    hand.let_go()
    seen.press(" ", "u", "enter")
    assert seen.exit_code == 0
    assert "control points" in seen.screen
    assert all(servo.torque_on for servo in bus.all_servos)

    cell, led = load_cell("planar_2r"), load_job(job)
    recording = read_rows(tmp_path / "lesson-piece-1.csv", cell.arm.limits)
    (piece,) = led.pieces
    assert len(piece.content.points) <= len(recording.t) / 10
    ((_, rest),) = piece.content.rests
    assert 0.3 < rest < 1.2
    words = ("play", job, "--on", "mujoco", "--json", report, "--csv", rows)
    assert main([str(word) for word in words]) == 0
    said = json.loads(report.read_text())["pieces"][-1]["tracking"]
    assert said["path_measured_mm"]["worst"] < 1.5
    # the tool came everywhere where the hand had led it
    played = read_rows(rows, cell.arm.limits)
    assert tool_gap(cell, recording.q, played.q) < 3.5e-3


def tool_gap(cell, wanted, found):
    """How far the farthest wanted place of the tool is from all that were found, m."""
    p, q = (cell.arm.fk(x)[:, :3, 3] for x in (wanted, found))
    return np.linalg.norm(p[:, None] - q[None], axis=2).min(axis=1).max()


def test_without_torque_the_arm_is_asked_for_and_holds_in_the_end(terminal, bus, hand, tmp_path):
    job = tmp_path / "limp.toml"
    seen = terminal("teach", "planar_2r", "--port", bus.port, "-o", str(job), "--limp", columns=100)
    seen.wait_for("NO TORQUE", 20.0)
    seen.press("y")
    seen.wait_for("it holds", 5.0)
    assert all(servo.torque_on for servo in bus.all_servos)
    seen.press(" ")
    seen.wait_for("RECORDING", 5.0)
    assert not any(servo.torque_on for servo in bus.all_servos)
    hand.lead(([-38.0, 86.0], 0.5))
    seen.hang_up()
    assert seen.exit_code != 0
    hand.let_go()
    assert all(servo.torque_on for servo in bus.all_servos)
    assert load_job(job).pieces  # what was led is not lost with the terminal


def rows_of(cell, seconds=4.0):
    t = np.arange(int(seconds * 100)) / 100.0
    x = np.clip((t - 0.5) / (seconds - 1.0), 0.0, 1.0)[:, None]
    swing = 10 * x**3 - 15 * x**4 + 6 * x**5
    q = np.array(cell.poses["home"]) + swing * [0.4, -0.3]
    return rows_text(Recording(names=cell.arm.joint_names, t=t, q=q), cell.arm.limits)


@pytest.fixture
def table(cli):
    return cli.write("rows.csv", rows_of(load_cell("planar_2r")))


def test_a_recording_becomes_a_job_that_is_added_to_and_played(cli, table):
    assert cli("teach", "planar_2r", "--from", table, "-o", "a.toml", "--json") == 0
    (said,) = json.loads(cli.out)["pieces"]
    assert said["control_points"] <= said["samples"] / 10
    assert said["tool_miss_mm"] <= 1.0
    assert cli("teach", "planar_2r", "--from", table, "--trim", "0:2.5", "--append", "a.toml") == 0
    assert len(load_job("a.toml").pieces) == 2
    assert cli("play", "a.toml", "--timing", "fastest", "--json", "fast.json") == 0
    fast = json.loads((cli.folder / "fast.json").read_text())
    assert fast["outcome"] == "finished"
    words = ("play", "a.toml", "--limits-percent", "40", "--times", "2", "--json", "slow.json")
    assert cli(*words) == 0
    slow = json.loads((cli.folder / "slow.json").read_text())
    assert slow["rounds"] == 2
    assert slow["pieces"][0]["seconds"] > fast["pieces"][0]["seconds"]
    assert "2 rounds" in cli.out


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("--from", "rows.csv", "-o", "rows.csv"), "is there already"),
        (("--from", "none.csv"), "cannot be read"),
        (("--from", "rows.csv", "--trim", "3:1"), "rising"),
        (("--from", "rows.csv", "--trim", "x"), "want A:B"),
        (("--trim", "1:2"), "is for a recording"),
        (("--from", "rows.csv", "--tolerance-mm", "0"), "want 0.001"),
        (("--from", "rows.csv", "--tolerance-deg", "-1"), "want 0.001"),
        (("--from", "rows.csv", "--append", "none.toml"), "cannot be read"),
        (("--from", "rows.csv", "--trim", "0:0.3"), "nothing moves"),
        (("--on", "virtual", "-o", "x.toml"), "no terminal"),
    ],
)
def test_what_makes_no_sense_is_refused_and_nothing_written(cli, table, words, reason):
    before = cli.files()
    assert cli("teach", "planar_2r", *words) == 2
    assert reason in cli.err
    assert len(cli.err.splitlines()) == 1
    assert cli.files() == before


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("--limits-percent", "0"), "want 0.1 to 100"),
        (("--limits-percent", "nan"), "want 0.1 to 100"),
        (("--times", "0"), "1 or more"),
        (("--csv", "rows.csv"), "is there already"),
        (("--arm", "wx250s"), "is for 'planar_2r'"),
    ],
)
def test_what_cannot_be_played_is_refused(cli, table, words, reason):
    assert cli("teach", "planar_2r", "--from", table, "-o", "a.toml") == 0
    assert cli("play", "a.toml", *words) == 2
    assert reason in cli.err


def test_an_arm_led_beyond_its_limit_is_named_with_joint_and_time(cli):
    cell = load_cell("planar_2r")
    text = rows_of(cell).splitlines()
    spoilt = [text[0], *(f"{line.split(',')[0]},170,{line.split(',')[2]}" for line in text[1:])]
    cli.write("far.csv", "\n".join(spoilt))
    assert cli("teach", "planar_2r", "--from", "far.csv", "-o", "a.toml") == 2
    assert "joint 'joint1'" in cli.err
    assert "t = 0.000 s" in cli.err
    assert cli.files() == {"far.csv"}
