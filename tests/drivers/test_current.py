"""Torques as currents: the makers' figures, and arms that push no harder than they must."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.drivers.chain import ServoChain, ServoRole, ServoSpec
from splinearm.drivers.current import ForceLimited, joint_currents
from splinearm.drivers.feedforward import ServoFeedforward
from splinearm.drivers.feedforward_drive import torque_per_amp
from splinearm.drivers.model import servo_model
from splinearm.joints import JointSetpoint
from splinearm.kinematics.dynamics import Dynamics
from splinearm.units import DEG


def servo(servo_id=1, joint="j0", model="XM430-W350", role=ServoRole.LEADER, **settings):
    return ServoSpec(
        name=f"s{servo_id}",
        servo_id=servo_id,
        model=model,
        role=role,
        joint=joint,
        zero_ticks=2048,
        settings={"Return Delay Time": 0, **settings},
    )


MODE_5 = {"Operating Mode": 5}


def mixed() -> ServoChain:
    """A joint in mode 5, one of two servos in mode 3, one without current."""
    return ServoChain(
        servos=(
            servo(**MODE_5),
            servo(2, "j1"),
            servo(3, "j1", role=ServoRole.SHADOW, **{"Current Limit": 500}),
            servo(4, "j2", model="XL430-W250"),
        )
    )


NAMES = ["j0", "j1", "j2"]


def still(q) -> JointSetpoint:
    q = np.array(q, dtype=float)
    return JointSetpoint(t=0.0, q=q, qd=np.zeros_like(q), qdd=np.zeros_like(q))


def limited(torque, **options) -> ForceLimited:
    chain = mixed()
    ahead = ServoFeedforward.of(chain, NAMES, lambda q, qd, qdd: np.array(torque))
    return ForceLimited(ahead, joint_currents(chain, NAMES), **options)


def test_an_ampere_is_worth_what_the_maker_says():
    model = servo_model("XM430-W350")
    figures = [3.8 / 2.1, 4.1 / 2.3, 4.8 / 2.7]
    assert torque_per_amp(model) == pytest.approx(sum(figures) / 3)


def test_servos_at_a_joint_add_up_and_the_weakest_limit_counts():
    one, two, none = joint_currents(mixed(), NAMES)
    assert one is not None
    assert two is not None
    assert none is None
    assert two.torque_per_amp == pytest.approx(2 * one.torque_per_amp)
    assert one.most == pytest.approx(1193 * 2.69e-3)
    assert two.most == pytest.approx(500 * 2.69e-3)
    assert two.torque_max == pytest.approx(two.torque_per_amp * two.most)
    assert (one.limits, two.limits) == (True, False)


def test_the_current_of_a_joint_in_mode_5_is_what_it_needs_and_some():
    amps = limited([-1.0, 1.0, 1.0], spare=0.3).current(still([0.0] * 3))
    per_amp = torque_per_amp(servo_model("XM430-W350"))
    assert amps == pytest.approx([1.3 / per_amp, 500 * 2.69e-3, 0.0])


def test_the_lead_is_that_of_what_it_limits():
    one = limited([-1.0, 1.0, 1.0])
    assert one.lead(still([0.1] * 3)).tolist() == one.ahead.lead(still([0.1] * 3)).tolist()


@pytest.mark.property
@given(st.floats(-100.0, 100.0))
def test_no_current_is_above_the_limit_of_its_servos(torque):
    amps = limited([torque] * 3).current(still([0.0] * 3))
    assert (amps >= 0.0).all()
    assert amps[0] <= 1193 * 2.69e-3


def test_what_does_not_go_together_is_refused():
    plain = ServoChain(servos=(servo(),))
    weight = ServoFeedforward.of(plain, ["j0"], lambda q, qd, qdd: q)
    with pytest.raises(ValueError, match="mode 5"):
        ForceLimited(weight, joint_currents(plain, ["j0"]))
    five = ServoChain(servos=(servo(**MODE_5),))
    with pytest.raises(ValueError, match="torques"):
        ForceLimited(ServoFeedforward.of(five, ["j0"]), joint_currents(five, ["j0"]))
    with pytest.raises(ValueError, match="spare"):
        ForceLimited(weight, joint_currents(five, ["j0"]), spare=0.0)
    with pytest.raises(ValueError, match="one a joint"):
        ForceLimited(weight, [])


@pytest.mark.kernel
def test_an_arm_in_mode_5_holds_its_weight_and_gives_way_to_a_push(stepped_arm, pendulum):
    chain = ServoChain(servos=(servo(**MODE_5),))
    arm = pendulum(1, 1.0)
    torque = Dynamics(arm).inverse

    def make(bus):
        ahead = ServoFeedforward.of(chain, ["j0"], torque, bus=bus)
        return ForceLimited(ahead, joint_currents(chain, ["j0"]), spare=0.4)

    one = stepped_arm(arm, chain, [0.3], make)
    with one.driver:
        q = one.rest(np.array([0.3]), 1.0)
        assert q == pytest.approx([0.3], abs=0.3 * DEG)
        one.push(np.array([-0.3]))  # less than it has to spare
        assert one.rest(np.array([0.3]), 0.5) == pytest.approx([0.3], abs=1.5 * DEG)
        one.push(np.array([-1.0]))  # more
        assert one.rest(np.array([0.3]), 0.5)[0] < 0.3 - 10.0 * DEG


@pytest.mark.kernel
@pytest.mark.parametrize(("share", "stays"), [(1.0, True), (0.9, False)])
def test_in_current_control_a_weight_that_is_well_known_is_carried_another_falls(
    share, stays, stepped_arm, pendulum
):
    chain = ServoChain(servos=(servo(),))
    arm = pendulum(1, 1.0)
    one = stepped_arm(arm, chain, [0.3])
    table = servo_model("XM430-W350").table
    weight = Dynamics(arm)
    [joint] = joint_currents(chain, ["j0"])
    one.bus.write(1, table["Operating Mode"], 0)
    one.bus.write(1, table["Torque Enable"], 1)
    for _ in range(200):
        amps = share * weight.gravity_torque(one.virtual.q)[0] / joint.torque_per_amp
        one.bus.write(1, table["Goal Current"], round(amps / 2.69e-3))
        one.pass_time(0.01)
    assert bool(abs(one.virtual.q[0] - 0.3) <= 1.0 * DEG) is stays


@pytest.mark.kernel
def test_the_feed_forward_makes_up_for_the_lag_of_mode_5_too(stepped_arm, pendulum):
    chain = ServoChain(servos=(servo(**MODE_5),))
    arm = pendulum(1, 0.05)
    torque, off = Dynamics(arm).inverse, []
    for led in (False, True):

        def make(bus, led=led):
            return ServoFeedforward.of(chain, ["j0"], torque, bus=bus) if led else None

        one = stepped_arm(arm, chain, [0.0], make)
        with one.driver:
            one.rest(np.zeros(1), 0.3)
            worst = 0.0
            for k in range(1, 101):
                u, T = k / 100, 1.0  # a quintic over a radian
                q = u**3 * (10.0 - 15.0 * u + 6.0 * u * u)
                qd = 30.0 * u * u * (1.0 - u) ** 2 / T
                qdd = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / T**2
                point = JointSetpoint(t=u, q=np.array([q]), qd=np.array([qd]), qdd=np.array([qdd]))
                worst = max(worst, abs(float(q - one.cycle(point)[0])))
        off.append(worst)
    assert off[1] <= 0.2 * off[0]
