"""Whatever state the servos are in, nothing moves when their torque comes on."""

import numpy as np
import pytest

from splinearm.drivers.servo_arm import ServoArm
from splinearm.errors import ServoError

PULSE = 2 * np.pi / 4096


def randomise(rng: np.random.Generator, bus) -> None:
    """Bring servos that rest into some state in which a program may find them."""
    for shaft in bus.shafts.values():
        shaft.angle, shaft.speed = rng.uniform(-1.4, 1.4), 0.0
    for servo in bus.servos.values():
        memory = servo.memory
        servo.forget_turns()
        memory["Bus Watchdog"] = int(rng.integers(0, 2)) and 0xFF
        memory["Goal Position"] = int(rng.integers(0, 4096))
        memory["Profile Velocity"] = int(rng.integers(0, 300))
        memory["Status Return Level"] = int(rng.integers(0, 3))
        if rng.random() < 0.1:
            memory["Operating Mode"] = int(rng.choice([1, 3, 4]))
        if rng.random() < 0.5:  # it holds where it is, and what its goal says only if not tripped
            goal = memory["Goal Position"] if servo.tripped else servo.position
            memory["Goal Position"] = servo.position
            memory["Bus Watchdog"], tripped = 0, servo.tripped
            servo.write(servo.model.table["Torque Enable"].address, b"\x01")
            memory["Goal Position"], memory["Bus Watchdog"] = goal, 0xFF if tripped else 0
        if rng.random() < 0.1:
            servo.fail(*rng.choice(["overload", "overheating", "motor encoder"], 1))


def arm_on(bus, chain, limits, **options) -> ServoArm:
    return ServoArm(chain, limits.names, limits, bus, **options)


class Watch:
    """Keeps how far any joint was from where it stood."""

    def __init__(self, bus) -> None:
        self.bus = bus
        self.start = self.angles()
        self.farthest = 0.0
        bus.watch = self.look

    def angles(self) -> np.ndarray:
        return np.array([shaft.angle for shaft in self.bus.shafts.values()])

    def look(self) -> None:
        self.farthest = max(self.farthest, float(np.abs(self.angles() - self.start).max()))

    def require_rest(self) -> None:
        self.bus.sleep(0.05)
        assert self.farthest <= PULSE


def ways_on(arm, bus, rng, setpoint) -> None:
    """Go all ways to torque, one after the other; ``Watch`` looks on."""
    for servo in bus.servos.values():
        assert servo.torque_on
        assert not servo.tripped
        assert abs(servo.position - servo.memory["Goal Position"]) <= 1
    arm.release()
    for shaft in bus.shafts.values():
        shaft.angle = rng.uniform(-1.4, 1.4)
    watch = Watch(bus)
    arm.hold()  # after a release
    watch.require_rest()
    victim = bus.servos[int(rng.choice(list(bus.servos)))]
    victim.fail("overload")
    assert [str(fault.causes) for fault in arm.recover()] == ["('overload',)"]
    watch.require_rest()
    arm.write(setpoint(*arm.goal))
    bus.sleep(0.1)  # a silence: all are stopped by their watchdogs
    assert all(servo.tripped for servo in bus.servos.values())
    arm.write(setpoint(*arm.goal))
    watch.require_rest()
    bus.gone = True
    bus.sleep(0.1)
    victim.power_cycle()
    bus.sleep(0.5)
    arm.reconnect("elsewhere")
    watch.require_rest()
    assert all(servo.torque_on for servo in bus.servos.values())


@pytest.mark.parametrize(
    "draw", [(0, 60), *(pytest.param((k, 250), marks=pytest.mark.slow) for k in range(4))]
)
def test_from_any_state_no_joint_moves_when_its_torque_comes_on(
    draw, make_chain, make_limits, make_direct, in_their_time, setpoint
):
    seed, states = draw
    rng = np.random.default_rng(seed)
    entered = all_ways = 0
    for _ in range(states):
        chain, limits = make_chain(), make_limits()
        bus = make_direct(chain)
        in_their_time(bus)
        randomise(rng, bus)
        watch = Watch(bus)
        try:
            with arm_on(bus, chain, limits) as arm:
                watch.require_rest()
                entered += 1
                if entered % 3 == 0:
                    ways_on(arm, bus, rng, setpoint)
                    all_ways += 1
        except ServoError as error:
            assert error.alert or "Operating Mode" in str(error)  # noqa: PT017
            watch.require_rest()
    assert entered > states // 3
    assert all_ways > states // 10
