import contextlib
import os
import socket
import stat
from pathlib import Path

import pytest

from splinearm.sim.socket_port import SocketPort

pytestmark = pytest.mark.bus


@pytest.fixture
def port():
    made = SocketPort(1_000_000)
    yield made
    made.close()


def opened(port: SocketPort) -> socket.socket:
    client = socket.socket(socket.AF_UNIX)
    client.settimeout(1.0)
    client.connect(port.name.removeprefix("unix:"))
    return client


def read(port: SocketPort, count: int) -> bytes:
    got = b""
    for _ in range(20):
        got += port.read(0.1)
        if len(got) >= count:
            break
    return got


def test_bytes_pass_unchanged_both_ways(port):
    every = bytes(range(256))
    with opened(port) as client:
        client.sendall(every)
        assert read(port, 256) == every
        port.write(every)
        assert client.recv(1000) == every


def test_its_folder_is_private_and_goes_with_it():
    port = SocketPort(57_600)
    path = Path(port.name.removeprefix("unix:"))
    assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700
    port.close()
    assert not path.parent.exists()


def test_clients_are_served_one_after_the_other(port):
    first, second = opened(port), opened(port)
    first.sendall(b"1")
    assert read(port, 1) == b"1"
    second.sendall(b"2")
    assert port.read(0.05) == b""
    first.close()
    assert read(port, 1) == b"2"
    second.close()


def test_a_pair_is_handed_out_and_served(port):
    with port.connect() as client:
        client.sendall(b"?")
        assert read(port, 1) == b"?"
        port.write(b"!")
        assert client.recv(10) == b"!"
    with opened(port) as other:
        other.sendall(b"next")
        assert read(port, 4) == b"next"


def test_what_nobody_fetches_is_lost_and_counted(port):
    port.write(b"nobody")
    assert port.lost_bytes == 6
    with port.connect():
        port.read(0.0)
        for _ in range(2000):
            port.write(bytes(1000))
        assert port.lost_bytes > 6


def test_a_client_that_has_left_is_no_error(port):
    client = port.connect()
    assert port.read(0.0) == b""
    client.close()
    port.write(b"late")
    assert port.read(0.1) == b""
    assert port.lost_bytes == 4


def test_a_waiting_read_can_be_woken(port):
    port.wake()
    assert port.read(60.0) == b""


def test_closed_its_clients_see_it_hang_up():
    port = SocketPort(1_000_000)
    clients = [opened(port), port.connect()]
    port.read(0.0)
    port.close()
    for client in clients:
        client.settimeout(1.0)
        with client, contextlib.suppress(ConnectionError):
            assert client.recv(1) == b""
    assert not os.path.exists(port.name.removeprefix("unix:"))  # noqa: PTH110 - it is gone
