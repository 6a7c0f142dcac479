"""``splinearm jog`` in a terminal, in MuJoCo and on virtual servos."""

import json
import os
import re
import select
import sys
import threading
import time
import tomllib

import numpy as np
import pytest

from splinearm.backends import centred
from splinearm.cli.jog_key import AXES, KeyRepeat, Settings
from splinearm.cli.jog_screen import View, lines
from splinearm.cli.main import main
from splinearm.config import load_cell, load_job
from splinearm.sim.virtual_bus import VirtualBus
from splinearm.units import DEG

POSE = re.compile(r"x (\S+)  y (\S+)  z (\S+) mm  roll (\S+)  pitch (\S+)  yaw (\S+) deg")


@pytest.fixture(scope="module")
def cell():
    return load_cell("wx250s")


def _pose(seen):
    """What the screen says once the arm holds."""
    seen.wait_for("the arm holds")
    return np.array([float(word) for word in POSE.search(seen.screen).groups()])


class Held:
    """A key that is held, as a terminal repeats it."""

    def __init__(self, seen, key) -> None:
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(seen, key))

    def _run(self, seen, key):
        while not self._stop.wait(0.03):
            seen.press(key)

    def __enter__(self):
        self._thread.start()

    def __exit__(self, *_):
        self._stop.set()
        self._thread.join()


def _hold(seen, key, seconds):
    with Held(seen, key):
        seen.wait_for("the arm moves")
        time.sleep(seconds)


@pytest.mark.sim
def test_a_person_jogs_an_arm_in_mujoco(terminal, tmp_path, cell, kept):
    file = tmp_path / "places.toml"
    words = ["--on", "mujoco", "--speed-mm-s", 250, "--speed-deg-s", 60, "--json"]
    seen = terminal(*["jog", "wx250s", *words, "--waypoints", file], columns=110)
    start = _pose(seen)
    kept("jog", seen.screen)
    seen.press("w")
    seen.wait_for("a new job starts here")
    # the tool along the base's x, as long as a key is held
    seen.press("tab")
    seen.wait_for("axes of the base")
    _hold(seen, "up", 0.2)
    there = _pose(seen)
    assert there[0] > start[0] + 10.0
    np.testing.assert_allclose(np.delete(there, 0), np.delete(start, 0), atol=1.0)
    # and a step along its own x, which points down by 60 degrees
    seen.press("m", "tab")
    seen.wait_for("its own axes; a key is one step of 1 mm")
    seen.press(*"]]]]]")
    seen.wait_for("one step of 50 mm")
    seen.press("down")
    seen.wait_for("the arm moves")
    back = _pose(seen)
    np.testing.assert_allclose((back - there)[:3], [-25.0, 0.0, 43.3], atol=1.5)
    seen.press("w")
    seen.wait_for("waypoint p1")
    # a limit is explained when it is met
    seen.press("m", "5")
    with Held(seen, "right"):
        seen.wait_for("wrist_angle is at its upper limit 123.0 deg: go the other way")
    seen.press("q")
    assert seen.exit_code == 0
    told = json.loads(re.search(rb'\{"arm".*\}', seen.raw)[0])
    assert told["ended_by_key"]
    assert told["fault"] is None
    assert 150.0 < told["fastest_mm_s"] <= 250.0
    assert told["holds_at"][4] == pytest.approx(123.0, abs=0.1)
    job = load_job(file)
    np.testing.assert_allclose(job.q_start, cell.poses["home"], atol=0.1 * DEG)
    assert tomllib.loads(file.read_text())["waypoint"][0]["name"] == "p1"


@pytest.mark.bus
def test_jogged_servos_brake_and_hold_when_their_terminal_goes(terminal):
    cell = load_cell("planar_2r")
    home = cell.poses["home"]
    with VirtualBus(cell.arm, centred(cell.chain), home, transport="socket") as bus:
        seen = terminal("jog", "planar_2r", "--port", bus.port)
        seen.wait_for("the arm holds")
        with Held(seen, "right"):
            seen.wait_for("the arm moves")
            time.sleep(0.2)
        seen.press("right")
        seen.hang_up()
        assert seen.exit_code == 130
        q = bus.q
        time.sleep(0.1)
        assert q[0] > home[0] + 1.0 * DEG
        np.testing.assert_allclose(bus.q, q, atol=0.3 * DEG)
        assert all(servo.torque_on for servo in bus.all_servos)


class Person:
    """Types into the terminal of this process, each text once the arm does what is awaited."""

    def __init__(self, terminal, *steps) -> None:
        self._terminal = terminal
        self._thread = threading.Thread(target=self._run, args=steps)
        self._thread.start()

    def _run(self, *steps):
        for awaited, text in steps:
            seen = b""
            while awaited not in seen[seen.rfind(b"\x1b[H") :]:
                if not select.select([self._terminal], [], [], 20.0)[0]:
                    return  # the command has ended, and what it ended with will tell
                seen = seen[-4096:] + os.read(self._terminal, 4096)
            os.write(self._terminal, text)

    def end(self):
        self._thread.join()


@pytest.fixture
def person(monkeypatch):
    """Gives this process a terminal, and a person at it."""
    master, slave = os.openpty()
    monkeypatch.setattr(sys, "stdin", os.fdopen(slave))
    typing = []
    yield lambda *steps: typing.append(Person(master, *steps))
    for each in typing:
        each.end()
    sys.stdin.close()
    os.close(master)


HOLDS, MOVES = b"the arm holds; ", b"the arm moves; "


@pytest.mark.sim
def test_keys_do_what_they_say_and_the_arm_holds(person, cli, monkeypatch):
    monkeypatch.setattr("splinearm.cli.jog._REDRAW", 0.01)
    person(
        # the last line, though this terminal does not say how large it is
        (b"q, esc, Ctrl-C  brake, hold and end", b"w2+\x1b[C"),  # the place; a step of joint 2
        (MOVES, b"w"),  # refused
        (HOLDS, b"wx[m\x1b[C G"),  # the place; as long as a key is held: it is braked
        (HOLDS, b"\t\x1b[Ar"),  # the tool, along the base; along z it cannot go
        (b"cannot move its tool along z", b"q"),
    )
    assert cli("jog", "planar_2r", "--on", "mujoco", "--step-deg", 3) == 0
    assert "the arm holds at" in cli.out
    here, there = (
        np.array([float(word) for word in place.split(",")])
        for place in re.findall(r"joints_deg = \[(.*)\]", cli.out)
    )
    np.testing.assert_allclose(here, np.degrees(load_cell("planar_2r").poses["home"]), atol=0.2)
    np.testing.assert_allclose(there - here, [0.0, 3.0], atol=1e-3)


@pytest.mark.sim
def test_a_terminal_that_goes_away_ends_it_in_this_process_too(monkeypatch, cli):
    master, slave = os.openpty()
    monkeypatch.setattr(sys, "stdin", os.fdopen(slave))
    threading.Timer(0.6, os.close, (master,)).start()
    assert cli("jog", "planar_2r", "--on", "mujoco", "--json") == 130
    assert json.loads(cli.out[cli.out.index('{"arm"') :])["ended_by_key"] is False
    sys.stdin.close()


def test_what_cannot_be_is_refused_in_one_line(cli, capsys, tmp_path):
    for words, wanted in (
        (["--speed-mm-s", "300"], "at most 250"),
        (["--speed-deg-s", "nan"], "at most 60"),
        (["--step-mm", "0"], "above 0"),
        ([], "no terminal"),
    ):
        assert cli("jog", "wx250s", "--on", "mujoco", *words) == 2
        assert wanted in cli.err
        assert len(cli.err.splitlines()) == 1
    broken = tmp_path / "broken.toml"
    broken.write_text('schema = "splinearm-arm/1"\n')
    assert cli("jog", "wx250s", "--on", "mujoco", "--waypoints", broken) == 2
    assert "no job file" in cli.err


def test_a_key_counts_as_held_as_long_as_its_repeats_need():
    keys = KeyRepeat()
    assert keys.lasts == 0.12
    for t in (0.0, 0.5, 0.53, 0.565, 0.6):  # first the pause of every terminal
        keys.press("up", t)
    assert keys.lasts == pytest.approx(2.5 * 0.035)
    for k in range(8):
        keys.press("up", 1.0 + 0.15 * k)
    assert keys.lasts == pytest.approx(0.375)
    keys.press("down", 2.06)  # another key is no repeat
    assert keys.lasts == pytest.approx(0.375)


def test_every_key_of_a_mode_moves_one_axis_and_its_partner_the_other_way():
    chosen = Settings(n=6, mode="base", speed_mm=100.0, speed_deg=30.0)
    rates = {key: chosen.rates(key, slides=False) for key in AXES}
    for key, (axis, sign) in AXES.items():
        assert np.flatnonzero(rates[key]).tolist() == [axis]
        assert rates[key][axis] == pytest.approx(sign * (0.1 if axis < 3 else 30.0 * DEG))
        assert sum((other == -rates[key]).all() for other in rates.values()) == 1
    assert chosen.rates("x", slides=False) is None
    chosen.mode = "joints"
    assert chosen.rates("right", slides=True)[0] == pytest.approx(0.1)
    assert chosen.step_time(chosen.rates("left", slides=False), slides=False) == pytest.approx(
        chosen.step_deg / 30.0
    )


def test_settings_stay_on_their_ladders():
    chosen = Settings(n=3)
    for key, times in (("+", 20), ("]", 20)):
        for _ in range(times):
            assert chosen.change(key)
    assert (chosen.speed_mm, chosen.speed_deg) == (250.0, 60.0)
    assert (chosen.step_mm, chosen.step_deg) == (50.0, 30.0)
    for key, times in (("-", 20), ("[", 20)):
        for _ in range(times):
            assert chosen.change(key)
    assert (chosen.speed_mm, chosen.speed_deg) == (1.0, 1.0)
    assert chosen.change("down")
    assert chosen.joint == 1
    assert chosen.change("up")
    assert chosen.change("up")
    assert chosen.joint == 2
    assert not chosen.change("4")
    assert not chosen.change("x")


def test_a_joint_near_its_limit_is_marked(cell):
    q = cell.arm.limits.q_max - 3.0 * DEG
    view = View(
        cell=cell,
        where="here",
        settings=Settings(n=6),
        q=q,
        moving=False,
        note="",
        brakes="it brakes",
        has_gripper=True,
    )
    shown = lines(view)
    assert sum("3.0 deg" in line and "near its limit" in line for line in shown) == 6
    assert any("close the gripper" in line for line in shown)
    assert max(map(len, shown)) < 110


def test_help_names_what_is_promised(capsys):
    with pytest.raises(SystemExit):
        main(["jog", "--help"])
    assert "250 mm/s" in " ".join(capsys.readouterr().out.split())
