"""``splinearm virtual-bus`` in a process of its own."""

import contextlib
import socket
import subprocess
import sys

import pytest

from splinearm.drivers.packets import Instruction, encode

pytestmark = pytest.mark.bus

PING = encode(1, Instruction.PING)


@pytest.fixture
def start():
    """Give a starter of the command; what it starts is ended."""
    started = []

    def run(*words: str) -> subprocess.Popen:
        command = [sys.executable, "-m", "splinearm", "virtual-bus", "koch_v1_1", *words]
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        started.append(process)
        return process

    yield run
    for process in started:
        process.kill()
        process.wait()
        for pipe in (process.stdin, process.stdout, process.stderr):
            with contextlib.suppress(OSError):
                pipe.close()


def port_of(process: subprocess.Popen) -> str:
    return process.stdout.readline().removeprefix("port: ").strip()


def ping(port: str) -> bytes:
    with socket.socket(socket.AF_UNIX) as wire:
        wire.settimeout(0.5)
        wire.connect(port.removeprefix("unix:"))
        wire.sendall(PING)
        try:
            return wire.recv(100)
        except TimeoutError:
            return b""


def order(process: subprocess.Popen, text: str) -> None:
    process.stdin.write(text + "\n")
    process.stdin.flush()


def test_a_socket_takes_orders_while_it_runs(start):
    bus = start("--transport", "socket", "--orders", "--until-eof")
    port = port_of(bus)
    assert port.startswith("unix:/")
    assert len(ping(port)) == 14
    order(bus, "dance")
    said = bus.stdout.readline()
    assert "want fault, clear, unplug or plug in, connect, disconnect or power, got 'dan" in said
    order(bus, "unplug")
    order(bus, "plug in")
    other = port_of(bus)
    assert other != port
    assert len(ping(other)) == 14
    order(bus, "fault dead id=1")
    order(bus, "?")
    bus.stdout.readline()
    assert ping(other) == b""
    order(bus, "clear")
    order(bus, "?")
    bus.stdout.readline()
    assert len(ping(other)) == 14
    bus.stdin.close()
    assert bus.wait(10) == 0


def test_faults_are_there_from_the_start(start):
    port = port_of(start("--transport", "socket", "--fault", "lost id=1 n=1", "--realtime"))
    assert ping(port) == b""
    assert len(ping(port)) == 14


def test_a_fault_that_there_is_not_is_refused(start):
    bus = start("--fault", "gone")
    said = bus.communicate(timeout=20)[1]
    assert bus.returncode == 2
    assert "--fault" in said


def test_cables_and_power_follow_orders(start):
    bus = start("--transport", "socket", "--orders", "--until-eof", "--fresh")
    port = port_of(bus)
    assert ping(port) == b""
    order(bus, "connect nobody")
    assert "no servo 'nobody'; there are shoulder_pan" in bus.stdout.readline()
    order(bus, "power off")
    bus.stdin.close()
    assert bus.wait(10) == 0
