"""Arms of one joint, screwed together anyhow, and a hand that turns them: no port, no time."""

from dataclasses import dataclass, replace
from math import pi

import numpy as np

from splinearm.commissioning.calibration_bench import CalibrationBench
from splinearm.config import load_cell
from splinearm.drivers.bus import PingReply, Reply
from splinearm.drivers.chain import ServoChain, ServoRole, ServoSpec
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics import Arm, DHConvention, DHLink
from splinearm.sim.shaft import Shaft
from splinearm.sim.virtual_servo import VirtualServo

_PLANAR = load_cell("planar_2r")
ROW = DHLink("elbow", a=0.1, alpha=0.0, d=0.0, theta=0.0, kind=JointKind.REVOLUTE)


class MemoryBus:
    """A line of virtual servos without a line; Present Position trembles by a tick."""

    port, baud, margin, retries = "memory", 1_000_000, 0.0, {}

    def __init__(self, servos, rng, noise=1):
        self.servos = {servo.servo_id: servo for servo in servos}
        self.rng, self.noise = rng, noise
        self.writes, self.group_writes = [], 0
        self.failing = 0

    def speak(self, protocols):
        pass

    def ping(self, servo_id):
        servo = self.servos[servo_id]
        return PingReply(servo_id, servo.model.number, servo.firmware)

    def read(self, servo_id, register):
        error, data = self.servos[servo_id].read(register.address, register.size)
        assert error == 0
        value = register.decode(data)
        if register.name == "Present Position":
            value += int(self.rng.integers(-self.noise, self.noise + 1))
        return value

    def write(self, servo_id, register, value):
        assert self.servos[servo_id].write(register.address, register.encode(value)) == 0
        self.writes.append((servo_id, register.name, value))

    def sync_write(self, group, values):
        self.group_writes += 1

    def sync_read(self, group):
        if self.failing:
            self.failing -= 1
            from splinearm.drivers.bus import Loss

            return {r.servo_id: Reply(b"", loss=Loss.SILENT) for r in group.requests}
        replies = {}
        for request in group.requests:
            servo = self.servos[request.servo_id]
            error, data = servo.read(request.address, request.length)
            assert error == 0
            present = servo.model.table["Present Position"]
            if request.address == present.address:
                value = present.decode(data) + int(self.rng.integers(-self.noise, self.noise + 1))
                data = present.encode(value)
            replies[request.servo_id] = Reply(data)
        return replies


@dataclass
class Scene:
    """An arm of one joint with its servos, and what a hand does to it."""

    cell: object
    bus: MemoryBus
    bench: CalibrationBench
    shafts: tuple

    @property
    def servo(self):
        return self.bus.servos[1]

    def turn_to(self, q, step=0.35):
        """Turn the joint there by hand, rad, looking now and then."""
        here = self.shafts[0].angle
        for angle in np.linspace(here, q, max(2, int(abs(q - here) / step) + 2))[1:]:
            for shaft in self.shafts:
                shaft.angle = float(angle)
            self.bench.poll()

    def rest(self):
        counts = self.bench.rest(pause=0.0)
        assert counts is not None
        return counts


def spec_of(model, mode=3, **more):
    settings = {"Operating Mode": mode} if "Operating Mode" in _table(model) else {}
    return ServoSpec(
        name=more.pop("name", "elbow"),
        servo_id=more.pop("servo_id", 1),
        model=model,
        role=more.pop("role", ServoRole.LEADER),
        joint="elbow",
        settings={**settings, **more.pop("settings", {})},
    )


def _table(model):
    from splinearm.drivers.model import servo_model

    return servo_model(model).table


def cell_of(specs, q_min, q_max):
    """A cell of one joint, its zero not known."""
    limits = JointLimits(
        names=("elbow",),
        kinds=(JointKind.REVOLUTE,),
        q_min=np.array([q_min]),
        q_max=np.array([q_max]),
        qd_max=np.array([2.0]),
        qdd_max=np.array([5.0]),
    )
    arm = Arm.from_dh("one", [ROW], DHConvention.STANDARD, limits)
    chain = ServoChain(servos=tuple(specs))
    return replace(_PLANAR, name="one", arm=arm, chain=chain, poses={"home": np.zeros(1)})


def mounted(spec, rng, shaft, *, at_zero=None, **registers):
    """A virtual servo with its horn mounted anyhow, and with other registers since."""
    model = spec.servo_model
    settings = {"ID": spec.servo_id}
    if "Drive Mode" in model.table:
        settings["Drive Mode"] = int(rng.integers(2))
    horn = int(rng.integers(model.pulses)) if at_zero is None else at_zero
    servo = VirtualServo(model, settings=settings, zero_ticks=horn, shaft=shaft)
    if at_zero is None:
        servo.slip(float(rng.uniform(0.0, 2.0 * pi)))
    servo.apply([(model.table[name], value) for name, value in registers.items()])
    servo.power_cycle()
    return servo


def scene_of(specs, servos, limits, rng, shafts):
    cell = cell_of(specs, *limits)
    bus = MemoryBus(servos, rng)
    bench = CalibrationBench(bus, cell)
    bench.survey()
    return Scene(cell, bus, bench, shafts)


def new_shaft(angle):
    shaft = Shaft()
    shaft.angle = angle
    return shaft
