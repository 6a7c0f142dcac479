"""The maker's SDK, unmodified and in a process of its own, drives the bus like hardware.

It does everything that the SDK offers, in both protocols. What it sends is never stuffed, so that
values which need stuffing are left out here.
"""

import subprocess
import sys

import pytest

from splinearm.drivers.chain import ServoChain, ServoRole, ServoSpec
from splinearm.sim.virtual_bus import VirtualBus

pytestmark = pytest.mark.bus

Q_START = (0.4, -0.3)

COMMON = """
import sys
import time

import dynamixel_sdk as sdk

OK = sdk.COMM_SUCCESS
port, client = sdk.PortHandler(sys.argv[1]), sdk.PacketHandler(PROTOCOL)
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


def eventually(servo):
    "Wait until a servo that reboots is back."
    for _ in range(60):
        if client.ping(port, servo)[1] == OK:
            return
    raise AssertionError("it stays away")


def apart(send, receive):
    "Send and receive with two calls, as often as it needs."
    for _ in range(20):
        assert send() == OK
        answer = receive()
        if answer[-2] == OK:
            return answer
    raise AssertionError(answer)


def small(servo, address, size):
    "Read with a call made for the size, sent and received apart and at once."
    whole = {1: client.read1ByteTxRx, 2: client.read2ByteTxRx, 4: client.read4ByteTxRx}[size]
    send = {1: client.read1ByteTx, 2: client.read2ByteTx, 4: client.read4ByteTx}[size]
    receive = {1: client.read1ByteRx, 2: client.read2ByteRx, 4: client.read4ByteRx}[size]
    answer = patient(lambda: whole(port, servo, address))
    assert apart(lambda: send(port, servo, address), lambda: receive(port, servo)) == answer
    data = patient(lambda: client.readTxRx(port, servo, address, size))[0]
    assert int.from_bytes(bytes(data), "little") == answer[0]
    data = apart(
        lambda: client.readTx(port, servo, address, size),
        lambda: client.readRx(port, servo, size),
    )[0]
    assert int.from_bytes(bytes(data), "little") == answer[0]
    return answer[0]


def put(servo, address, size, value):
    "Write with a call made for the size, with and without waiting for the answer."
    whole = {1: client.write1ByteTxRx, 2: client.write2ByteTxRx, 4: client.write4ByteTxRx}[size]
    only = {1: client.write1ByteTxOnly, 2: client.write2ByteTxOnly, 4: client.write4ByteTxOnly}
    assert patient(lambda: whole(port, servo, address, value)) == (OK, 0)
    assert only[size](port, servo, address, value) == OK
    time.sleep(0.01)
    data = list(value.to_bytes(size, "little"))
    assert patient(lambda: client.writeTxRx(port, servo, address, size, data)) == (OK, 0)
    assert client.writeTxOnly(port, servo, address, size, data) == OK
    time.sleep(0.01)
    assert small(servo, address, size) == value


def registered(servo, address, value, at):
    "Keep a write for an action, in both ways."
    for keep in (client.regWriteTxRx, client.regWriteTxOnly):
        for _ in range(20):
            kept = keep(port, servo, address, 2, list(value.to_bytes(2, "little")))
            time.sleep(0.01)
            if kept in (OK, (OK, 0)) and small(servo, at, 1) == 1:
                break
        assert client.action(port, sdk.BROADCAST_ID) == OK
        time.sleep(0.01)
        assert small(servo, address, 2) == value
        value += 1


def sync_write(address, size, values):
    writer = sdk.GroupSyncWrite(port, client, address, size)
    for servo, value in values.items():
        assert writer.addParam(servo, [0] * size)
        assert writer.changeParam(servo, list(value.to_bytes(size, "little")))
    assert writer.txPacket() == OK
    time.sleep(0.01)
    for servo, value in values.items():
        assert int.from_bytes(bytes(patient(
            lambda: client.readTxRx(port, servo, address, size))[0]), "little") == value
"""

CLIENT_2 = (
    "PROTOCOL = 2.0\n"
    + COMMON
    + """
TORQUE, GOAL, PRESENT = 64, 116, 132

# finding
assert patient(lambda: client.ping(port, 1))[0] == 1020
for _ in range(3):
    found, result = client.broadcastPing(port)
    if result == OK and sorted(found) == [1, 2]:
        break
assert sorted(found) == [1, 2], found

# reading and writing
assert small(2, 7, 1) == 2 and small(2, 144, 2) == 120
put(1, 65, 1, 1)
put(1, 84, 2, 640)
put(1, 112, 4, 300)
assert patient(lambda: client.write4ByteTxRx(port, 1, GOAL, 4096)) == (OK, 6)
registered(1, 84, 641, 69)
assert client.getRxPacketError(6) != "" and client.getTxRxResult(OK) != ""

# groups
for servo in (1, 2):
    assert patient(lambda: client.write1ByteTxRx(port, servo, TORQUE, 1)) == (OK, 0)
goals = {1: 2000, 2: 2100}
sync_write(GOAL, 4, goals)
time.sleep(0.8)
reader = sdk.GroupSyncRead(port, client, PRESENT, 4)
for servo in goals:
    reader.addParam(servo)
for read in (reader.txRxPacket, reader.fastSyncRead):
    wait(read)
    for servo, goal in goals.items():
        assert reader.isAvailable(servo, PRESENT, 4)
        assert abs(reader.getData(servo, PRESENT, 4) - goal) <= 12, (read, servo)
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

# starting anew
assert patient(lambda: client.write1ByteTxRx(port, 1, TORQUE, 0)) == (OK, 0)
assert patient(lambda: client.write1ByteTxRx(port, 1, 11, 4)) == (OK, 0)
assert patient(lambda: client.clearMultiTurn(port, 1)) == (OK, 0)
assert client.reboot(port, 1)[1] == 0
eventually(1)
assert small(1, 65, 1) == 0 and small(1, 11, 1) == 4
assert client.factoryReset(port, 1, 0x02)[1] == 0
eventually(1)
assert small(1, 11, 1) == 3
port.closePort()
print("all is well")
"""
)

CLIENT_1 = (
    "PROTOCOL = 1.0\n"
    + COMMON
    + """
AX_GOAL, AX_PRESENT, X_TORQUE, X_GOAL, X_PRESENT = 30, 36, 64, 116, 132

# finding: 1 is an AX-12A, 2 and 3 are XM430 that speak Protocol 1.0
assert [patient(lambda: client.ping(port, k))[0] for k in (1, 2, 3)] == [12, 1020, 1020]
assert client.ping(port, 4)[1] == sdk.COMM_RX_TIMEOUT
assert client.broadcastPing(port)[1] == sdk.COMM_NOT_AVAILABLE
assert client.reboot(port, 2)[0] == sdk.COMM_NOT_AVAILABLE

# reading and writing
assert small(1, 3, 1) == 1 and small(1, 16, 1) == 2 and small(2, 7, 1) == 2
assert abs(small(1, AX_PRESENT, 2) - 512) < 200
put(1, 25, 1, 1)
put(1, AX_GOAL, 2, 500)
put(2, 112, 4, 300)
put(2, 84, 2, 640)
assert patient(lambda: client.write4ByteTxRx(port, 2, X_GOAL, 4096)) == (OK, 2)
assert patient(lambda: client.write2ByteTxRx(port, 1, AX_PRESENT, 5)) == (OK, 8)
registered(1, AX_GOAL, 510, 44)
registered(2, 84, 641, 69)
assert client.getRxPacketError(0x24) != "" and client.getTxRxResult(OK) != ""

# groups
for servo in (2, 3):
    assert patient(lambda: client.write1ByteTxRx(port, servo, X_TORQUE, 1)) == (OK, 0)
sync_write(X_GOAL, 4, {2: 2000, 3: 2100})
time.sleep(0.8)
# GroupBulkRead of SDK 4.1 calls this with an argument too many in Protocol 1.0 (TypeError)
for _ in range(20):
    assert client.bulkReadTx(port, [4, 2, X_PRESENT, 4, 3, X_GOAL], 6) == OK
    first, second = client.readRx(port, 2, 4), client.readRx(port, 3, 4)
    if (first[1], second[1]) == (OK, OK):
        break
assert abs(int.from_bytes(bytes(first[0]), "little") - 2000) <= 12, first
assert int.from_bytes(bytes(second[0]), "little") == 2100, second

# starting anew: the id goes too
assert client.factoryReset(port, 1)[1] == 0
eventually(1)
assert small(1, 25, 1) == 0
port.closePort()
print("all is well")
"""
)


def run(client: str, bus: VirtualBus) -> None:
    done = subprocess.run(
        [sys.executable, "-c", client, bus.port],
        capture_output=True,
        text=True,
        timeout=90,
        check=False,
    )
    assert done.stdout == "all is well\n", done.stderr


@pytest.mark.parametrize("wire_time", [True, False])
def test_the_sdk_does_all_it_can_in_protocol_2(make_arm, make_chain, wire_time):
    with VirtualBus(make_arm(2), make_chain(2), Q_START, wire_time=wire_time) as bus:
        run(CLIENT_2, bus)


@pytest.mark.parametrize("wire_time", [True, False])
def test_the_sdk_does_all_it_can_in_protocol_1(make_arm, wire_time):
    def spec(k: int, model: str, **settings: int) -> ServoSpec:
        return ServoSpec(
            name=f"s{k}",
            servo_id=k + 1,
            model=model,
            role=ServoRole.LEADER,
            joint=f"j{k}",
            settings={"Return Delay Time": 0, **settings},
        )

    x = {"Protocol Type": 1}
    servos = (spec(0, "AX-12A"), spec(1, "XM430-W350", **x), spec(2, "XM430-W350", **x))
    chain = ServoChain(servos=servos, baud=1_000_000)
    with VirtualBus(make_arm(3), chain, wire_time=wire_time) as bus:
        run(CLIENT_1, bus)
