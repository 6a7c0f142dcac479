"""An arm of virtual servos on its way along a spline, what goes wrong, and what was seen of it."""

from collections.abc import Callable, Collection
from contextlib import suppress
from dataclasses import replace

import numpy as np
from fault_time import Clock, Plug, SteppedBus

from splinearm.backends import centred
from splinearm.config import load_cell
from splinearm.control.cycle import Cycle
from splinearm.control.ending import Ending
from splinearm.control.follow import Loop
from splinearm.control.guard import Guard
from splinearm.control.rehearsal import rehearse
from splinearm.control.stop import StopRequest
from splinearm.drivers.feedforward import ServoFeedforward, cycle_latency
from splinearm.drivers.servo_arm import ServoArm
from splinearm.errors import BusError
from splinearm.kinematics.dynamics import Dynamics
from splinearm.sim.event import EventKind
from splinearm.sim.line_fault import LineFault
from splinearm.sim.trace import Trace
from splinearm.sim.virtual_bus import VirtualBus
from splinearm.trajectories.plan import plan, plan_joint_move
from splinearm.trajectories.trajectory import JointTrajectory
from splinearm.trajectories.waypoint import Waypoint

RATE = 100.0
DUE = 20
"""Cycle in which things go wrong: the arm is on its way by then."""
SPEED = 0.5
"""Share of the joints' speed limits that the motion may take."""
WAYS = {
    "planar_2r": ([0.0, 0.05, 0.0], [-0.06, 0.10, 0.0], [-0.06, 0.16, 0.0]),
    "wx250s": ([0.0, 0.05, 0.0], [-0.04, 0.09, 0.03], [-0.04, 0.14, 0.05]),
}
"""Where each arm's tool goes from its pose "home", m."""
_ALONG = 4000


class Scene:
    """An arm, opened as ``backends`` opens it, in a time of its own.

    Args:
        arm: A shipped arm.
        usb_latency: What its adapter waits before it hands bytes on, s.
        watchdog: After which silence its servos stop by themselves, s.
        registers: What its servos are set to besides what the arm's file says.
        rate: Setpoints a second that are asked for, Hz.
        baud: Of its bus, if that is another than the arm's file says.
        seed: Of the dice of the line's faults.
    """

    def __init__(
        self,
        arm: str,
        *,
        usb_latency: float = 0.0,
        watchdog: float = 0.04,
        registers: dict[str, int] | None = None,
        rate: float = RATE,
        baud: int | None = None,
        seed: int = 0,
    ) -> None:
        self.cell = load_cell(arm)
        chain = centred(self.cell.chain)
        servos = [replace(s, settings={**s.settings, **(registers or {})}) for s in chain.servos]
        self.chain = replace(chain, servos=tuple(servos), baud=baud or chain.baud)
        self.clock = Clock()
        home, now = self.cell.poses["home"], self.clock.monotonic
        self.virtual = VirtualBus(self.cell.arm, self.chain, home, clock=now, seed=seed)
        self.plug = Plug(self.virtual, self.clock, usb_latency)
        self.bus: SteppedBus | None = None
        self.rate, self.watchdog = rate, watchdog
        self.arm: ServoArm | None = None
        self.begun = 0.0
        self.said: list[tuple[int, str]] = []
        self.cycles: list[Cycle] = []
        self.heard: list[np.ndarray] = []
        self.goals: list[list[int]] = []
        self._numbers = [spec.servo_id for spec in self.chain.servos]
        for servo in self.virtual.all_servos:
            servo.trace = Trace()

    def servo(self, number: int):
        """Give the servo with that id in the arm's file, whatever its id is now."""
        return self.virtual.all_servos[self._numbers.index(number)]

    @property
    def joints(self) -> list[int]:
        """The ids of the leaders, in the order of the joints."""
        return [s.servo_id for s in self.chain.leaders_of(self.cell.arm.joint_names)]

    def line(self, kind: str, **how) -> None:
        """Let something go wrong on the line, and nothing else any more."""
        self.virtual.faults = (LineFault(kind=kind, **how),)

    def calm(self) -> None:
        """Let nothing go wrong on the line any more."""
        self.virtual.faults = ()

    def wait(self, duration: float) -> None:
        """Let time go by."""
        self.clock.sleep(duration)
        self.virtual.advance()

    def enter(self) -> None:
        """Open the arm, and choose the rate that can be held."""
        cell, chain = self.cell, self.chain
        self.bus = SteppedBus(self.plug, chain.baud)
        ahead = ServoFeedforward.of(
            chain,
            cell.arm.joint_names,
            Dynamics(cell.arm).inverse,
            bus=self.bus,
            latency=cycle_latency(1.0 / self.rate, cell.arm.n, chain.baud),
        )
        arm = ServoArm(
            chain,
            cell.arm.joint_names,
            cell.arm.limits,
            self.bus,
            watchdog=self.watchdog,
            feedforward=ahead,
        )
        self.arm = arm.__enter__()
        self.rate = rehearse(self.clock, 1.0 / self.rate, self._try_to_read).rate(self.rate)

    def _try_to_read(self) -> None:
        with suppress(BusError):
            self.arm.read()

    def leave(self) -> None:
        """Leave the arm as the end of a program does."""
        if self.arm is not None:
            self.arm.__exit__(None, None, None)

    def motion(self) -> JointTrajectory:
        """Plan the motion: one B-spline of the tool, from where the arm is held."""
        arm, held = self.cell.arm, self.arm.goal
        start = arm.fk(held)[:3, 3]
        waypoints = [Waypoint(position=start + way) for way in WAYS[arm.name]]
        return plan(arm, waypoints, held, limits=arm.limits.scaled(SPEED)).trajectory

    def follow(
        self,
        motion: JointTrajectory,
        strike: Callable[[], object] | None = None,
        at: int = DUE,
        stop: StopRequest | None = None,
    ) -> Ending:
        """Carry a motion out; in a cycle something happens."""
        due = [] if strike is None else [strike]

        def observe(cycle: Cycle) -> None:
            self.virtual.advance()
            self.cycles.append(cycle)
            self.heard.append(self.arm.last_seen.t)
            self.goals.append([self.servo(i).memory["Goal Position"] for i in self.joints])
            if due and cycle.index >= at:
                due.pop()()

        loop = Loop(
            driver=self.arm,
            clock=self.clock,
            guard=Guard(self.cell.arm.limits),
            period=1.0 / self.rate,
            observe=observe,
            announce=self._keep,
        )
        return loop.carry_out(motion, stop)

    def _keep(self, text: str) -> None:
        if text.startswith("motion of"):  # the loop's first cycle is now
            self.begun = self.clock.t
        self.said.append((self.cycles[-1].index + 1 if self.cycles else 0, text))

    def time_of(self, cycle: Cycle) -> float:
        """Give when a cycle of the last motion was due, in the time of the rig."""
        return self.begun + cycle.t - (self.clock.t - self.virtual.rig.now)

    def go_on(self, ending: Ending) -> Ending:
        """Go back to where a stopped motion rests, then along the rest of it."""
        rest = ending.stopped.remaining()
        limits = self.cell.arm.limits.scaled(0.3)
        back = plan_joint_move(limits, self.arm.goal, rest.q_start)
        first = self.follow(back)
        return first if first.fault is not None else self.follow(rest)


class Witness:
    """What really happened to the joints of a scene while a motion was under way."""

    def __init__(self, scene: Scene, motion: JointTrajectory, since: float, until: float) -> None:
        self.scene = scene
        arm = scene.cell.arm
        rows = [scene.servo(i).trace.motion().after(since) for i in scene.joints]
        here = rows[0].t <= until
        self.t = rows[0].t[here]
        """A row a millisecond, s."""
        self.q = np.stack([row.angle[here] for row in rows], axis=1)
        """Where the joints were, shape (k, n), rad."""
        self.qd = np.stack([row.speed[here] for row in rows], axis=1)
        """Their speeds, rad/s."""
        along, _, _ = motion.sample(np.linspace(0.0, motion.duration, _ALONG))
        self._along = along
        self._tool_along = arm.fk(along)[:, :3, 3]

    def off_path(self, healthy: Collection[int]) -> np.ndarray:
        """Give how far some joints were off the path, whenever they should have been there, rad."""
        q, along = self.q[:, list(healthy)], self._along[:, list(healthy)]
        return np.array([np.abs(along - one).max(axis=1).min() for one in q])

    def tool_off_path(self) -> np.ndarray:
        """Give how far the tool was off its path, m."""
        p = self.scene.cell.arm.fk(self.q)[:, :3, 3]
        return np.array([np.linalg.norm(self._tool_along - one, axis=1).min() for one in p])

    def require_limits(self, healthy: Collection[int]) -> None:
        """Require that no joint was beyond a limit."""
        limits = self.scene.cell.arm.limits
        for i in healthy:
            assert (self.q[:, i] >= limits.q_min[i]).all()
            assert (self.q[:, i] <= limits.q_max[i]).all()
            assert np.abs(self.qd[:, i]).max() <= limits.qd_max[i]


def require_setpoints_within_limits(scene: Scene) -> None:
    """Require that what was sent was within every limit and continued what was sent before."""
    limits = scene.cell.arm.limits
    for cycle in scene.cycles:
        point = cycle.setpoint
        limits.check(point.q, point.qd, point.qdd)
    for one, other in zip(scene.cycles, scene.cycles[1:], strict=False):
        elapsed = (other.index - one.index) / scene.rate
        if elapsed <= 0.0:  # another motion begins
            continue
        rate = (other.setpoint.q - one.setpoint.q) / elapsed
        gain = (other.setpoint.qd - one.setpoint.qd) / elapsed
        assert (np.abs(rate) <= limits.qd_max * 1.001).all()
        assert (np.abs(gain) <= limits.qdd_max * 1.001).all()


def torque_lost(scene: Scene) -> set[int]:
    """Give the ids of servos whose torque went off, for whatever reason."""
    return {
        number for number in scene._numbers if scene.servo(number).events.of(EventKind.TORQUE_OFF)
    }
