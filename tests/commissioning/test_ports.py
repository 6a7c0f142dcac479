"""Ports by what is behind them, on computers made of a folder, and which of them is meant."""

import argparse

import pytest

from splinearm.cli.port_words import add_port, port_of
from splinearm.commissioning.ports import usb_ports
from splinearm.config import load_cell
from splinearm.doctor.computer import Computer, Device
from splinearm.errors import ConfigError

U2D2 = ("0403", "6014", "ROBOTIS", "U2D2", "FT6S4EFP")
OPENRB = ("2f5d", "2202", "ROBOTIS", "OpenRB-150", "8F2A")
MODEM = ("12d1", "1001", "", "a modem", "")


class Machine:
    """A computer whose dev and sys lie in a folder."""

    def __init__(self, root):
        self.root = root
        self.computer = Computer(root=root, device=self._device)
        (root / "dev").mkdir()

    def plug(self, name, usb, link=None):
        vendor, product, maker, words, serial = usb
        (self.root / "dev" / name).touch()
        device = self.root / f"sys/devices/usb1/{name}"
        (device / "tty").mkdir(parents=True)
        facts = {"idVendor": vendor, "idProduct": product, "manufacturer": maker}
        for key, value in (facts | {"product": words, "serial": serial}).items():
            (device / key).write_text(value + "\n")
        place = self.root / "sys/class/tty" / name
        place.mkdir(parents=True)
        (place / "device").symlink_to(device / "tty")
        if link:
            folder = self.root / "dev/serial/by-id"
            folder.mkdir(parents=True, exist_ok=True)
            (folder / link).symlink_to(self.root / "dev" / name)

    def _device(self, port):
        place = self.root / port.lstrip("/")
        if not place.exists():
            return None
        path = "/" + str(place.resolve().relative_to(self.root))
        return Device(path=path, is_terminal=True)


@pytest.fixture
def machine(tmp_path, monkeypatch):
    machine = Machine(tmp_path.resolve())
    monkeypatch.setattr("splinearm.cli.doctor.this_computer", lambda: machine.computer)
    return machine


def meant(*words, cell=None, announce=None, virtual=True):
    parser = argparse.ArgumentParser()
    add_port(parser, virtual=virtual)
    return port_of(parser.parse_args(words), cell, announce=announce)


def test_a_port_is_known_by_its_usb_identity_and_called_by_the_name_that_it_keeps(machine):
    machine.plug("ttyUSB0", U2D2, link="usb-ROBOTIS_U2D2_FT6S4EFP-if00")
    machine.plug("ttyACM3", MODEM)
    u2d2, modem = usb_ports(machine.computer)
    assert (u2d2.device, u2d2.serial, u2d2.kind) == ("/dev/ttyUSB0", "FT6S4EFP", "U2D2")
    assert u2d2.port == "/dev/serial/by-id/usb-ROBOTIS_U2D2_FT6S4EFP-if00"
    assert u2d2.is_adapter
    assert str(u2d2) == f"{u2d2.port} (U2D2, 0403:6014)"
    assert (modem.port, modem.by_id, modem.is_adapter) == ("/dev/ttyACM3", None, False)
    assert str(modem) == "/dev/ttyACM3 (a modem, 12d1:1001)"


def test_a_port_without_usb_behind_it_is_no_adapter(machine):
    (machine.root / "dev/ttyUSB7").touch()
    (port,) = usb_ports(machine.computer)
    assert (port.vendor, port.is_adapter, port.kind) == ("", False, "unknown device")


def test_the_only_adapter_is_meant_whatever_else_there_is_and_that_is_said(machine):
    machine.plug("ttyACM0", MODEM)
    machine.plug("ttyACM1", OPENRB)
    said = []
    assert meant(announce=said.append) == "/dev/ttyACM1"
    assert said == ["port: /dev/ttyACM1 (OpenRB-150, 2f5d:2202)"]


def test_the_usual_port_of_an_arm_comes_before_adapters_and_a_named_one_before_all(machine):
    cell = load_cell("omx_f")
    machine.plug("ttyUSB0", U2D2)
    assert meant(cell=cell) == "/dev/ttyUSB0"  # its usual one is not there
    machine.plug("ttyACM0", OPENRB)
    assert meant(cell=cell) == "/dev/ttyACM0"
    assert meant("--port", "unix:/x", cell=cell) == "unix:/x"
    assert meant("--on", "virtual", cell=cell) == "virtual"


def test_where_it_is_not_clear_the_ports_are_listed(machine):
    with pytest.raises(ConfigError, match=r"none is plugged in.*name the port, or use --on"):
        meant()
    with pytest.raises(ConfigError, match="usual port /dev/ttyACM0 is not there"):
        meant(cell=load_cell("omx_f"), virtual=False)
    machine.plug("ttyACM2", MODEM)
    with pytest.raises(ConfigError, match=r"none of these is known as one: /dev/ttyACM2"):
        meant()
    machine.plug("ttyUSB0", U2D2)
    machine.plug("ttyUSB1", U2D2)
    with pytest.raises(ConfigError, match=r"name one: /dev/ttyUSB0 \(U2D2, .*, /dev/ttyUSB1"):
        meant()
