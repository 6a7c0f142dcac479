"""``splinearm setup``, ``backup`` and ``restore`` on a port, before a person and without one."""

import io
import json
import os
import signal
import subprocess
import sys
import threading
import time
from datetime import UTC, datetime

import pytest
from rich.console import Console

from splinearm.backends import centred
from splinearm.cli.main import main
from splinearm.cli.setup_person import TerminalPerson, console_for, show_task
from splinearm.commissioning.bench import Address, Bench, Found
from splinearm.commissioning.image import read_image
from splinearm.commissioning.task import Change, Task
from splinearm.config import load_cell
from splinearm.config.calibration import save_calibration
from splinearm.config.calibration_table import Calibration, ServoCalibration
from splinearm.sim.choice import Choices
from splinearm.sim.virtual_bus import VirtualBus

pytestmark = pytest.mark.bus

PLANAR = load_cell("planar_2r")
EEPROM = ("ID", "Baud Rate", "Return Delay Time", "Operating Mode", "Min Position Limit")


def virtual(cell=PLANAR, **options):
    return VirtualBus(cell.arm, centred(cell.chain), cell.poses["home"], **options)


@pytest.fixture
def disordered():
    """An arm of which both servos have something else than the file says."""
    with virtual() as bus:
        for servo, rate in zip(bus.all_servos, (3, 1), strict=True):
            servo.choices = Choices(boot_time=0.0)
            servo.memory["Baud Rate"] = rate
            servo.memory["Return Delay Time"] = 250
            servo.memory["Min Position Limit"] = 1500
        bus.all_servos[0].memory["ID"] = 1
        yield bus


@pytest.fixture
def box(request):
    """Servos fresh out of the box in a process of their own; give the port and who plugs."""
    command = [sys.executable, "-m", "splinearm", "virtual-bus", "planar_2r"]
    process = subprocess.Popen(
        [*command, "--fresh", "--orders", "--until-eof"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )

    def plug(*orders):
        process.stdin.write("".join(f"{order}\n" for order in orders))
        process.stdin.flush()

    yield process.stdout.readline().removeprefix("port: ").strip(), plug
    process.stdin.close()
    process.wait(10)
    process.stdout.close()


def holds(bus):
    return [[servo.memory[name] for name in EEPROM] for servo in bus.all_servos]


AS_THE_FILE_SAYS = [[1, 3, 0, 3, 288], [2, 3, 0, 3, 353]]


@pytest.mark.slow  # the page for new owners shows it too
def test_a_person_sets_an_arm_up_from_the_box(box, terminal, cli):
    port, plug = box
    seen = terminal("setup", "planar_2r", "--port", port, rows=60, columns=120)
    seen.wait_for("Connect only servo joint1")
    plug("connect joint1")
    seen.wait_for(r"Write 4 registers into 1 servo\?")
    assert "57600 baud" in seen.screen
    seen.type("y\n")
    seen.wait_for("Connect only servo joint2")
    plug("disconnect joint1", "connect joint2")
    seen.wait_for("joint2: XM430")
    seen.wait_for(r"Write 5 registers into 1 servo\?")
    seen.type("y\n")
    seen.wait_for("Now connect all servos")
    plug("connect all")
    seen.wait_for("all servos are set up; 11 registers written")
    assert seen.exit_code == 0
    assert cli("setup", "planar_2r", "--port", port, "--check", "--json") == 0
    document = json.loads(cli.out)
    assert (document["ready"], document["left"]) == (True, [])
    assert [servo["baud"] for servo in document["servos"]] == [1_000_000, 1_000_000]


def test_without_a_terminal_it_needs_a_yes_and_check_needs_none(disordered, cli, monkeypatch):
    port = disordered.port
    disordered.all_servos[1].memory["Baud Rate"] = 3
    assert cli("setup", "planar_2r", "--port", port) == 2
    assert cli.err == (
        "splinearm: --yes: there is no terminal to ask on; say --yes to write without asking\n"
    )
    monkeypatch.setattr("sys.stdin", None)  # as of a program that is started without any
    assert cli("setup", "planar_2r", "--port", port) == 2
    assert "there is no terminal to ask on" in cli.err
    assert cli("setup", "planar_2r", "--port", port, "--check") == 1
    assert "joint2: Return Delay Time 250 -> 0" in cli.out
    assert disordered.changes == 0


def test_all_is_put_right_once_backed_up_and_restored(disordered, cli, tmp_path):
    port = disordered.port
    before = holds(disordered)
    assert cli("setup", "planar_2r", "--port", port, "--yes", "--json") == 0
    document = json.loads(cli.out)
    assert holds(disordered) == AS_THE_FILE_SAYS
    assert document["servos"][1]["changes"][0] == {
        "register": "Baud Rate",
        "address": 8,
        "old": 1,
        "new": 3,
    }
    changes = disordered.changes
    assert cli("setup", "planar_2r", "--port", port, "--yes") == 0
    assert "there is nothing to write. Next: `splinearm doctor /dev" in cli.out
    assert disordered.changes == changes
    assert cli("backup", "planar_2r", "--port", port, "-o", "now.toml", "--json") == 0
    assert json.loads(cli.out)["servos"] == ["joint1", "joint2"]
    assert cli("backup", "planar_2r", "--port", port, "-o", "now.toml") == 2
    assert "is there already" in cli.err
    assert cli("restore", document["backup"], "--port", port, "--yes") == 0
    assert holds(disordered) == before
    assert "(read only), and RAM" in cli.out


def test_a_scan_is_for_programs_too_and_tells_servos_fresh_from_the_box(disordered, cli):
    port = disordered.port
    for servo in disordered.all_servos:
        servo.swap()
    assert cli("scan", port, "--baud", "57600", "--json") == 1
    document = json.loads(cli.out)
    assert document["schema"] == "splinearm-scan/1"
    assert document["servos"] == []
    assert document["shared"] == [{"id": 1, "baud": 57_600, "protocol": 2}]
    assert cli("scan", port, "--baud", "57600") == 1
    assert "several servos have this id" in cli.out
    disordered.harness.disconnect("joint2")
    assert cli("scan", port, "--baud", "57600", "--json") == 0
    (servo,) = json.loads(cli.out)["servos"]
    assert servo == {
        "id": 1,
        "model": "XM430-W350",
        "model_number": 1020,
        "firmware": 53,
        "baud": 57_600,
        "protocol": 2,
    }


def test_a_scan_that_finds_nobody_says_what_to_try(disordered, cli):
    assert cli("scan", disordered.port, "--baud", "4000000") == 2
    assert "no servo answers" in cli.out
    assert "try another rate with --baud" in cli.out


def test_bad_words_end_in_one_line(cli, tmp_path):
    assert cli("setup", "nobody", "--check") == 2
    assert len(cli.err.splitlines()) == 1
    for rate in ("0", "-57600"):
        assert cli("scan", "/dev/null", "--baud", "1000000", "--baud", rate) == 2
        assert f"--baud: no servo has {rate}; choose one of 9600, " in cli.err
    cli.write("b.toml", 'schema = "splinearm-job/1"\n')
    assert cli("restore", "b.toml", "--port", "/dev/null", "--yes") == 2
    assert "splinearm-backup/1" in cli.err
    assert cli("backup", "--port", "/dev/nowhere") == 2
    assert len(cli.err.splitlines()) == 1


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 2, 3, 4, 5])
def test_killed_by_force_and_started_again_it_comes_to_the_same_end(count, disordered):
    command = [sys.executable, "-m", "splinearm", "setup", "planar_2r", "--yes", "--port"]
    process = subprocess.Popen([*command, disordered.port], stdout=subprocess.DEVNULL)

    def kill():
        until = time.monotonic() + 30.0
        while disordered.changes < count and time.monotonic() < until:
            time.sleep(2e-4)
        os.kill(process.pid, signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    assert process.wait(40) == -signal.SIGKILL
    killer.join()
    assert disordered.changes >= count
    assert main(["setup", "planar_2r", "--yes", "--port", disordered.port]) == 0
    assert holds(disordered) == AS_THE_FILE_SAYS


class Typed(io.StringIO):
    """A terminal at which someone has typed ahead."""

    def isatty(self):
        return True


def test_torque_is_let_go_only_after_a_question_or_a_word(disordered, cli, monkeypatch):
    words = ("setup", "planar_2r", "--port", disordered.port)
    servo = disordered.all_servos[1]
    servo.memory["Baud Rate"] = disordered.all_servos[0].memory["Baud Rate"] = 3
    with disordered.lock:
        servo.write(servo.model.table["Torque Enable"].address, b"\x01")
    changes = disordered.changes
    monkeypatch.setattr("sys.stdin", Typed("y\nn\n"))
    assert cli(*words) == 1
    assert "The arm holds with torque (joint2)" in cli.out
    assert "not agreed that they lose it; nothing written" in cli.out
    monkeypatch.setattr("sys.stdin", io.StringIO())
    assert cli(*words, "--yes") == 1  # a yes to writing is none to falling
    assert (disordered.changes, servo.torque_on) == (changes, True)
    assert cli(*words, "--yes", "--release") == 0
    assert holds(disordered) == AS_THE_FILE_SAYS
    assert not servo.torque_on


def test_who_hangs_there_already_is_asked_and_only_a_clear_yes_is_one(capsys, monkeypatch):
    one = Found(Address(57_600, 2, 1), 1020, 53)
    servo = PLANAR.chain.servos[0]
    for typed, answer in (
        ("y\n", True),
        ("Yes\n", True),
        ("\n", False),
        ("yep\n", False),
        ("", False),
    ):
        monkeypatch.setattr("sys.stdin", Typed(typed))
        person = TerminalPerson(console_for(as_json=False), yes=False, release=False)
        assert person.is_it(servo, one) is answer
    assert "(id 1 at 57600 baud). Is it joint1, the one for joint1? [y/N]" in (
        capsys.readouterr().out.replace("\n", " ")
    )
    assert not TerminalPerson(console_for(as_json=True), yes=True, release=False).is_it(servo, one)


def test_on_a_narrow_terminal_every_old_and_new_value_is_shown(disordered, capsys):
    found = Found(Address(1_000_000, 2, 2), 1020, 53)
    with Bench(disordered.port) as bench:
        disordered.all_servos[1].memory["Baud Rate"] = 3
        image = read_image(bench, found)
    register = image.model.table["Return Delay Time"]
    task = Task(name="joint2", image=image, changes=(Change(register, 250, 0),))
    for width in (10, 30, 69, 70, 200):
        show_task(Console(width=width), task)
        shown = "".join(capsys.readouterr().out.split())
        assert all(word in shown for word in ("ReturnDelayTime", "250(500us)", "0(0us)"))


@pytest.mark.parametrize("seconds", ["nan", "inf", "-1"])
def test_nobody_is_waited_for_without_end(cli, seconds):
    assert cli("setup", "planar_2r", "--port", "/dev/null", "--yes", "--wait-s", seconds) == 2
    assert "--wait-s: wants seconds" in cli.err


def test_a_calibration_that_no_longer_fits_does_not_keep_servos_from_being_set_up(
    disordered, cli, tmp_path, monkeypatch
):
    monkeypatch.setenv("SPLINEARM_HOME", str(tmp_path))
    registers = {"Min Position Limit": 100}
    one = ServoCalibration(
        name="joint1", servo_id=1, model="XM430-W350", zero_ticks=2048, settings=registers
    )
    other = ServoCalibration(name="joint2", servo_id=44, model="XM430-W350", zero_ticks=1)
    date = datetime(2026, 11, 22, tzinfo=UTC)
    save_calibration(Calibration(arm="planar_2r", name="default", date=date, servos=(one, other)))
    disordered.all_servos[1].memory["Baud Rate"] = 3
    assert cli("setup", "planar_2r", "--port", disordered.port, "--check") == 1
    assert "does not fit the arm's file any more: joint2 (calibrate anew" in cli.out
    assert "joint1: Min Position Limit 1500 -> 100" in cli.out
    assert "joint2: Min Position Limit 1500 -> 353" in cli.out
