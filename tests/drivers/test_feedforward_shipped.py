"""Every shipped arm on virtual servos: led it follows, and led by hand it stays."""

import numpy as np
import pytest

from splinearm.backends import centred
from splinearm.config import load_cell, shipped_arms
from splinearm.drivers.current_gravity import GravityCompensation
from splinearm.drivers.feedforward import ServoFeedforward
from splinearm.kinematics.dynamics import Dynamics
from splinearm.trajectories.plan import plan_joint_move
from splinearm.units import DEG

pytestmark = [pytest.mark.slow, pytest.mark.kernel]


def poses(cell, count, seed):
    """Give poses around home, well within the limits."""
    limits, home = cell.arm.limits, cell.poses["home"]
    low, high = np.maximum(limits.q_min, -2.5) + 0.05, np.minimum(limits.q_max, 2.5) - 0.05
    around = np.random.default_rng(seed).uniform(-0.8, 0.8, (count, cell.arm.n))
    return np.clip(home + around, low, high)


def full(chain, arm):
    torque = Dynamics(arm).inverse
    return lambda bus: ServoFeedforward.of(chain, arm.joint_names, torque, bus=bus, latency=0.0065)


def worst_errors(one, cell) -> np.ndarray:
    """Go from home to some poses; give each joint's rms error, rad."""
    start = cell.poses["home"]
    errors = []
    with one.driver:
        one.rest(start, 1.0)
        for goal in poses(cell, 3, seed=3):
            way = plan_joint_move(cell.arm.limits.scaled(0.5), start, goal)
            start = goal
            for k in range(int(way.duration / one.period) + 30):
                wanted = way.at(min(k * one.period, way.duration))
                errors.append(one.cycle(wanted) - wanted.q)
    return np.sqrt(np.mean(np.square(errors), axis=0))


@pytest.mark.parametrize("name", shipped_arms())
def test_every_joint_of_a_shipped_arm_follows_better(name, stepped_arm):
    cell = load_cell(name)
    chain = centred(cell.chain)
    without = worst_errors(stepped_arm(cell.arm, chain, cell.poses["home"]), cell)
    led = stepped_arm(cell.arm, chain, cell.poses["home"], full(chain, cell.arm))
    with_it = worst_errors(led, cell)
    integrates = [drive.integrates for drive in led.feedforward.drives]
    # an I gain carries the weight by and by: there only the speed is led
    assert (with_it <= without / np.where(integrates, 1.5, 4.0)).all()
    assert (with_it <= np.where(integrates, 0.8, 0.2) * DEG).all()


@pytest.mark.parametrize("name", shipped_arms())
def test_a_shipped_arm_that_is_let_go_stays(name, stepped_arm):
    cell = load_cell(name)
    chain = centred(cell.chain)
    for pose in poses(cell, 3, seed=5):
        one = stepped_arm(cell.arm, chain, pose, full(chain, cell.arm))
        with one.driver:
            one.pass_time(1.0)
            start = one.virtual.q
            with GravityCompensation(one.driver, one.feedforward, cell.arm.limits) as guide:
                for _ in range(500):
                    guide.step()
                    one.pass_time(one.period)
            assert one.virtual.q == pytest.approx(start, abs=1.0 * DEG)
