"""How well virtual servos follow, without and with feed-forward, and beside their own profile.

Two tables. The first has a clock of its own, so that no neighbour disturbs it: the jobs of the
examples on virtual servos with the makers' gains, setpoints every 10 ms that reach the servos 2 ms
after they were due. The second is the real thing: ``splinearm run --on virtual``, the bus in a
process of its own, bytes that take their time at 1 Mbps, and whatever else the machine does.

``own profile`` rows let each servo interpolate between goals: Drive Mode "time-based", Profile
Velocity one cycle, the Feedforward 1st Gain that makes up for the motor's back EMF; weight and
rotors by goals that are ahead, as in ``full``.

    python benchmarks/drivers_feedforward.py            # some seconds
    python benchmarks/drivers_feedforward.py --realtime # a minute more
"""

import datetime
import math
import os
import platform
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from kinematics_forward import processor, shortest

from splinearm.backends import centred, open_arm, require_chain
from splinearm.config import Cell, load_cell, load_job
from splinearm.drivers.chain import ServoChain, ServoSpec
from splinearm.drivers.dynamixel import DynamixelBus
from splinearm.drivers.feedforward import ServoFeedforward
from splinearm.drivers.feedforward_drive import column, joint_drives, stall_at
from splinearm.drivers.servo_arm import ServoArm
from splinearm.joints import JointSetpoint
from splinearm.kinematics.dynamics import Dynamics
from splinearm.runner import PlannedJob, plan_job, run_job
from splinearm.sim.virtual_bus import VirtualBus
from splinearm.units import DEG, MM

PERIOD = 0.01
WAIT = 0.002
EXAMPLES = Path(__file__).parent.parent / "examples"
HEAD = f"{'':28}{'off the path':>18}{'off in time':>18}{'joints':>18}{'duty':>8}\n{'':28}" + (
    f"{'mm rms':>10}{'worst':>8}" * 2 + f"{'deg rms':>10}{'worst':>8}" + f"{'change':>8}"
)


class Clock:
    """A time that only the benchmark moves."""

    now = 0.0

    def __call__(self) -> float:
        """Give it, s."""
        return self.now


class OwnProfile:
    """The lead of servos that interpolate by themselves: without the part that FF1 makes up for."""

    def __init__(self, chain: ServoChain, cell: Cell, torque: Callable[..., np.ndarray]) -> None:
        drives = joint_drives(chain, cell.arm.joint_names)
        self.stiffness, self.rotor = column(drives, "stiffness"), column(drives, "inertia")
        self.friction, self.torque = column(drives, "friction"), torque

    def lead(self, setpoint: JointSetpoint) -> np.ndarray:
        """Give by how much the goals are ahead, rad."""
        late = PERIOD + WAIT  # interpolating takes a cycle
        qd = setpoint.qd + late * setpoint.qdd
        way = 0.5 * late * (setpoint.qd + qd)
        torque = self.torque(setpoint.q + way, qd, setpoint.qdd) + self.rotor * setpoint.qdd
        return way + (torque + self.friction * qd / (np.abs(qd) + 0.01)) / self.stiffness

    def current(self, setpoint: JointSetpoint) -> None:
        """Give no current."""
        return


def profiled(servo: ServoSpec) -> ServoSpec:
    """Give a servo that interpolates between goals."""
    model = servo.servo_model
    no_load = stall_at(model, 12.0)[2] * model.pulses_per_rad * 1e-3  # ticks a millisecond
    gain = round(4.0 * 885.0 / no_load)
    own = {
        "Drive Mode": servo.settings.get("Drive Mode", 0) | 4,
        "Profile Velocity": round(PERIOD * 1e3),
        "Feedforward 1st Gain": gain,
    }
    return replace(servo, settings={**servo.settings, **own})


def follow(job: PlannedJob, kind: str, period: float = PERIOD) -> str:
    """Carry out a job on a clock of its own; give a line of the table."""
    cell, trajectory = job.cell, job.plan.trajectory
    arm, clock = cell.arm, Clock()
    plain = chain = centred(require_chain(cell))
    torque = Dynamics(arm).inverse
    if kind == "own profile":
        moved = (profiled(servo) if servo.joint else servo for servo in chain.servos)
        chain = replace(chain, servos=tuple(moved))
    with VirtualBus(arm, chain, trajectory.q_start, wire_time=False, clock=clock) as virtual:
        bus = DynamixelBus(virtual.port, chain.baud, margin=1.0)
        ahead = None
        if kind == "own profile":
            ahead = OwnProfile(plain, cell, torque)
        elif kind != "off":
            known = torque if kind == "full" else None
            late = period / 2 + WAIT
            ahead = ServoFeedforward.of(chain, arm.joint_names, known, bus=bus, latency=late)

        def pass_time(duration: float) -> None:
            bus.ping(chain.servos[0].servo_id)  # a write that nobody answers is taken before
            clock.now += duration
            virtual.advance()

        with ServoArm(
            chain, arm.joint_names, arm.limits, bus, watchdog=None, feedforward=ahead
        ) as driver:

            def cycle(setpoint: JointSetpoint) -> tuple[np.ndarray, list[float]]:
                driver.read()
                q = virtual.q
                pass_time(WAIT)
                driver.write(setpoint)
                pass_time(period - WAIT)
                return q, [servo.duty for servo in virtual.servos.values()]

            start, still = driver.goal, np.zeros(arm.n)
            for k in range(150):
                share = min(1.0, k / 100)
                way = start + share**2 * (3 - 2 * share) * (trajectory.q_start - start)
                cycle(JointSetpoint(t=0.0, q=way, qd=still, qdd=still))
            count = math.ceil(trajectory.duration / period)
            wanted = [trajectory.at(min(k * period, trajectory.duration)) for k in range(count + 1)]
            rows = [cycle(setpoint) for setpoint in wanted]
    q = np.array([row[0] for row in rows])
    duty = np.array([row[1] for row in rows])
    change = np.sqrt(np.mean(np.diff(duty, 2, axis=0) ** 2))
    return table_row(job, np.array([setpoint.q for setpoint in wanted]), q) + f"{change:8.4f}"


def table_row(job: PlannedJob, wanted: np.ndarray, q: np.ndarray) -> str:
    """Give errors off the path, in time, and of the joints."""
    arm = job.cell.arm
    p_wanted, p = arm.fk(wanted)[:, :3, 3], arm.fk(q)[:, :3, 3]
    errors = (
        job.plan.tool_path.distance(p) / MM,
        np.linalg.norm(p - p_wanted, axis=1) / MM,
        (q - wanted) / DEG,
    )
    return "".join(f"{np.sqrt(np.mean(e**2)):10.3f}{np.abs(e).max():8.3f}" for e in errors)


def print_costs(cell: Cell) -> None:
    """Print what a cycle costs."""
    arm, chain = cell.arm, centred(require_chain(cell))
    rng = np.random.default_rng(1)
    q, qd, qdd = rng.uniform(-1, 1, (3, arm.n))
    setpoint = JointSetpoint(t=0.0, q=q, qd=qd, qdd=qdd)
    for kind, torque in (("velocity", None), ("full", Dynamics(arm).inverse)):
        ahead = ServoFeedforward.of(chain, arm.joint_names, torque)
        [cost] = shortest(lambda ahead=ahead: ahead.lead(setpoint), number=2000, rounds=30)
        print(f"{kind:10} lead of {arm.n} joints: {cost * 1e6:.1f} us a cycle")


def main() -> None:
    """Print the tables."""
    now = datetime.datetime.now(datetime.UTC)
    print(f"{now:%Y-%m-%d %H:%M} UTC, {processor()}, Python {platform.python_version()}")
    print(f"load average {os.getloadavg()[0]:.1f}\n")
    jobs = {}
    for name in ("inspect", "heart"):
        job = load_job(EXAMPLES / f"{name}.toml")
        jobs[name] = plan_job(job, load_cell(job.arm))
    print(f"on a clock of its own, a setpoint every {PERIOD * 1e3:.0f} ms\n{HEAD}")
    for name, job in jobs.items():
        for kind in ("off", "velocity", "full", "own profile"):
            print(f"{name + ', ' + kind:28}{follow(job, kind)}")
    if "--realtime" in sys.argv:
        print(f"\nsplinearm run --on virtual\n{HEAD}")
        for name, job in jobs.items():
            for kind in ("off", "velocity", "full"):
                start = job.plan.trajectory.q_start
                with open_arm(
                    job.cell, "virtual", q_start=start, rate=job.job.rate, feedforward=kind
                ) as station:
                    result = run_job(job, station)
                _, wanted, measured, _ = result.recorder.measured()
                print(f"{name + ', ' + kind:28}{table_row(job, wanted, measured)}")
    print()
    print_costs(jobs["inspect"].cell)


if __name__ == "__main__":
    main()
