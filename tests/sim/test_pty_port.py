import os

import pytest
import serial

from splinearm.sim.pty_port import PtyPort

pytestmark = pytest.mark.bus


@pytest.fixture
def port():
    made = PtyPort()
    yield made
    made.close()


def test_bytes_pass_unchanged_both_ways(port):
    every = bytes(range(256))
    with serial.Serial(port.name, 1_000_000, timeout=1.0) as client:
        client.write(every)
        got = b""
        while len(got) < 256:
            got += port.read(1.0)
        assert got == every
        port.write(every)
        assert client.read(256) == every


@pytest.mark.parametrize("baud", [9600, 57_600, 1_000_000, 3_000_000, 4_000_000])
def test_it_knows_the_baud_rate_that_the_client_set(port, baud):
    with serial.Serial(port.name, baud):
        assert port.baud == baud


def test_clients_come_and_go(port):
    for k in range(3):
        with serial.Serial(port.name, 57_600, timeout=1.0) as client:
            client.write(bytes((k,)))
            assert port.read(1.0) == bytes((k,))
    assert port.read(0.0) == b""


def test_what_nobody_fetches_is_lost_and_counted(port):
    chunk = bytes(1000)
    for _ in range(200):
        port.write(chunk)
    assert port.lost_bytes > 0


def test_a_waiting_read_can_be_woken(port):
    port.wake()
    assert port.read(60.0) == b""


def test_closed_it_is_gone():
    port = PtyPort()
    port.close()
    assert not os.path.exists(port.name)  # noqa: PTH110 - the name of a device
