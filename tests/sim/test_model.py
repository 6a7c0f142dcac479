import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.link import Inertia, Link
from splinearm.kinematics.quaternion import to_matrix
from splinearm.sim.model import (
    ROD_DENSITY,
    ROD_LENGTH,
    add_duty_motor,
    build_spec,
    compile_model,
    rod_inertia,
)
from splinearm.sim.motor import Motor

pytestmark = pytest.mark.sim

MOTOR = Motor(stall_torque=4.0, no_load_speed=5.0)
G = 9.81


def random_pose(rng: np.random.Generator) -> np.ndarray:
    T = np.eye(4)
    quat = rng.normal(size=4)
    T[:3, :3] = to_matrix(quat / np.linalg.norm(quat))
    T[:3, 3] = rng.uniform(-0.3, 0.3, 3)
    return T


def random_arm(seed: int, *, weighed: bool) -> Arm:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 7))
    kinds = tuple(rng.choice([JointKind.REVOLUTE, JointKind.PRISMATIC], n))
    links = []
    for k, kind in enumerate(kinds):
        shape = rng.normal(size=(8, 3)) * 0.05  # of a real body, so its moments are those of one
        tensor = sum(np.dot(p, p) * np.eye(3) - np.outer(p, p) for p in shape)
        inertia = Inertia(rng.uniform(0.1, 2.0), rng.uniform(-0.1, 0.1, 3), tensor)
        links.append(
            Link(f"j{k}", kind, random_pose(rng), random_pose(rng), inertia if weighed else None)
        )
    limits = JointLimits(
        names=tuple(link.name for link in links),
        kinds=kinds,
        q_min=np.full(n, -3.0),
        q_max=np.full(n, 3.0),
        qd_max=np.full(n, 4.0),
        qdd_max=np.full(n, 20.0),
    )
    return Arm(
        "random",
        tuple(links),
        limits,
        T_world_base=random_pose(rng),
        T_base_first=random_pose(rng),
        T_flange_tool=random_pose(rng),
    )


def simulated(arm: Arm) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = compile_model(build_spec(arm, [MOTOR] * arm.n))
    return model, mujoco.MjData(model)


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.booleans())
def test_the_tool_site_is_where_forward_kinematics_says(seed, weighed):
    arm = random_arm(seed, weighed=weighed)
    model, data = simulated(arm)
    q = np.random.default_rng(seed).uniform(-2.9, 2.9, arm.n)
    data.qpos[:] = q
    mujoco.mj_kinematics(model, data)
    T_world_tool = arm.T_world_base @ arm.fk(q)
    site = data.site("tool")
    assert np.abs(site.xpos - T_world_tool[:3, 3]).max() < 1e-12
    assert np.abs(site.xmat.reshape(3, 3) - T_world_tool[:3, :3]).max() < 1e-12


@pytest.mark.property
@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6))
def test_gravity_torque_is_the_slope_of_the_potential_energy(seed):
    arm = random_arm(seed, weighed=True)
    model, data = simulated(arm)
    q = np.random.default_rng(seed).uniform(-2.9, 2.9, arm.n)

    def energy(q: np.ndarray) -> float:
        Ts = arm.T_world_base @ arm.frames(q)
        coms = [
            T[:3, :3] @ link.inertia.com + T[:3, 3] for T, link in zip(Ts, arm.links, strict=True)
        ]
        return sum(link.inertia.mass * G * p[2] for p, link in zip(coms, arm.links, strict=True))

    h = 1e-6
    slope = [(energy(q + e) - energy(q - e)) / (2 * h) for e in h * np.eye(arm.n)]
    data.qpos[:] = q
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.qfrc_bias, slope, atol=1e-7)


def test_gravity_torque_of_an_upright_two_joint_arm_is_that_of_the_textbook(make_arm):
    arm = make_arm(2, upright=True)
    model, data = simulated(arm)
    (l1, l2), (m1, m2) = (0.3, 0.25), (0.3, 0.25)  # rods of 1 kg/m
    a, b = 0.4, -1.1
    data.qpos[:] = a, b
    mujoco.mj_forward(model, data)
    outer = m2 * G * l2 / 2 * np.cos(a + b)
    inner = (m1 / 2 + m2) * G * l1 * np.cos(a) + outer
    np.testing.assert_allclose(data.qfrc_bias, (inner, outer), rtol=1e-12)


def test_the_mass_matrix_holds_the_links_inertia_and_the_rotor():
    inertia = Inertia(0.5, [0.1, 0.0, 0.0], np.diag([1e-4, 2e-4, 3e-4]))
    tilted = np.eye(4)
    tilted[:3, :3] = [[0, 0, 1], [1, 0, 0], [0, 1, 0]]
    link = Link("j0", JointKind.REVOLUTE, np.eye(4), tilted, inertia)
    limits = JointLimits(
        names=("j0",),
        kinds=(JointKind.REVOLUTE,),
        q_min=np.array([-1.0]),
        q_max=np.array([1.0]),
        qd_max=np.array([1.0]),
        qdd_max=np.array([1.0]),
    )
    model, data = simulated(Arm("one", (link,), limits))
    mujoco.mj_forward(model, data)
    M = np.zeros((1, 1))
    mujoco.mj_fullM(model, data, M)
    # the link's y axis is the joint's z axis, its x axis lies across it
    assert M[0, 0] == pytest.approx(2e-4 + 0.5 * 0.1**2 + MOTOR.armature)


@pytest.mark.property
@given(st.tuples(*[st.floats(-0.5, 0.5)] * 3).map(np.array))
def test_a_rod_weighs_by_its_length_and_is_hard_to_swing(end):
    inertia = rod_inertia(end)
    length = max(np.linalg.norm(end), ROD_LENGTH)
    assert inertia.mass == pytest.approx(ROD_DENSITY * length)
    np.testing.assert_allclose(inertia.com, end / 2)
    moments = np.linalg.eigvalsh(inertia.tensor)
    assert moments[0] > 0.0
    assert moments[0] + moments[1] >= moments[2] - 1e-15


def test_a_rod_along_x_has_the_moments_of_a_solid_cylinder():
    inertia = rod_inertia(np.array([0.3, 0.0, 0.0]))
    np.testing.assert_allclose(np.diag(inertia.tensor), (6e-5, 2.28e-3, 2.28e-3), rtol=1e-9)


def test_joint_stops_are_those_of_the_limits(make_arm):
    model, _ = simulated(make_arm(2))
    assert model.jnt_limited.all()
    np.testing.assert_allclose(model.jnt_range, [[-2.9, 2.9]] * 2)


def test_a_joint_without_limits_has_no_stops():
    link = Link("j0", JointKind.REVOLUTE, np.eye(4), np.eye(4))
    limits = JointLimits(
        names=("j0",),
        kinds=(JointKind.REVOLUTE,),
        q_min=np.array([-np.inf]),
        q_max=np.array([np.inf]),
        qd_max=np.array([1.0]),
        qdd_max=np.array([1.0]),
    )
    model, _ = simulated(Arm("one", (link,), limits))
    assert not model.jnt_limited.any()


def test_nothing_collides(make_arm):
    model, data = simulated(make_arm(6))
    data.qpos[:] = 2.8  # curled up
    mujoco.mj_forward(model, data)
    assert data.ncon == 0
    assert model.ngeom == 7


def test_an_inertia_that_no_body_can_have_is_refused_with_the_arms_name(make_arm):
    inertia = Inertia(0.1, np.zeros(3), np.diag([1e-3, 1e-3, 1e-2]))
    link = Link("j0", JointKind.REVOLUTE, np.eye(4), np.eye(4), inertia)
    arm = Arm("odd", (link,), make_arm(1).limits)
    with pytest.raises(ValueError, match="arm 'odd': MuJoCo refuses its model"):
        simulated(arm)


def test_the_number_of_motors_and_the_timestep_are_checked(make_arm):
    with pytest.raises(ValueError, match="want 2 of them, one a joint, got 1"):
        build_spec(make_arm(2), [MOTOR])
    with pytest.raises(ValueError, match="timestep: want a time above zero"):
        build_spec(make_arm(1), [MOTOR], timestep=0.0)


def test_a_duty_motor_lies_on_its_line_at_every_speed(make_arm):
    spec = build_spec(make_arm(1), [MOTOR])
    add_duty_motor(spec, "m", "j0", MOTOR, 0)
    model = compile_model(spec)
    data = mujoco.MjData(model)
    for duty in (-1.0, -0.2, 0.0, 0.7, 1.3, 3.0):
        for speed in (-6.0, 0.0, 2.0):
            data.ctrl[0], data.qvel[0] = duty, speed
            mujoco.mj_forward(model, data)
            wanted = 4.0 * (np.clip(duty, -2.0, 2.0) - speed / 5.0)
            assert data.actuator_force[0] == pytest.approx(wanted)
