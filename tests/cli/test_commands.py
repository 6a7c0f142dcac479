"""The commands on good input."""

import csv
import logging
import os
import re
import signal
import subprocess
import sys
import time

import pytest

from splinearm.cli.main import DONE, INTERRUPTED
from splinearm.config import shipped_arms


def figure(text, row, column):
    """Give a number of a printed table: its row's label and its place after that."""
    (line,) = [line for line in text.splitlines() if row in line]
    return float(re.findall(r"-?\d+\.\d+", line)[column])


def test_arms_lists_every_shipped_arm(cli):
    assert cli("arms") == DONE
    for name in shipped_arms():
        assert name in cli.out


def test_a_plan_says_how_long_and_how_much_of_each_limit(cli):
    assert cli("plan", cli.job(), "--plot", "plan.png") == DONE
    assert re.search(r"duration: \d+\.\d+ s", cli.out)
    for word in ("joint1", "joint2", "velocity", "acceleration", "%"):
        assert word in cli.out
    assert (cli.folder / "plan.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.sim
def test_a_run_on_mujoco_leaves_rows_and_a_picture(cli):
    assert cli("run", cli.job(), "--csv", "rows.csv", "--plot", "run.png") == DONE
    assert "the arm is not at the start" in cli.out
    assert "outcome: finished" in cli.out
    assert (cli.folder / "run.png").read_bytes().startswith(b"\x89PNG")
    rows = list(csv.DictReader((cli.folder / "rows.csv").read_text().splitlines()))
    assert float(rows[0]["joint1_wanted_deg"]) == pytest.approx(20.0)
    assert float(rows[-1]["joint2_wanted_deg"]) == pytest.approx(60.0)
    assert [int(row["cycle"]) for row in rows] == list(range(len(rows)))


@pytest.mark.sim
def test_a_run_at_another_rate_has_as_many_more_cycles(cli):
    assert cli("run", cli.job(), "--rate", "200", "--csv", "fast.csv") == DONE
    assert cli("run", cli.job(), "--rate", "50", "--csv", "slow.csv") == DONE
    fast, slow = (len((cli.folder / f"{n}.csv").read_text().splitlines()) for n in ("fast", "slow"))
    assert fast == pytest.approx(4 * slow, rel=0.05)


@pytest.mark.sim
def test_the_demo_stays_on_its_path(cli):
    assert cli("demo", "--out", "runs") == DONE
    assert figure(cli.out, "tool off its path, commanded", 1) <= 0.05
    assert figure(cli.out, "tool off its path, measured", 1) <= 2.0
    folder = cli.folder / "runs" / "demo-1"
    assert {file.name for file in folder.iterdir()} == {"demo.csv", "demo.png"}
    assert cli("demo", "--out", "runs") == DONE
    assert (cli.folder / "runs" / "demo-2").is_dir()


@pytest.mark.sim
def test_an_arm_of_ones_own_runs_like_a_shipped_one(cli):
    cli.arm()
    job = cli.job(
        ('arm = "planar_2r"', 'arm = "mine.toml"'),
        ("[350.0, 100.0, 60.0]", "[250.0, 100.0, 50.0]"),
        ("[250.0, 250.0, 60.0]", "[150.0, 200.0, 50.0]"),
    )
    assert cli("run", job) == DONE
    assert "on mine, MuJoCo" in cli.out


@pytest.mark.bus
def test_a_run_on_the_virtual_bus_goes_through_servos(cli):
    assert cli("run", cli.job(), "--on", "virtual", "--csv", "rows.csv") == DONE
    assert re.search(r"virtual servos on unix:/", cli.out)
    said = re.search(r"loop: (\d+) cycles at 100 Hz, (\d+) missed, (\d+) unanswered", cli.out)
    assert said is not None
    cycles, missed, unanswered = map(int, said.groups())
    rows = list(csv.DictReader((cli.folder / "rows.csv").read_text().splitlines()))
    assert float(rows[-1]["joint2_measured_deg"]) == pytest.approx(60.0, abs=2.0)
    assert rows[0]["joint1_current_a"] != ""
    # a cycle that a busy computer misses is told, and leaves a gap in the rows
    assert len(rows) == cycles
    assert int(rows[-1]["cycle"]) + 1 == cycles + missed
    assert sum(row["joint1_measured_deg"] == "" for row in rows) == unanswered


def _start(*words, **more):
    command = [sys.executable, "-m", "splinearm", *map(str, words)]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more
    )


@pytest.mark.sim
@pytest.mark.parametrize(
    "number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)]
)
def test_an_interrupted_run_stops_along_its_path_and_says_so(cli, number):
    run = _start("run", cli.job(), "--on", "mujoco", "--realtime", "--csv", "rows.csv")
    deadline = time.monotonic() + 30.0
    rows = cli.folder / "rows.csv"
    while not (rows.exists() and rows.stat().st_size > 2000):
        assert run.poll() is None, run.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.02)
    run.send_signal(number)
    out, complaint = run.communicate(timeout=30)
    assert run.returncode == INTERRUPTED, complaint
    assert "stopping along the path in" in out
    assert "outcome: stopped" in out
    last = list(csv.DictReader(rows.read_text().splitlines()))[-1]
    assert float(last["joint1_wanted_rate_deg_s"]) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.sim
def test_a_run_that_is_stopped_on_its_way_to_the_start_says_just_that(cli, monkeypatch):
    from splinearm.cli import output

    say = output.console.print

    def stop_at_once(*lines, **words):
        say(*lines, **words)
        if "approaching" in str(lines):
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(output.console, "print", stop_at_once)
    # in real time: what is announced is printed beside the loop, some milliseconds later
    words = ("--csv", "rows.csv", "--plot", "run.png", "--realtime")
    assert cli("run", cli.job(), *words) == INTERRUPTED
    assert "stopped on the way to the start" in cli.out
    assert "nan" not in cli.out
    assert cli.files() == {"job.toml"}


def test_help_and_version_are_there(cli):
    assert cli("--help") == DONE
    for word in ("demo", "run", "plan", "arms", "scan", "virtual-bus"):
        assert word in cli.out
    assert cli("--version") == DONE
    assert re.match(r"splinearm \d+\.\d+", cli.out)


@pytest.mark.sim
def test_a_planned_motion_is_kept_and_carried_out_later(cli):
    assert cli("plan", cli.job(), "--save", "motion.json") == DONE
    assert "motion: motion.json" in cli.out
    assert "what holds it back" in cli.out
    assert cli("run", "motion.json", "--csv", "rows.csv") == DONE
    assert "outcome: finished" in cli.out
    assert figure(cli.out, "tool off its path, commanded", 1) <= 1e-3
    rows = list(csv.DictReader((cli.folder / "rows.csv").read_text().splitlines()))
    assert float(rows[-1]["joint2_wanted_deg"]) == pytest.approx(60.0)


def test_a_plan_within_torques_says_how_much_of_them_it_uses(cli):
    job = cli.job(("speed_mm_s = 200.0", "torque_percent = 60\ntool_acceleration_mm_s2 = 500"))
    assert cli("plan", job) == DONE
    rows = [line.split() for line in cli.out.splitlines() if " torque " in line]
    assert [row[1] for row in rows] == ["joint1", "joint2"]
    assert all("N m" in " ".join(row) for row in rows)
    assert "tool acceleration" in cli.out


def test_a_motion_is_kept_as_rows_at_a_rate(cli):
    assert cli("plan", cli.job(), "--save", "motion.csv", "--rate", "20") == DONE
    rows = list(csv.DictReader((cli.folder / "motion.csv").read_text().splitlines()))
    assert float(rows[1]["t_s"]) == pytest.approx(0.05)
    assert float(rows[-1]["joint2_deg"]) == pytest.approx(60.0)
    assert float(rows[-1]["joint2_deg_s"]) == 0.0


@pytest.mark.sim
def test_a_run_is_kept_for_foxglove(cli):
    pytest.importorskip("mcap", reason="the extra log is not installed")
    from mcap.reader import make_reader

    assert cli("run", cli.job(), "--mcap", "run.mcap") == DONE
    with (cli.folder / "run.mcap").open("rb") as stream:
        topics = {channel.topic for _, channel, _ in make_reader(stream).iter_messages()}
    assert topics == {"/joint_states", "/joint_commands", "/loop"}


def test_on_a_terminal_it_is_said_that_kernels_are_compiled(cli, monkeypatch):
    said = logging.getLogger("splinearm.compiled")
    monkeypatch.setattr(said, "level", logging.NOTSET)
    assert cli("arms") == DONE
    assert said.level == logging.NOTSET
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert cli("arms") == DONE
    assert said.level == logging.INFO
