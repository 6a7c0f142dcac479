"""How near the cyclic path comes to what the wire allows, beside the maker's SDK.

Six servos on the virtual bus, which gives every byte its time on the wire, in a process of its own.
A cycle writes six goals (4 bytes) and reads six times current, velocity and position (10 bytes).
The clients run one after the other on the same bus, quiet and with two busy processes beside them.
Bus and clients run under SCHED_FIFO where that is permitted (``--fair``: the clients do not). CPU
is that of the client's process. Run::

    python benchmarks/drivers_wire.py

Wanted: 95 % of what the wire allows at 1 Mbps, 90 % at 4 Mbps; CPU 100 us a cycle, 50 with fastcrc.
"""

import argparse
import contextlib
import dataclasses
import datetime
import importlib.util
import multiprocessing
import os
import platform
import statistics
import time
from collections.abc import Callable, Iterator

import numpy as np
from kinematics_forward import imported, processor

from splinearm.config import load_cell
from splinearm.drivers.chain import ServoChain, ServoRole
from splinearm.drivers.model import servo_model
from splinearm.errors import BusError

ARM = "wx250s"
TABLE = servo_model("XM430-W350").table
GOAL, MOTION, MOTION_BYTES = TABLE["Goal Position"].address, 126, 10
BUS_PRIORITY, CLIENT_PRIORITY = 60, 50
WARM_UP = 50
WANTED = {1_000_000: 0.95, 4_000_000: 0.90}
WANTED_CPU = 50.0 if importlib.util.find_spec("fastcrc") else 100.0

Result = tuple[float, float, float]
"""Median and 99th percentile of the cycle and CPU time a cycle, us."""


def six_servos(baud: int) -> ServoChain:
    """Give the six leaders of the arm, which answer without delay."""
    servos = []
    for servo in load_cell(ARM).chain.servos:
        if servo.role is ServoRole.LEADER:
            settings = {**servo.settings, "Return Delay Time": 0}
            zero = 2048 if servo.zero_ticks is None else servo.zero_ticks
            servos.append(dataclasses.replace(servo, settings=settings, zero_ticks=zero))
    return ServoChain(servos=tuple(servos), baud=baud)


def wire_time(baud: int, n: int, *, fast: bool) -> float:
    """Give how long a cycle's bytes are on the wire, us."""
    sent = (14 + 5 * n) + (14 + n)
    back = 8 + n * (4 + MOTION_BYTES) if fast else n * (11 + MOTION_BYTES)
    return (sent + back) * 10 / baud * 1e6


def go_first(priority: int) -> bool:
    """Run under SCHED_FIFO if that is permitted."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except (OSError, AttributeError):
        return False
    return True


def serve(baud: int, transport: str, pipe: "multiprocessing.connection.Connection") -> None:
    """Serve the virtual bus until told to end."""
    from splinearm.sim.virtual_bus import VirtualBus

    chain = six_servos(baud)
    with VirtualBus(load_cell(ARM).arm, chain, transport=transport, realtime=True) as bus:
        pipe.send(bus.port)
        pipe.recv()


def ours(port: str, baud: int, *, fast: bool) -> Iterator[Callable[[], None]]:
    """Give a cycle of our own."""
    from splinearm.drivers.crew import Crew
    from splinearm.drivers.dynamixel import DynamixelBus
    from splinearm.drivers.exchange import Exchange
    from splinearm.drivers.scaling import JointScale

    chain = six_servos(baud)
    crew = Crew.of(chain, load_cell(ARM).arm.joint_names)
    with DynamixelBus(port, baud) as bus:
        roll = {reply.servo_id: reply for reply in bus.scan()}
        if not fast:
            roll = {i: reply._replace(firmware=1) for i, reply in roll.items()}
        exchange = Exchange(bus, crew, roll, JointScale.of(crew.targets))
        exchange.lay_out()
        ticks = np.full(6, 2048)

        def cycle() -> None:
            exchange.write(ticks)
            with contextlib.suppress(BusError):
                exchange.read()

        yield cycle
        lost = max(s.timeouts + s.crc_errors for s in exchange.stats.values())
        if lost:
            print(f"    in {lost} cycles an answer came more than 8 ms late")


def sdk(port: str, baud: int, *, fast: bool) -> Iterator[Callable[[], None]]:
    """Give a cycle of the maker's SDK."""
    import dynamixel_sdk as maker

    handler, packets = maker.PortHandler(port), maker.PacketHandler(2.0)
    handler.setBaudRate(baud)
    ids = [servo.servo_id for servo in six_servos(baud).servos]
    writer = maker.GroupSyncWrite(handler, packets, GOAL, 4)
    reader = maker.GroupSyncRead(handler, packets, MOTION, MOTION_BYTES)
    for servo_id in ids:
        reader.addParam(servo_id)
    goal = list((2048).to_bytes(4, "little"))

    def cycle() -> None:
        writer.clearParam()
        for servo_id in ids:
            writer.addParam(servo_id, goal)
        writer.txPacket()
        (reader.fastSyncRead if fast else reader.txRxPacket)()
        for servo_id in ids:
            for address, size in ((126, 2), (128, 4), (132, 4)):
                reader.getData(servo_id, address, size)

    yield cycle
    handler.closePort()


def run(
    client: str,
    port: str,
    baud: int,
    fast: bool,  # noqa: FBT001 - the target of a process
    args: argparse.Namespace,
    pipe: "multiprocessing.connection.Connection",
) -> None:
    """Run cycles and tell how long they took."""
    cycles = args.cycles
    if not args.fair:
        go_first(CLIENT_PRIORITY)
    with contextlib.contextmanager(globals()[client])(port, baud, fast=fast) as cycle:
        for _ in range(WARM_UP):
            cycle()
        times = np.empty(cycles + 1)
        cpu = time.process_time_ns()
        for k in range(cycles + 1):
            times[k] = time.perf_counter()
            cycle()
        cpu = time.process_time_ns() - cpu
    took = np.diff(times) * 1e6
    p99 = float(np.percentile(took, 99))
    pipe.send((float(np.median(took)), p99, cpu / (cycles + 1) * 1e-3))


def spin() -> None:
    """Be busy."""
    while True:
        pass


@contextlib.contextmanager
def process(target: Callable[..., None], *args: object) -> Iterator["multiprocessing.Process"]:
    """Run a process beside the block and end it afterwards."""
    child = multiprocessing.get_context("spawn").Process(target=target, args=args, daemon=True)
    child.start()
    try:
        yield child
    finally:
        child.terminate()
        child.join()


def measured(
    client: str, port: str, baud: int, args: argparse.Namespace, *, fast: bool
) -> Result | None:
    """Run a client in a process of its own; None if it fails."""
    here, there = multiprocessing.Pipe()
    with process(run, client, port, baud, fast, args, there):
        if here.poll(60.0):
            with contextlib.suppress(EOFError):
                return here.recv()
    return None


def compare(transport: str, baud: int, clients: list[str], args: argparse.Namespace) -> None:
    """Print a row for each client, quiet or busy as it is."""
    here, there = multiprocessing.Pipe()
    with process(serve, baud, transport, there):
        port = here.recv()
        for fast in (False, True):
            limit = wire_time(baud, 6, fast=fast)
            for client in clients:
                results = [
                    measured(client, port, baud, args, fast=fast) for _ in range(args.rounds)
                ]
                good = [result for result in results if result is not None]
                read = "fast" if fast else "sync"
                head = f"  {transport:6} {baud / 1e6:g} Mbps {read}  {limit:6.0f} us  {client:5}"
                if not good:
                    print(f"{head} failed", flush=True)
                    continue
                middle, p99, cpu = (statistics.median(column) for column in zip(*good, strict=True))
                share = limit / middle
                met = share >= WANTED[baud] and cpu <= WANTED_CPU
                print(
                    f"{head}{middle:8.0f} us {share:6.1%}   p99{p99:8.0f} us   CPU{cpu:7.0f} us"
                    f"{'' if client == 'sdk' else '   met' if met else '   NOT MET'}",
                    flush=True,
                )
        here.send("end")


def main() -> None:
    """Print where and when, then a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cycles", type=int, default=400)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--busy", choices=("no", "yes", "both"), default="both")
    parser.add_argument("--transport", choices=("pty", "socket", "both"), default="both")
    parser.add_argument("--fair", action="store_true", help="clients without SCHED_FIFO")
    args = parser.parse_args()
    print(f"{datetime.datetime.now(tz=datetime.UTC):%Y-%m-%d %H:%M} UTC, {platform.platform()}")
    print(f"{processor()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    imported("fastcrc")
    clients = ["ours", *(["sdk"] if imported("dynamixel_sdk") else [])]
    for busy in (False, True):
        if args.busy == ("no" if busy else "yes"):
            continue
        with contextlib.ExitStack() as beside:
            for _ in range(2 * busy):
                beside.enter_context(process(spin))
            print("with two busy processes" if busy else "quiet")
            for transport in ("pty", "socket"):
                if args.transport in (transport, "both"):
                    for baud in WANTED:
                        # the SDK opens only what is a terminal
                        compare(transport, baud, clients if transport == "pty" else ["ours"], args)


if __name__ == "__main__":
    main()
