"""The maker's SDK, unmodified and in a process of its own, drives the bus like hardware."""

import subprocess
import sys

import pytest

from splinearm.sim.virtual_bus import VirtualBus

pytestmark = pytest.mark.bus

Q_START = (0.4, -0.3)

CLIENT = """
import sys
import time

import dynamixel_sdk as sdk

OK = sdk.COMM_SUCCESS
TORQUE, GOAL, PRESENT = 64, 116, 132
port, client = sdk.PortHandler(sys.argv[1]), sdk.PacketHandler(2.0)
assert port.openPort() and port.setBaudRate(1_000_000)


def patient(call):
    "A pseudo terminal may be late by some milliseconds on a busy computer: ask again."
    for _ in range(20):
        answer = call()
        if answer[-2] == OK:
            return answer
    raise AssertionError(answer)


def wait(call):
    for _ in range(20):
        if call() == OK:
            return
    raise AssertionError("no answer")


# ping
assert patient(lambda: client.ping(port, 1))[0] == 1020
found, result = client.broadcastPing(port)
assert result == OK and sorted(found) == [1, 2], found

# read and write
assert patient(lambda: client.read1ByteTxRx(port, 2, 7)) == (2, OK, 0)
assert patient(lambda: client.write1ByteTxRx(port, 1, 65, 1)) == (OK, 0)
assert patient(lambda: client.read1ByteTxRx(port, 1, 65))[0] == 1
assert patient(lambda: client.write4ByteTxRx(port, 1, GOAL, 4096)) == (OK, 6)

# sync write, sync read, fast sync read
for servo in (1, 2):
    assert patient(lambda: client.write1ByteTxRx(port, servo, TORQUE, 1)) == (OK, 0)
goals = {1: 2000, 2: 2100}
writer = sdk.GroupSyncWrite(port, client, GOAL, 4)
for servo, goal in goals.items():
    writer.addParam(servo, list(goal.to_bytes(4, "little")))
assert writer.txPacket() == OK
time.sleep(0.8)
reader = sdk.GroupSyncRead(port, client, PRESENT, 4)
for servo in goals:
    reader.addParam(servo)
for read in (reader.txRxPacket, reader.fastSyncRead):
    wait(read)
    for servo, goal in goals.items():
        assert reader.isAvailable(servo, PRESENT, 4)
        assert abs(reader.getData(servo, PRESENT, 4) - goal) <= 12, (read, servo)

# bulk write, bulk read, fast bulk read
writer = sdk.GroupBulkWrite(port, client)
writer.addParam(1, 65, 1, [0])
writer.addParam(2, GOAL, 4, list((2048).to_bytes(4, "little")))
assert writer.txPacket() == OK
bulk = sdk.GroupBulkRead(port, client)
bulk.addParam(1, 65, 1)
bulk.addParam(2, GOAL, 4)
for read in (bulk.txRxPacket, bulk.fastBulkRead):
    wait(read)
    assert bulk.getData(1, 65, 1) == 0
    assert bulk.getData(2, GOAL, 4) == 2048
port.closePort()
print("all is well")
"""


@pytest.mark.parametrize("wire_time", [True, False])
def test_the_sdk_finds_what_it_finds_on_servos(make_arm, make_chain, wire_time):
    with VirtualBus(make_arm(2), make_chain(2), Q_START, wire_time=wire_time) as bus:
        client = subprocess.run(
            [sys.executable, "-c", CLIENT, bus.port],
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
    assert client.stdout == "all is well\n", client.stderr
