"""``splinearm doctor``, and how a timeout of any command leads to it."""

import json
import time

import pytest

from splinearm.cli.main import main
from splinearm.config.cell import arm_file
from splinearm.doctor.first_aid import explained
from splinearm.errors import BusTimeoutError, ConfigError, PacketError, PortError
from splinearm.sim.line_fault import LineFault

JOB = """\
schema = "splinearm-job/1"
name = "nod"
title = "Nod"
arm = "planar_2r"
start_deg = [-45.0, 90.0]
[motion]
through = "joint"
[[waypoint]]
joints_deg = [-40.0, 80.0]
"""


@pytest.fixture
def said(capsys, monkeypatch, fake):
    """Run the command line on a computer that is well; give exit code, output, errors."""

    def run(*words: str) -> tuple[int, str, str]:
        code = main(list(words))
        return (code, *capsys.readouterr())

    def computer():
        from splinearm.doctor.computer import Computer, device_of

        return Computer(root=fake.root, **(fake.facts | {"device": device_of}))

    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setattr("splinearm.cli.doctor.this_computer", computer)
    return run


@pytest.mark.bus
def test_a_healthy_arm_is_told_so(said, virtual):
    with virtual("planar_2r") as (_, bus):
        code, out, err = said("doctor", bus.port, "--arm", "planar_2r")
    assert (code, err) == (0, "")
    assert "joint1" in out
    assert "1316 Hz follow from 40 + 36 bytes" in out
    assert "C08" in out or "nothing is wrong" in out


@pytest.mark.bus
def test_findings_come_in_the_order_in_which_they_are_mended(said, virtual):
    with virtual("wx250s") as (_, bus):
        with bus.lock:
            bus.servos[4].fail("overload")
            bus.servos[9].unplugged = True
            bus.servos[1].memory["Return Delay Time"] = 250
        code, out, err = said("doctor", bus.port, "--arm", "wx250s")
    assert (code, err) == (1, "")
    table, advice = out.split("what to do, in this order:")
    order = [line.split()[0] for line in advice.splitlines() if line.startswith("  ")]
    assert [c for c in order if c != "C08"] == ["L04", "S10", "S11", "L09"]
    assert "servo 4 (elbow)" in table
    command = f"`splinearm recover wx250s --port {bus_name(advice)}`"
    assert command in advice
    assert "docs/troubleshooting.md" in advice


def bus_name(text: str) -> str:
    return next(word for word in text.split() if word.startswith("unix:")).strip("`,")


@pytest.mark.bus
def test_programs_get_the_same(said, virtual):
    with virtual("wx250s") as (_, bus):
        with bus.lock:
            bus.servos[4].fail("overload")
        code, out, err = said("doctor", bus.port, "--arm", "wx250s", "--json")
        port = bus.port
    document = json.loads(out)
    assert (code, err) == (1, "")
    assert (document["port"], document["arm"], document["well"]) == (port, "wx250s", False)
    assert [f["code"] for f in document["findings"] if f["code"] != "C08"] == ["S10", "S11"]
    assert all(f["cause"] and f["remedy"] and f["where"] for f in document["findings"])


def test_without_a_port_the_only_adapter_is_taken_and_none_is_a_finding(said, fake):
    code, out, _ = said("doctor", "--json")
    document = json.loads(out)
    assert document["port"] == "/dev/ttyUSB0"
    assert [f["code"] for f in document["findings"]] == ["P01"]  # it is there in the folder only
    fake.unplug()
    code, out, _ = said("doctor", "--json")
    assert code == 1
    assert "no adapter is plugged in" in json.loads(out)["findings"][0]["cause"]


def test_it_cannot_look_where_two_adapters_are_there(said, fake):
    fake.file("/dev/ttyACM0", "")
    code, out, err = said("doctor")
    assert (code, out) == (2, "")
    assert "name one: /dev/ttyACM0, /dev/ttyUSB0" in err
    assert "Traceback" not in err


def test_it_cannot_look_with_an_arm_file_that_is_none(said, tmp_path):
    broken = tmp_path / "broken.toml"
    broken.write_text("schema = 1", encoding="utf-8")
    assert said("doctor", "--arm", str(broken))[0] == 2
    code, _, err = said("doctor", "--arm", "nobody")
    assert code == 2
    assert "is no shipped arm" in err


def test_a_missing_library_is_told_before_it_is_needed(said, fake, monkeypatch):
    monkeypatch.setattr(
        "splinearm.cli.doctor.this_computer",
        lambda: fake.computer,
    )
    fake.facts["module"] = lambda name: None if name == "numpy" else f"/{name}.py"
    code, out, _ = said("doctor", "/dev/ttyUSB0")
    assert code == 1
    assert "the library numpy is not there" in out
    assert "pip install --force-reinstall numpy" in out


def test_it_runs_where_libraries_are_missing(python):
    code = (
        "import sys\n"
        "for name in ('numpy', 'rich', 'serial'): sys.modules[name] = None\n"
        "from splinearm.cli.main import main\n"
        "print(main(['doctor']))"
    )
    lines = python(code).splitlines()
    assert [line.split(":")[0] for line in lines[:-1]] == ["C02 a library is missing"] * 3
    assert "`pip install --force-reinstall rich`" in lines[2]
    assert lines[-1] == "1"


@pytest.mark.bus
def test_hints_alone_are_no_trouble(said, fake, virtual):
    fake.facts["module"] = lambda name: None if name == "mcap" else f"/{name}.py"
    with virtual("planar_2r") as (_, bus):
        code, out, _ = said("doctor", bus.port)
    assert code == 0
    assert "pip install 'splinearm[log]'" in out


# --- a timeout anywhere leads here


def _cut(bus):
    bus.silent = True


def _at_57600(bus):
    bus.servos[2].memory["Baud Rate"] = 1


def _missing(bus):
    bus.servos[2].unplugged = True


FAILURES = [
    (_cut, "nobody answers", "power on", "L01"),
    (_at_57600, "it answers at 57600 baud; the arm's file says 1000000", "Baud Rate", "L02"),
    (_missing, "no answer from servo 2 (joint2)", "check its cable", "L04"),
]


@pytest.mark.bus
@pytest.mark.parametrize(
    ("command", "failure"),
    [("recover", FAILURES[0]), ("run", FAILURES[1]), ("recover", FAILURES[2])],
    ids=lambda value: value if isinstance(value, str) else value[-1],
)
def test_a_timeout_is_told_with_its_cause(command, failure, said, virtual, tmp_path):
    hurt, cause, remedy, code = failure
    job = tmp_path / "nod.toml"
    job.write_text(JOB, encoding="utf-8")
    with virtual("planar_2r", "pty") as (_, bus):
        with bus.lock:
            hurt(bus)
        words = {
            "run": ("run", str(job), "--on", bus.port),
            "recover": ("recover", "planar_2r", "--port", bus.port),
        }[command]
        exit_code, _, err = said(*words)
        port = bus.port
    assert exit_code == 2
    (line,) = err.splitlines()
    assert line.startswith("splinearm: servo ")
    assert "does not answer" in line
    assert cause in line
    assert remedy in line
    assert line.endswith(f"({code}; `splinearm doctor {port} --arm planar_2r` looks closer)")


@pytest.mark.parametrize("words", [("recover", "planar_2r", "--port"), ("scan",)])
def test_a_port_that_is_not_there_is_told_with_what_helps(words, said):
    code, _, err = said(*words, "/dev/ttyNONE")
    (line,) = err.splitlines()
    assert code == 2
    assert "port /dev/ttyNONE cannot be used: there is no such port; plug the adapter in" in line
    assert "(P01; `splinearm doctor /dev/ttyNONE" in line


@pytest.mark.bus
@pytest.mark.slow
@pytest.mark.parametrize("hurt", [_cut, _at_57600, _missing])
def test_the_look_after_a_timeout_is_short(hurt, virtual):
    with virtual("wx250s", "pty") as (_, bus):
        with bus.lock:
            hurt(bus)
        began = time.monotonic()
        text = explained(BusTimeoutError(2, port=bus.port, name="shoulder"), arm="wx250s")
        assert time.monotonic() - began < 3.0
    assert "looks closer" in text


@pytest.mark.bus
def test_an_error_that_is_gone_again_names_the_doctor(virtual):
    with virtual("planar_2r") as (_, bus):
        error = BusTimeoutError(2, port=bus.port, name="joint2")
        text = explained(error, arm="planar_2r")
        assert text == f"{error}; `splinearm doctor {bus.port} --arm planar_2r` looks closer"
        assert "planar_2r" not in explained(PacketError("a", "b"), port=bus.port, arm="nobody.toml")


@pytest.mark.bus
def test_damaged_answers_are_told_with_their_cause(virtual):
    with virtual("planar_2r") as (_, bus):
        bus.faults = (LineFault.parse("garbled p=0.05"),)
        error = PacketError("an answer of servo 1", "a damaged packet")
        text = explained(error, port=bus.port, arm="planar_2r")
        port = bus.port
    assert text.startswith(f"{error}: {port}: ")
    assert "answers are damaged, from" in text
    assert "(L07; `splinearm doctor" in text


def test_what_no_look_explains_stays_as_it_is():
    error = ConfigError("arm.toml", "bus", "is wrong")
    assert explained(error) == str(error)
    silent = BusTimeoutError(2)
    assert explained(silent, port="virtual") == str(silent)
    assert explained(PortError("virtual", "it did not start", "try again")).endswith("try again")


def test_a_virtual_bus_that_has_ended_is_no_missing_port():
    error = BusTimeoutError(2, port="unix:/nowhere/bus")
    text = explained(error, arm=str(arm_file("planar_2r")))
    assert "the virtual bus has ended with this run" in text
