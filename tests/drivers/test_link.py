import os
import socket
import threading
import time

import pytest

from splinearm.drivers.link import RETURN_DELAY, SerialLink, SocketLink, is_socket
from splinearm.errors import PortError

pytestmark = pytest.mark.bus


@pytest.fixture
def ends():
    """Both ends of a pty: ours, not blocking, and the other."""
    other, ours = os.openpty()
    import tty

    tty.setraw(ours)
    os.set_blocking(ours, False)
    yield ours, other
    for fd in (ours, other):
        os.close(fd)


def link(fd: int, margin: float = 0.2) -> SerialLink:
    return SerialLink("/dev/ttyX", fd, 1_000_000, margin)


def test_the_deadline_is_what_the_wire_needs_and_the_margin(ends):
    one = link(ends[0])
    before = time.monotonic()
    deadline = one.send(bytes(100), answers=3, answer_bytes=200)
    wait = 300 * 10 / 1_000_000 + 3 * RETURN_DELAY + 0.2
    assert before + wait <= deadline <= time.monotonic() + wait
    assert os.read(ends[1], 200) == bytes(100)


def test_bytes_are_collected_until_there_are_enough(ends):
    ours, other = ends
    one = link(ours)

    def trickle():
        for byte in b"abcdef":
            os.write(other, bytes((byte,)))

    thread = threading.Thread(target=trickle)
    deadline = one.deadline() + 5.0
    thread.start()
    assert one.receive(6, deadline) == b"abcdef"
    thread.join()
    assert time.monotonic() < deadline - 4.0


def test_waiting_ends_at_the_deadline_with_what_came(ends):
    ours, other = ends
    one = link(ours, margin=0.01)
    os.write(other, b"abc")
    assert one.receive(6, time.monotonic() + 0.05) == b"abc"
    assert one.receive_some(time.monotonic() + 0.01) == b""
    assert one.receive_some(time.monotonic() - 1.0) == b""


def test_what_came_unasked_is_thrown_away_before_a_packet_is_sent(ends):
    ours, other = ends
    one = link(ours)
    os.write(other, b"late")
    assert one.receive_some(one.deadline()) == b"late"
    os.write(other, b"later")
    while not one._poll.poll(100):
        pass
    deadline = one.send(b"ask")
    os.write(other, b"answer")
    assert one.receive(6, deadline) == b"answer"


def test_a_long_packet_waits_for_room(ends):
    ours, other = ends
    one = link(ours, margin=2.0)
    data = bytes(range(256)) * 64
    got = bytearray()

    def drain():
        while len(got) < len(data):
            got.extend(os.read(other, 4096))

    thread = threading.Thread(target=drain)
    thread.start()
    one.send(data)
    thread.join()
    assert got == data


def test_a_port_without_room_for_long_is_told(ends):
    one = link(ends[0], margin=0.01)
    with pytest.raises(PortError, match="connection is lost"):
        one.send(bytes(100_000))


def test_a_closed_link_is_told(ends):
    one = link(ends[0])
    one.close()
    one.close()
    with pytest.raises(PortError, match="connection is lost"):
        one.send(b"x")
    with pytest.raises(PortError, match="connection is lost"):
        one.receive_some(one.deadline())


@pytest.fixture
def listener(tmp_path):
    """A socket that somebody listens on."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as one:
        one.bind(str(tmp_path / "bus"))
        one.listen()
        yield one


def test_a_socket_is_a_port_too(listener):
    path = listener.getsockname()
    one = SocketLink(f"unix:{path}", 1_000_000, 0.2)
    other, _ = listener.accept()
    other.sendall(b"late")
    time.sleep(0.01)
    deadline = one.send(b"ask")
    assert other.recv(16) == b"ask"
    other.sendall(b"answer")
    assert one.receive(6, deadline) == b"answer"
    assert one.receive_some(time.monotonic() + 0.01) == b""
    other.close()
    with pytest.raises(PortError, match="connection is lost"):
        one.receive_some(one.deadline())
    one.close()
    one.close()
    with pytest.raises(PortError, match="connection is lost"):
        one.send(b"ask")


def test_a_socket_that_nobody_serves_is_told(tmp_path):
    with pytest.raises(PortError, match="nobody serves it"):
        SocketLink(f"unix:{tmp_path}/none", 1_000_000, 0.2)


def test_sockets_are_known_by_name_or_by_what_they_are(listener, tmp_path):
    path = listener.getsockname()
    link_to = tmp_path / "arm"
    link_to.symlink_to(path)
    assert is_socket(f"unix:{path}")
    assert is_socket(path)
    assert is_socket(str(link_to))
    assert not is_socket("/dev/null")
    assert not is_socket(str(tmp_path / "none"))
