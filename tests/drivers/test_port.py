import errno
import os
from pathlib import Path

import pytest

from splinearm.drivers.port import PortLock, by_id_link, latency_file, open_error, usb_latency
from splinearm.errors import PortError


def test_a_missing_port_is_named_with_what_to_do(tmp_path):
    with pytest.raises(PortError, match="no such port; plug the adapter in"):
        PortLock(str(tmp_path / "ttyUSB0"))


def test_a_file_is_no_serial_port(tmp_path):
    path = tmp_path / "notes"
    path.write_text("x")
    with pytest.raises(PortError, match="not a serial port"):
        PortLock(str(path))


@pytest.mark.bus
def test_a_forbidden_port_names_the_group_to_join(line):
    Path(line.port).chmod(0)
    user = os.geteuid()
    if user == 0:
        os.seteuid(65534)  # root may open anything
    try:
        with pytest.raises(PortError, match=r"sudo usermod -aG dialout \$USER"):
            PortLock(line.port)
    finally:
        os.seteuid(user)


@pytest.mark.bus
def test_a_port_in_use_is_refused_until_it_is_released(line):
    first = PortLock(line.port)
    with pytest.raises(PortError, match="another program uses it"):
        PortLock(line.port)
    first.release()
    first.release()
    PortLock(line.port).release()


@pytest.mark.parametrize(
    ("number", "reason"),
    [
        (errno.EBUSY, "another program"),
        (errno.EPERM, "may not open"),
        (errno.ENODEV, "no such port"),
        (errno.EINVAL, "Invalid argument"),
    ],
)
def test_what_the_system_says_is_put_in_words(number, reason):
    assert reason in open_error("/dev/ttyUSB0", OSError(number, os.strerror(number))).reason


def test_the_latency_of_an_adapter_is_read_from_the_kernel(tmp_path):
    assert latency_file("/dev/ttyUSB7") == Path("/sys/class/tty/ttyUSB7/device/latency_timer")
    path = tmp_path / "latency_timer"
    assert usb_latency(path) == 0.0
    path.write_text("16\n")
    assert usb_latency(path) == pytest.approx(0.016)


def test_a_link_to_a_port_is_followed(tmp_path):
    link = tmp_path / "ttyDXL"
    link.symlink_to("/dev/ttyUSB7")
    assert latency_file(str(link)) == latency_file("/dev/ttyUSB7")


def test_an_adapter_is_known_by_the_link_that_udev_keeps_for_it(tmp_path):
    device, other = tmp_path / "ttyUSB0", tmp_path / "ttyUSB1"
    folder = tmp_path / "by-id"
    folder.mkdir()
    for path in (device, other):
        path.touch()
    (folder / "usb-FTDI_A1-if00").symlink_to(device)
    assert by_id_link(str(device), folder) == folder / "usb-FTDI_A1-if00"
    assert by_id_link(str(other), folder) is None
    assert by_id_link(str(device), tmp_path / "none") is None
