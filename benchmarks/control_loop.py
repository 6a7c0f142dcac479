"""Does the loop keep its time beside busy programs? At 1 kHz under SCHED_FIFO, and without it.

Six joints of virtual servos at 4 Mbit/s in a process of their own, over a unix socket; two
processes that only burn time beside them; every cycle is read, checked, written and logged to a
CSV file. Without SCHED_FIFO the loop finds out in half a second which rate it can hold, and holds
it or not. Run it with nothing else on the computer: ``python benchmarks/control_loop.py``; for a
shorter look add ``--seconds 5``.
"""

import argparse
import datetime
import multiprocessing
import os
import platform
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
from kinematics_forward import processor

from splinearm.backends import centred
from splinearm.config import load_cell
from splinearm.control.clock import WallClock
from splinearm.control.follow import Loop
from splinearm.control.guard import Guard
from splinearm.control.realtime import SPIN, Footing, real_time
from splinearm.control.record import Recorder
from splinearm.control.rehearsal import UNSEEN_AMONG, UNSEEN_FIRST, rehearse
from splinearm.control.report import LoopReport, report_loop
from splinearm.drivers.dynamixel import DynamixelBus
from splinearm.drivers.servo_arm import ServoArm
from splinearm.errors import MotionError
from splinearm.joints import JointLimits
from splinearm.sim.virtual_bus import VirtualBus
from splinearm.trajectories.plan import plan_joint_move
from splinearm.trajectories.trajectory import JointTrajectory

ARM = "wx250s"
BAUD = 4_000_000
MARGIN = 0.012


def burn() -> None:
    """Do nothing useful for ever."""
    while True:
        sum(range(10_000))


@contextmanager
def neighbours(count: int) -> Iterator[None]:
    """Keep the computer busy."""
    busy = [multiprocessing.Process(target=burn, daemon=True) for _ in range(count)]
    for process in busy:
        process.start()
    try:
        yield
    finally:
        for process in busy:
            process.kill()
            process.join()


def serve(answer: Connection) -> None:
    """Serve the virtual servos until told to stop."""
    cell = load_cell(ARM)
    chain = replace(centred(cell.chain), baud=BAUD)
    with VirtualBus(cell.arm, chain, cell.poses["home"], transport="socket", realtime=True) as bus:
        answer.send(bus.port)
        answer.recv()


@contextmanager
def virtual_bus() -> Iterator[str]:
    """Give the port of virtual servos in another process."""
    near, far = multiprocessing.Pipe()
    process = multiprocessing.Process(target=serve, args=(far,))
    process.start()
    try:
        yield near.recv()
    finally:
        near.send("end")
        process.join()


def there_and_back(arm: ServoArm, limits: JointLimits, seconds: float) -> JointTrajectory:
    """Give a motion of about that time, of moves there and back."""
    there = plan_joint_move(limits, arm.goal, arm.goal + 0.3)
    back = plan_joint_move(limits, arm.goal + 0.3, arm.goal)
    rounds = max(1, round(seconds / (there.duration + back.duration)))
    sections = (*there.sections, *back.sections) * rounds
    return JointTrajectory(sections, there.q_start, limits)


def run(port: str, rate: float, seconds: float, *, fifo: bool) -> tuple[LoopReport, Footing, str]:
    """Follow a motion; give how well its time was kept."""
    cell = load_cell(ARM)
    chain = replace(centred(cell.chain), baud=BAUD)
    names, limits = cell.arm.joint_names, cell.arm.limits
    bus, clock, note = DynamixelBus(port, BAUD, margin=MARGIN), WallClock(), ""
    footing = Footing(fifo=False, locked=False)
    with (
        tempfile.TemporaryDirectory() as folder,
        ServoArm(chain, names, limits, bus, watchdog=0.04 if fifo else 0.1) as arm,
        Recorder(names, limits.kinds, Path(folder) / "rows.csv") as recorder,
        real_time() if fifo else nullcontext(footing) as footing,
    ):
        motion = there_and_back(arm, limits.scaled(0.3), seconds)
        clock.spin = SPIN if footing.fifo else 0.0
        tried = rehearse(clock, 1.0 / rate, arm.read)
        possible = tried.rate(rate, UNSEEN_FIRST if footing.fifo else UNSEEN_AMONG)
        named = "none" if possible is None else f"{possible:g} Hz"
        note = f"named {named} for {rate:g} (late {1e6 * tried.lateness.max():.0f} us at most)"
        if not fifo:
            rate = possible or 20.0
        loop = Loop(
            driver=arm, clock=clock, guard=Guard(limits), period=1.0 / rate, observe=recorder
        )
        try:
            loop.follow(motion)
        except MotionError as error:
            note += f"; stopped: {error}"
    return report_loop(recorder.cycles, 1.0 / rate), footing, note


def hiccups(seconds: float) -> list[float]:
    """Give the pauses, in s, that nothing of this system can make: of a thread before all others.

    On a rented computer the host takes the processor away, often in steps of its own.
    """
    pauses = []
    with real_time(98) as footing:
        end = time.monotonic() + (seconds if footing.fifo else 0.0)
        while (begun := time.monotonic()) < end:
            last = begun
            while last < begun + 4e-4:
                now = time.monotonic()
                if now - last > 2e-4:
                    pauses.append(now - last)
                last = now
            time.sleep(5e-4)
    return pauses


def row(name: str, report: LoopReport, lateness: np.ndarray | None = None) -> str:
    """Give a line of the table."""
    late, busy = report.lateness, report.busy
    return (
        f"{name:<12}{report.rate:7.0f} {report.cycles:8d} {report.missed:7d} "
        f"{report.unanswered:11d} {late.p99 * 1e6:9.1f} {late.worst * 1e6:9.1f} "
        f"{busy.p99 * 1e6:9.1f} {busy.worst * 1e6:9.1f}"
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0, help="how long each run lasts")
    parser.add_argument("--busy", type=int, default=2, help="how many processes burn time")
    args = parser.parse_args()
    print(f"{processor()}, {os.cpu_count()} cores, {platform.system()} {platform.release()}")
    print(f"{datetime.date.today()}, Python {platform.python_version()}")
    print(f"load before: {os.getloadavg()[0]:.1f}; {args.busy} busy processes beside it")
    print(f"{ARM}, 6 joints, 9 servos, {BAUD / 1e6:g} Mbit/s, every cycle logged to CSV\n")
    print(
        f"{'':<12}{'Hz':>7} {'cycles':>8} {'missed':>7} {'unanswered':>11} "
        f"{'late p99':>9} {'max us':>9} {'busy p99':>9} {'max us':>9}"
    )
    with neighbours(args.busy):
        pauses = hiccups(args.seconds / 6.0)
    notes = [
        f"the computer itself stopped a thread of priority 98 for more than 0.2 ms {len(pauses)} "
        f"times in {args.seconds / 6.0:.0f} s, for {1e3 * max(pauses, default=0.0):.2f} ms at most"
    ]
    with virtual_bus() as port:
        for fifo in (True, False):
            with neighbours(args.busy):
                time.sleep(0.5)
                report, footing, note = run(port, 1000.0, args.seconds, fifo=fifo)
            name = "SCHED_FIFO" if footing.fifo else "normal"
            print(row(name, report))
            notes.append(f"{name}: {note}; {footing.words}")
    print("\n" + "\n".join(notes))
    print(f"load after: {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
