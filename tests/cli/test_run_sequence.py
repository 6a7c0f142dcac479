"""``splinearm run`` of jobs of pieces: reports, a person at the terminal, and bad input."""

import contextlib
import json
import signal
import socket
import subprocess
import sys
import time
from math import inf

import numpy as np
import pytest

from splinearm.backends import centred
from splinearm.cli.main import DONE, INTERRUPTED, REFUSED
from splinearm.config import load_cell
from splinearm.sim.virtual_bus import VirtualBus

HEAD = 'schema = "splinearm-job/1"\nname = "many"\ntitle = "Many pieces"\narm = "planar_2r"\n'
WAVE = """[[piece]]
name = "wave"
degree = 3
knots = [0.0, 0.0, 0.0, 0.0, 2.0, 2.0, 2.0, 2.0]
points_deg = [[-30.0, 90.0], [-30.0, 90.0], [0.0, 70.0], [0.0, 70.0]]
"""
GRIP = '[[piece]]\nname = "grab"\ngripper = "close"\nwait_s = 0.2\n'
PICK = """schema = "splinearm-job/1"
name = "grab"
title = "Grab"
arm = "wx250s"
[[waypoint]]
through = "joint"
joints_deg = [0.0, -30.0, 30.0, 0.0, 60.0, 0.0]
gripper = "close"
[[waypoint]]
name = "far"
through = "joint"
joints_deg = [90.0, -30.0, 30.0, 0.0, 60.0, 0.0]
"""


@pytest.mark.sim
def test_every_piece_and_all_of_them_are_reported(cli):
    job = cli.write("job.toml", HEAD + "[motion]\ntimes = 2\n" + WAVE + GRIP)
    assert cli("run", job, "--json", "r.json", "--csv", "rows.csv") == DONE
    for words in (
        "Many pieces on planar_2r, MuJoCo: 1 motion, 2.20 s and what the gripper takes, 2 times",
        "MuJoCo: no gripper moves here; its waits are kept",
        "slowly back to the begin: ",
        "in all: 2 rounds, 3 motions",
        "outcome: finished (SUCCESSFUL, 0)",
    ):
        assert words in cli.out
    document = json.loads((cli.folder / "r.json").read_text())
    assert document["schema"] == "splinearm-sequence/1"
    assert [piece["name"] for piece in document["pieces"]] == ["wave", "grab"]
    rows = (cli.folder / "rows.csv").read_text().splitlines()
    assert len(rows) == document["loop"]["cycles"] + 1


@pytest.mark.sim
def test_names_with_brackets_are_shown_as_they_are(cli):
    name = "to the [left] [/] [1]"
    text = (HEAD + WAVE).replace('"Many pieces"', f'"{name}"').replace('"wave"', f'"{name}"')
    job = cli.write("job.toml", text.replace("2.0", "0.3"))
    for command in ("plan", "run"):
        assert cli(command, job) == DONE
        assert cli.out.count(name) >= 2


@pytest.mark.sim
def test_every_cycle_of_all_pieces_is_sent_to_who_listens(cli):
    job = cli.write("job.toml", HEAD + WAVE.replace("2.0", "0.3") + WAVE.replace("2.0", "0.3"))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.settimeout(0.2)
        port = listener.getsockname()[1]
        assert cli("run", job, "--udp", f"127.0.0.1:{port}") == DONE
        times = []
        with contextlib.suppress(TimeoutError):
            while True:
                times.append(json.loads(listener.recv(65536))["timestamp"])
    assert len(times) > 50
    assert times == sorted(times)
    assert cli("run", job, "--udp", "nowhere") == REFUSED
    assert len(cli.err.strip().splitlines()) == 1


@pytest.mark.sim
def test_a_person_stops_a_job_of_pieces_and_lets_it_go_on(cli, terminal):
    job = cli.write("job.toml", HEAD + WAVE.replace("2.0", "1.0") + GRIP)
    person = terminal("run", job, "--on", "mujoco", "--realtime", "--rate", 20, "--json", "r.json")
    person.wait_for("motion of 1.00 s begins")
    time.sleep(0.3)
    person.press("ctrl-c")
    person.wait_for("go on from where it rests")
    stopped = json.loads((cli.folder / "r.json").read_text())
    assert (stopped["outcome"], stopped["stopped_in"]) == ("stopped", "wave")
    assert 0.2 < stopped["stopped_at_s"] < 1.0
    person.type("y\n")
    person.wait_for(r"outcome: finished")
    assert person.exit_code == DONE
    finished = json.loads((cli.folder / "r.json").read_text())
    assert [piece["name"] for piece in finished["pieces"]] == ["wave", "grab"]


@pytest.mark.bus
@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
def test_what_a_gripper_holds_it_goes_on_holding_when_the_program_is_ended(cli, how):
    cell = load_cell("wx250s")
    chain = centred(cell.chain)
    home = cell.poses["home"]
    job = cli.write("job.toml", PICK)
    with VirtualBus(cell.arm, chain, home, transport="socket") as bus:
        low = (1802 + 0.4 * (2875 - 1802) - 2048) / 4096 * 2.0 * np.pi
        bus.grip("gripper", (low, inf))
        command = [sys.executable, "-m", "splinearm", "run", str(job), "--on", bus.port]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            for line in process.stdout:
                if line.startswith("motion of") and bus.servos[9].load > 0.2:
                    break
            time.sleep(0.3)
            process.send_signal(how)
            rest = process.stdout.read()
            code = process.wait(20)
        assert code == (INTERRUPTED if how is signal.SIGTERM else -signal.SIGKILL)
        if how is signal.SIGTERM:
            assert "rests in 'to far'" in rest
        time.sleep(0.6)
        before = bus.q
        time.sleep(0.2)
        assert np.abs(bus.q - before).max() < 0.01  # the arm has come to rest
        assert 0.0 < bus.q[0] < np.radians(80.0)
        assert bus.servos[9].torque_on
        assert not bus.servos[9].tripped
        assert bus.servos[9].load == pytest.approx(0.25, rel=0.1)


@pytest.mark.parametrize(
    ("text", "words", "says"),
    [
        (WAVE, ["--plot", "p.png"], "--plot: draws one motion, and this job is more"),
        (WAVE.replace("0.0, 70.0]]", "0.0, 700.0]]"), [], "piece[0]"),
        ('[[piece]]\ngripper = "opne"\n', [], "piece[0].gripper"),
        ('[[piece]]\nmotion = "no.json"\n', [], "piece[0].motion"),
        (WAVE, ["--csv", "job.toml"], "is there already"),
        (WAVE, ["--csv", "rows", "--json", "./rows"], "cannot hold both"),
    ],
)
def test_bad_input_is_one_line_and_nothing_moves(cli, text, words, says):
    job = cli.write("job.toml", HEAD + text)
    before = cli.files()
    assert cli("run", job, *words) == REFUSED
    assert cli.files() == before
    [line] = cli.err.strip().splitlines()
    assert says in line


@pytest.mark.bus
def test_a_gripper_that_is_not_calibrated_is_named_before_anything_moves(cli):
    cell = load_cell("wx250s")
    text = cell.file.read_text().replace("open_ticks = 2875\n", "")
    arm = cli.write("arm.toml", text)
    job = cli.write("job.toml", PICK)
    chain = centred(cell.chain)
    with VirtualBus(cell.arm, chain, cell.poses["home"], transport="socket") as bus:
        before = bus.q
        assert cli("run", job, "--arm", arm, "--on", bus.port) != DONE
        [line] = cli.err.strip().splitlines()
        assert "servo 9 (gripper): where it is open and where it is closed is not known" in line
        np.testing.assert_allclose(bus.q, before, atol=0.05)  # it hangs by its weight
        assert not bus.servos[9].torque_on


def test_the_steps_of_a_job_of_pieces_are_planned_and_nothing_moves(cli):
    job = cli.write("job.toml", HEAD + "[motion]\ntimes = 2\n" + WAVE + GRIP)
    assert cli("plan", job) == DONE
    for words in ("wave", "grab", "back to the begin", "duration: 2.200 s", "2 times"):
        assert words in cli.out
    assert cli("plan", job, "--json") == DONE
    document = json.loads(cli.out)
    assert [step["kind"] for step in document["steps"]] == ["motion", "gripper"]
    assert document["back"]["kind"] == "transition"
    assert 0.1 < document["back"]["uses_most"]["share"] <= 0.3 + 1e-9
    assert cli("plan", job, "--plot", "a.png") == REFUSED
    assert "--plot" in cli.err
    assert cli.files() == {"job.toml"}
