"""``splinearm monitor`` as a person sees it, and as programs read it."""

import csv
import json
import re
import socket
import tempfile
import time
from pathlib import Path

import pytest

from splinearm.backends import centred
from splinearm.config import load_cell
from splinearm.sim.line_fault import LineFault
from splinearm.sim.virtual_bus import VirtualBus

pytestmark = pytest.mark.bus

RED = b"\x1b[1;31m"


@pytest.fixture
def bus():
    with _bus("planar_2r", transport="socket") as made:
        yield made


def _bus(arm, **more):
    cell = load_cell(arm)
    return VirtualBus(cell.arm, centred(cell.chain), cell.poses["home"], **more)


def row_of(screen, name):
    """The words of a servo's row."""
    return next(line for line in screen.splitlines() if line.startswith(name)).split()


def test_a_person_sees_who_is_silent_and_a_port_that_is_gone(terminal, kept):
    # 80 columns, as the narrowest terminals have
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        port = Path(folder) / "port"
        with _bus("wx250s", transport="socket", link=port) as bus:
            seen = terminal("monitor", "wx250s", "--port", port, "--rate", 20, rows=24, columns=80)
            seen.wait_for(r"^waist .*\d+ +12\.0 +off")
            assert max(len(line) for line in seen.screen.splitlines()) <= 80
            seen.wait_for(r"\d of 20\.0 Hz, jitter p50 [\d.]+, p99 [\d.]+, max [\d.]+ ms")
            assert RED not in seen.raw
            bus.faults = (LineFault.parse("dead id=7"),)
            seen.wait_for(r"L04 no answer:[^$]*\n +and its power")
            kept("monitor", seen.screen)
            assert RED in seen.raw
            bus.faults = ()
            seen.wait_for(r"^wrist_angle +7 +-?\d")
            bus.unplug()
            seen.wait_for("the port cannot be used")
            bus.plug_in()
            seen.wait_for(r"^wrist_angle +7 +-?\d")
            seen.press("q")
            assert seen.exit_code == 0
            assert "waist" in seen.screen  # what was last seen stays


def test_ctrl_c_ends_and_without_colour_nothing_is_red(bus, terminal):
    bus.servos[1].unplugged = True
    words = ("monitor", "planar_2r", "--port", bus.port)
    seen = terminal(*words, rows=30, columns=140, env={"NO_COLOR": "1"})
    seen.wait_for("L04 no answer: check its")
    assert "lost/crc/again" in seen.screen
    seen.press("ctrl-c")
    assert seen.exit_code == 0
    assert not re.search(rb"\x1b\[[0-9;]*3[0-7]m", seen.raw)


def test_table_json_csv_and_datagrams_say_the_same(bus, cli):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.settimeout(5.0)
        where = f"127.0.0.1:{listener.getsockname()[1]}"
        words = ("monitor", "planar_2r", "--port", bus.port, "--rate", "20", "--for", "0.4")
        assert cli(*words, "--json", "--udp", where, "--csv", "rows.csv") == 0
        lines = [json.loads(line) for line in cli.out.splitlines()]
        assert 2 <= len(lines) <= 12
        assert [json.loads(listener.recv(65536)) for _ in lines] == lines
    with (cli.folder / "rows.csv").open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == len(lines)
    for row, line in zip(rows, lines, strict=True):
        for name, servo in line["servos"].items():
            assert float(row[f"{name}.position_deg"]) == servo["position_deg"]
            assert float(row[f"{name}.voltage_v"]) == servo["voltage_v"]
        assert float(row["timestamp"]) == line["timestamp"]
    assert lines[-1]["wanted_rate_hz"] == 20.0
    assert abs(lines[-1]["timestamp"] - time.time()) < 20.0
    assert lines[0]["servos"]["joint1"]["joint"] == "joint1"
    assert cli("monitor", "planar_2r", "--port", bus.port, "--once", "--json") == 0
    said = json.loads(cli.out)["servos"]
    assert cli("monitor", "planar_2r", "--port", bus.port, "--once") == 0
    for name, servo in said.items():
        row = row_of(cli.out, name)
        assert float(row[3]) == servo["position_deg"]
        assert float(row[4]) == servo["velocity_deg_s"]
        assert float(row[5]) == servo["current_a"]
        assert float(row[7]) == servo["temperature_degc"]
        assert float(row[8]) == servo["voltage_v"]


def test_a_look_tells_by_its_exit_code_whether_all_is_well(bus, cli):
    assert cli("monitor", "--port", bus.port, "--baud", "1000000", "--once") == 0
    assert "servo_2" in cli.out
    with bus.lock:
        bus.servos[2].fail("overheating")
    assert cli("monitor", "planar_2r", "--port", bus.port, "--once") == 1
    assert "S07" in cli.out
    assert "overheating" in cli.out


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("--on", "virtual"), "need an arm"),
        (("planar_2r", "--port", "x", "--rate", "0"), "--rate"),
        (("planar_2r", "--port", "x", "--for", "-1"), "--for"),
        (("planar_2r", "--port", "x", "--udp", "here"), "--udp"),
        (("planar_2r", "--port", "/dev/no_such_port"), "no_such_port"),
        (("nobody", "--port", "x"), "nobody"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line_and_nothing_is_written(words, reason, cli):
    assert cli("monitor", *words, "--csv", "rows.csv") == 2
    assert reason in cli.err
    assert len(cli.err.strip().splitlines()) == 1
    assert cli.files() == set()


def test_virtual_servos_can_be_watched_without_any_hardware(cli):
    assert cli("monitor", "planar_2r", "--on", "virtual", "--once", "--json") == 0
    assert json.loads(cli.out)["connected"] is True
