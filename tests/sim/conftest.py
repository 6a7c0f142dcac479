"""Arms, chains and servos of which the tests of this room are made."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest

from splinearm.drivers.chain import ServoChain, ServoRole, ServoSpec
from splinearm.drivers.model import servo_model
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.dh import DHConvention, DHLink
from splinearm.sim.motor import motor_of
from splinearm.sim.plant import FreePlant
from splinearm.sim.shaft import TIMESTEP, Shaft
from splinearm.sim.virtual_servo import VirtualServo

LENGTHS = {2: (0.3, 0.25)}


def arm_of(n: int, *, upright: bool = False) -> Arm:
    """Give a planar arm of n turning joints; upright it moves in a vertical plane."""
    names = tuple(f"j{k}" for k in range(n))
    limits = JointLimits(
        names=names,
        kinds=(JointKind.REVOLUTE,) * n,
        q_min=np.full(n, -2.9),
        q_max=np.full(n, 2.9),
        qd_max=np.full(n, 4.0),
        qdd_max=np.full(n, 20.0),
    )
    T_world_base = np.eye(4)
    if upright:
        T_world_base[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    rows = [
        DHLink(name, length, 0.0, 0.0, 0.0)
        for name, length in zip(names, LENGTHS.get(n, (0.1,) * n), strict=True)
    ]
    return Arm.from_dh("arm", rows, DHConvention.STANDARD, limits, T_world_base=T_world_base)


def chain_of(
    n: int, model: str = "XM430-W350", baud: int = 1_000_000, **settings: int
) -> ServoChain:
    """Give a chain with a leader for each of n joints, ids from 1."""
    servos = [
        ServoSpec(
            name=f"s{k}",
            servo_id=k + 1,
            model=model,
            role=ServoRole.LEADER,
            joint=f"j{k}",
            zero_ticks=2048,
            settings={"Return Delay Time": 0, **settings},
        )
        for k in range(n)
    ]
    return ServoChain(servos=tuple(servos), baud=baud)


@dataclass
class Bench:
    """One servo on a bench with nothing on its horn, and a clock that is stepped."""

    servo: VirtualServo
    plant: FreePlant
    now: float = 0.0
    positions: list[int] = field(default_factory=list)

    def run(self, duration: float) -> None:
        """Let time go by."""
        for _ in range(round(duration / TIMESTEP)):
            self.now += TIMESTEP
            self.servo.tick(self.now)
            self.plant.step()
            self.positions.append(self.servo.position)

    def set(self, name: str, value: int) -> int:
        """Write a register as a client would; give the error number."""
        register = self.servo.memory.table[name]
        return self.servo.write(register.address, register.encode(value))

    def get(self, name: str) -> int:
        """Read a register as a client would."""
        register = self.servo.memory.table[name]
        number, data = self.servo.read(register.address, register.size)
        assert number == 0
        return register.decode(data)


def bench_of(
    model: str = "XM430-W350", *, angle: float = 0.0, zero: int | None = 2048, **settings: int
):
    """Give a servo on a bench."""
    shaft = Shaft(angle=angle)
    servo = VirtualServo(
        servo_model(model),
        settings={name.replace("_", " "): value for name, value in settings.items()},
        zero_ticks=zero,
        shaft=shaft,
    )
    return Bench(servo, FreePlant(motor_of(servo.model), shaft))


@pytest.fixture
def make_arm() -> Callable[..., Arm]:
    """Give the maker of planar arms."""
    return arm_of


@pytest.fixture
def make_chain() -> Callable[..., ServoChain]:
    """Give the maker of chains."""
    return chain_of


@pytest.fixture
def make_bench() -> Callable[..., Bench]:
    """Give the maker of servos on a bench."""
    return bench_of


@pytest.fixture
def bench() -> Bench:
    """Give an XM430-W350 on a bench."""
    return bench_of()
