"""``splinearm virtual-bus`` in a process of its own."""

import contextlib
import re
import signal
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


def said_by(process: subprocess.Popen) -> str:
    while (line := process.stdout.readline()).startswith("not permitted"):
        pass
    return line


def port_of(process: subprocess.Popen) -> str:
    return said_by(process).removeprefix("port: ").strip()


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


def test_a_terminal_is_a_port_on_which_servos_are_found_and_ctrl_c_ends_it(start, cli):
    bus = start()
    assert cli("scan", port_of(bus), "--baud", "1000000") == 0
    for word in ("XL330-M288", "XL430-W250", *"123456"):
        assert re.search(rf"\b{word}\b", cli.out)
    bus.send_signal(signal.SIGINT)
    assert bus.communicate(timeout=20)[1] == ""
    assert bus.returncode == 0


def test_a_socket_has_faults_and_takes_orders_while_it_runs(start):
    words = ("--transport", "socket", "--orders", "--until-eof", "--realtime")
    bus = start(*words, "--fault", "lost id=1 n=1")
    port = port_of(bus)
    assert port.startswith("unix:/")
    assert ping(port) == b""
    assert len(ping(port)) == 14
    order(bus, "dance")
    said = said_by(bus)
    assert "want fault, clear, unplug or plug in, connect, disconnect or power, got 'dan" in said
    order(bus, "unplug")
    order(bus, "plug in")
    other = port_of(bus)
    assert other != port
    assert len(ping(other)) == 14
    order(bus, "fault dead id=1")
    order(bus, "?")
    said_by(bus)
    assert ping(other) == b""
    order(bus, "clear")
    order(bus, "?")
    said_by(bus)
    assert len(ping(other)) == 14
    bus.stdin.close()
    assert bus.wait(10) == 0


def test_a_fault_that_there_is_not_is_refused(cli):
    assert cli("virtual-bus", "koch_v1_1", "--fault", "gone") == 2
    assert "--fault" in cli.err
    assert "want one of" in cli.err


def test_what_no_bus_can_have_is_refused_in_a_line_and_no_file_is_replaced(cli):
    file = cli.write("mine", "of value")
    assert cli("virtual-bus", "planar_2r", "--link", file) == 2
    assert cli.err == f"splinearm: --link: {file} is there and is no link; take another name\n"
    assert file.read_text(encoding="utf-8") == "of value"
    for late in ("nan", "-1", "1001"):
        assert cli("virtual-bus", "planar_2r", "--usb-latency-ms", late) == 2
        assert cli.err == f"splinearm: --usb-latency-ms: wants 0 to 1000 ms, got {late}\n"


def test_cables_and_power_follow_orders(start):
    bus = start("--transport", "socket", "--orders", "--until-eof", "--fresh")
    port = port_of(bus)
    assert ping(port) == b""
    order(bus, "connect nobody")
    assert "no servo 'nobody'; there are shoulder_pan" in said_by(bus)
    order(bus, "power off")
    bus.stdin.close()
    assert bus.wait(10) == 0
