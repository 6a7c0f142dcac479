"""Each fault of the computer and of a port is found, with its cause and its remedy."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from computer_cases import COMPUTER_CASES, SILENT_CASES

from splinearm.doctor.computer import Computer, device_of, place_of_module, version_of
from splinearm.doctor.computer_check import EXTRAS, LIBRARIES, check_comfort, check_software
from splinearm.doctor.look import diagnose
from splinearm.doctor.port_check import check_port, check_silent_port, unusable
from splinearm.doctor.port_fact import holders, ports
from splinearm.errors import PortError

ROOT = Path(__file__).parents[2]


def look(computer, port):
    return [*check_software(computer), *check_port(computer, port), *check_comfort(computer)]


@pytest.mark.parametrize("case", COMPUTER_CASES, ids=lambda case: f"{case.code} {case.act}")
def test_a_fault_is_found_with_cause_and_remedy(case, fake):
    assert look(fake.computer, fake.port) == []
    case.hurt(fake)
    (finding,) = look(fake.computer, case.port)
    assert finding.code == case.code
    assert re.search(case.cause, finding.cause), finding.cause
    assert re.search(case.remedy, finding.remedy), finding.remedy
    assert finding.where in (case.port, "this computer")


@pytest.mark.parametrize("case", SILENT_CASES, ids=lambda case: f"{case.code} {case.act}")
def test_a_silent_port_that_is_no_adapter_is_told(case, fake):
    assert list(check_silent_port(fake.computer, fake.port)) == []
    case.hurt(fake)
    (finding,) = check_silent_port(fake.computer, case.port)
    assert finding.code == case.code
    assert re.search(case.cause, finding.cause), finding.cause
    assert re.search(case.remedy, finding.remedy), finding.remedy


def test_a_port_that_cannot_be_looked_at_is_not_opened(fake):
    fake.facts["may_use"] = lambda _: False
    fake.facts["enrolled"] = frozenset
    diagnosis = diagnose(fake.port, computer=fake.computer)
    assert [finding.code for finding in diagnosis.findings] == ["P02"]
    assert diagnosis.roll is None


@pytest.fixture
def terminal():
    """A serial port that is there: the client's end of a pseudo terminal."""
    master, slave = os.openpty()
    yield os.ttyname(slave)
    os.close(master)
    os.close(slave)


def test_a_process_that_holds_a_real_port_is_named(terminal):
    code = "import os, sys, time; os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)\n"
    code += "print('open', flush=True); time.sleep(60)"
    with subprocess.Popen(
        [sys.executable, "-c", code, terminal], stdout=subprocess.PIPE, text=True
    ) as process:
        process.stdout.readline()
        (finding,) = check_port(Computer(), terminal)
        process.kill()
    assert finding.code == "P04"
    assert f"(process {process.pid}) has it open" in finding.cause
    assert f"kill {process.pid}" in finding.remedy


def test_a_device_that_is_no_serial_port_is_told_whoever_has_it_open():
    (finding,) = check_port(Computer(), "/dev/null")
    assert finding.code == "P07"


def test_this_process_and_who_serves_a_terminal_are_no_holders(terminal):
    assert list(check_port(Computer(), terminal)) == []
    assert holders(Computer(), device_of(terminal)) == ()


def test_a_port_that_is_locked_by_a_program_of_another_user_is_told():
    finding = unusable(PortError("/dev/ttyUSB0", "another program uses it", "close it"))
    assert finding.code == "P04"
    assert "sudo fuser -v /dev/ttyUSB0" in finding.remedy


def test_a_port_that_is_lost_is_told_with_what_helps():
    finding = unusable(PortError("/dev/ttyUSB0", "the connection is lost", "check the cable"))
    assert (finding.code, finding.remedy) == ("P08", "check the cable")


def test_adapters_are_listed_by_the_names_that_they_keep(fake):
    fake.file("/dev/ttyACM0", "")
    fake.file("/dev/serial/by-id/.keep", "").unlink()
    name = "/dev/serial/by-id/usb-FTDI_U2D2_FT123-if00-port0"
    (fake.root / name[1:]).symlink_to(fake.root / "dev/ttyUSB0")
    assert ports(fake.computer) == (name, "/dev/ttyACM0")


def test_the_facts_of_this_computer_are_true():
    assert not any(device_of(port).is_terminal for port in ("/dev/null", "/"))
    assert device_of("/dev/nonsense") is None
    assert place_of_module("json").endswith("__init__.py")
    assert place_of_module("no_such_module") is None
    assert version_of("numpy")
    assert version_of("no-such-distribution") is None
    assert Computer().footing().words
    assert isinstance(Computer().enrolled(), frozenset)


def test_a_folder_without_code_is_told_from_a_module(tmp_path, monkeypatch):
    (tmp_path / "left_over").mkdir()
    monkeypatch.syspath_prepend(str(tmp_path))
    assert place_of_module("left_over") == ""


def test_libraries_and_extras_are_those_of_the_package():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    named = {re.match(r"[\w-]+", text)[0] for text in project["dependencies"]}
    assert named == set(LIBRARIES.values())
    extras = {
        name: {re.match(r"[\w-]+", text)[0] for text in texts}
        for name, texts in project["optional-dependencies"].items()
        if name not in ("dev", "peers")
    }
    assert extras == {name: set(modules) for name, (modules, _) in EXTRAS.items()}
