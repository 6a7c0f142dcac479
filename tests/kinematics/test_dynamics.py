"""Dynamics: what must hold of any arm, and what payload, friction and rotors add."""

from dataclasses import replace

import numpy as np
import pytest

from splinearm.kinematics import DHConvention, DHLink, Inertia
from splinearm.kinematics.dynamics import Drives, Dynamics

pytestmark = pytest.mark.kernel

G = 9.81


@pytest.fixture(scope="module")
def arms(random_arm):
    found = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        arm = random_arm(seed, 2 + seed % 7, list(DHConvention)[seed % 2])
        roots = 0.1 * rng.normal(size=(arm.n, 3, 3))
        links = [
            replace(link, inertia=Inertia(rng.uniform(0.2, 2), rng.normal(size=3) * 0.1, A @ A.T))
            for link, A in zip(arm.links, roots, strict=True)
        ]
        found.append(replace(arm, links=tuple(links)))
    return found


@pytest.fixture(scope="module")
def pendulum(dh_arm):
    """A rod of 2 kg, 0.5 m long, on a joint that turns about the world's y axis."""
    rod = Inertia(2.0, (-0.25, 0.0, 0.0), np.diag([0.0, 2 * 0.25 / 12, 2 * 0.25 / 12]))
    upright = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
    rows = [DHLink("swing", a=0.5, alpha=0.0, d=0.0, theta=0.0)]
    return dh_arm(rows, DHConvention.STANDARD, inertias=[rod], T_base_first=upright)


def states(arm, seed, *m):
    return np.random.default_rng(seed).uniform(-2, 2, (3, *m, arm.n))


def test_a_pendulum_is_as_in_the_textbook(pendulum):
    dynamics = Dynamics(pendulum)
    angle = 0.3
    torque = dynamics.inverse([angle], [1.7], [2.0])
    # turning by a positive angle lowers the rod: z of the joint is +y of the world
    wanted = 2.0 * 0.5**2 / 3 * 2.0 - 2.0 * G * 0.25 * np.cos(angle)
    np.testing.assert_allclose(torque, [wanted], rtol=1e-14)
    np.testing.assert_allclose(dynamics.mass_matrix([angle]), [[2.0 * 0.5**2 / 3]], rtol=1e-14)
    np.testing.assert_allclose(dynamics.coriolis_torque([angle], [1.7]), [0.0], atol=1e-15)


def test_torques_are_mass_times_acceleration_and_the_rest(arms):
    for seed, arm in enumerate(arms):
        q, qd, qdd = states(arm, seed)
        dynamics = Dynamics(arm)
        M, C = dynamics.mass_matrix(q), dynamics.coriolis_matrix(q, qd)
        torque = M @ qdd + C @ qd + dynamics.gravity_torque(q)
        np.testing.assert_allclose(dynamics.inverse(q, qd, qdd), torque, rtol=0, atol=1e-12)
        np.testing.assert_allclose(M, M.T, rtol=0, atol=0)
        assert np.linalg.eigvalsh(M).min() > 0.0
        np.testing.assert_allclose(C @ qd, dynamics.coriolis_torque(q, qd), rtol=0, atol=1e-12)


def test_the_mass_matrix_changes_as_the_coriolis_matrix_says(arms):
    step = 1e-6
    for seed, arm in enumerate(arms):
        q, qd, _ = states(arm, seed)
        dynamics = Dynamics(arm)
        over, under = dynamics.mass_matrix([q + step * qd, q - step * qd])
        rate = (over - under) / (2 * step)
        C = dynamics.coriolis_matrix(q, qd)
        np.testing.assert_allclose(rate, C + C.T, rtol=0, atol=2e-7)


def test_gravity_torque_is_the_slope_of_the_potential(arms):
    step = 1e-6
    for seed, arm in enumerate(arms):
        q = states(arm, seed)[0]

        def potential(q, arm=arm):
            frames = arm.frames(q)
            coms = [
                link.inertia.mass
                * G
                * (frames[:, k, 2, :3] @ link.inertia.com + frames[:, k, 2, 3])
                for k, link in enumerate(arm.links)
            ]
            return np.sum(coms, axis=0)

        steps = step * np.eye(arm.n)
        slope = (potential(q + steps) - potential(q - steps)) / (2 * step)
        # the potential is written in base, so that gravity is too
        in_base = Dynamics(replace(arm, T_world_base=np.eye(4)))
        np.testing.assert_allclose(in_base.gravity_torque(q), slope, rtol=0, atol=1e-7)


def test_forward_dynamics_undo_inverse_dynamics(arms):
    for seed, arm in enumerate(arms):
        drives = Drives(
            rotor_inertia=np.full(arm.n, 1e-5),
            gear=np.full(arm.n, 200.0),
            viscous=np.full(arm.n, 0.3),
            coulomb=np.full(arm.n, 0.2),
        )
        dynamics = Dynamics(arm, drives=drives)
        q, qd, qdd = states(arm, seed, 5)
        torque = dynamics.inverse(q, qd, qdd)
        np.testing.assert_allclose(dynamics.forward(q, qd, torque), qdd, rtol=0, atol=1e-10)


@pytest.mark.parametrize("m", [1, 63, 65, 130])
def test_a_batch_is_what_its_members_are(arms, m):
    for arm in arms[:7]:
        q, qd, qdd = states(arm, m, m)
        n = arm.n
        dynamics = Dynamics(arm, drives=Drives(viscous=np.ones(n), coulomb=np.ones(n)))
        some = [i for i in (0, 1, 62, 63, 64, 127, 128, m - 1) if i < m]  # about the blocks' edges
        for ask, motion in (
            (dynamics.inverse, (q, qd, qdd)),
            (dynamics.gravity_torque, (q,)),
            (dynamics.mass_matrix, (q,)),
            (dynamics.coriolis_matrix, (q, qd)),
            (dynamics.coriolis_torque, (q, qd)),
            (dynamics.forward, (q, qd, qdd)),
        ):
            batch = ask(*motion)
            assert len(batch) == m
            members = np.array([ask(*(rows[i] for rows in motion)) for i in some])
            scale = max(1.0, np.abs(members).max())
            np.testing.assert_allclose(batch[some], members, rtol=0, atol=1e-13 * scale)


def test_leading_axes_are_broadcast(arms):
    arm = arms[4]
    q, qd, qdd = states(arm, 0)
    many = np.stack([[q, -q, q]] * 2)
    torque = Dynamics(arm).inverse(many, qd, qdd)
    assert torque.shape == (2, 3, arm.n)
    np.testing.assert_allclose(torque[1, 2], Dynamics(arm).inverse(q, qd, qdd), atol=1e-12)


def test_a_payload_is_a_heavier_last_link(arms):
    for seed, arm in enumerate(arms[:10]):
        q, qd, _ = states(arm, seed)
        payload = Inertia(0.7, (0.1, -0.05, 0.2), np.diag([0.01, 0.02, 0.025]))
        loaded, empty = Dynamics(arm, payload=payload), Dynamics(arm)
        # the power of the payload's weight, from the tool's Jacobian
        T = arm.T_world_base @ arm.fk(q)
        J = arm.jacobian(q)
        weight = arm.T_world_base[:3, :3].T @ (0.0, 0.0, 0.7 * G)
        lever = arm.T_world_base[:3, :3].T @ (T[:3, :3] @ payload.com)
        wanted = J.T @ np.concatenate((weight, np.cross(lever, weight)))
        more = loaded.gravity_torque(q) - empty.gravity_torque(q)
        np.testing.assert_allclose(more, wanted, rtol=0, atol=1e-12)
        kinetic = 0.5 * qd @ (loaded.mass_matrix(q) - empty.mass_matrix(q)) @ qd
        v, w = J[:3] @ qd, J[3:] @ qd
        v_com = v + np.cross(w, lever)
        w_tool = arm.fk(q)[:3, :3].T @ w
        moving = 0.5 * 0.7 * v_com @ v_com + 0.5 * w_tool @ payload.tensor @ w_tool
        np.testing.assert_allclose(kinetic, moving, rtol=0, atol=1e-12)


def test_friction_and_rotors_add_up(arms):
    arm = arms[3]
    n = arm.n
    q, qd, qdd = states(arm, 0)
    qd[1] = 0.0
    rotor, gear = np.linspace(1e-6, 1e-5, n), np.linspace(50, 300, n)
    drives = Drives(rotor_inertia=rotor, gear=gear, viscous=np.full(n, 0.4), coulomb=np.ones(n))
    driven, plain = Dynamics(arm, drives=drives), Dynamics(arm)
    more = gear**2 * rotor * qdd + 0.4 * qd + np.sign(qd)
    np.testing.assert_allclose(
        driven.inverse(q, qd, qdd) - plain.inverse(q, qd, qdd), more, rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(
        driven.mass_matrix(q) - plain.mass_matrix(q), np.diag(gear**2 * rotor), atol=1e-13
    )
    np.testing.assert_allclose(driven.gravity_torque(q), plain.gravity_torque(q), atol=1e-13)
    np.testing.assert_allclose(driven.coriolis_torque(q, qd), plain.coriolis_torque(q, qd))


def test_gravity_pulls_as_the_world_says(arms):
    arm = arms[6]
    q = states(arm, 0)[0]
    floating = Dynamics(arm, gravity=np.zeros(3))
    np.testing.assert_array_equal(floating.gravity_torque(q), np.zeros(arm.n))
    up, down = Dynamics(arm, gravity=(0.0, 0.0, G)), Dynamics(arm)
    np.testing.assert_allclose(up.gravity_torque(q), -down.gravity_torque(q), rtol=1e-13)
    turn = np.eye(4)
    turn[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    turned = replace(arm, T_world_base=turn)
    sideways = Dynamics(turned, gravity=(G, 0.0, 0.0)).gravity_torque(q)
    level = replace(arm, T_world_base=np.eye(4))
    wanted = Dynamics(level, gravity=(0.0, -G, 0.0)).gravity_torque(q)
    np.testing.assert_allclose(sideways, wanted, rtol=0, atol=1e-13)


def test_the_answer_is_written_where_asked(arms):
    arm = arms[2]
    dynamics = Dynamics(arm)
    for motion in (states(arm, 0), states(arm, 0, 4)):
        out = np.full(motion[0].shape, np.nan)
        assert dynamics.inverse(*motion, out=out) is out
        np.testing.assert_allclose(out, dynamics.inverse(*motion), rtol=0, atol=1e-13)
    with pytest.raises(ValueError, match="out: want shape"):
        dynamics.inverse(*states(arm, 0), out=np.empty(arm.n + 1))
    with pytest.raises(TypeError, match="out: want an array of float64"):
        dynamics.inverse(*states(arm, 0), out=np.empty(arm.n, dtype=int))


def test_a_bare_call_says_whether_it_has(arms):
    arm = arms[4]
    dynamics = Dynamics(arm)
    inverse = dynamics.bare_inverse()
    q, qd, qdd = states(arm, 0)
    tau = np.empty(arm.n)
    assert inverse(q, qd, qdd, tau)
    np.testing.assert_array_equal(tau, dynamics.inverse(q, qd, qdd))
    assert not inverse(q, qd, np.full(arm.n, np.nan), tau)
    assert not inverse(q, qd[1:].copy(), qdd, tau)
    assert not inverse(q, qd, qdd, np.empty(arm.n + 1))


def test_what_is_no_motion_is_refused(arms):
    arm = arms[5]
    n = arm.n
    dynamics = Dynamics(arm)
    q = np.zeros(n)
    broken = q.copy()
    broken[1] = np.nan
    with pytest.raises(ValueError, match="qdd: want finite numbers"):
        dynamics.inverse(q, q, broken)
    with pytest.raises(ValueError, match=r"qd: want shape \(..., 7\)"):
        dynamics.inverse(q, np.zeros(n + 1), q)
    with pytest.raises(ValueError, match="want shapes that fit each other"):
        dynamics.inverse(np.zeros((2, n)), np.zeros((3, n)), q)
    with pytest.raises(ValueError, match="tau: want finite numbers"):
        dynamics.forward(q, q, broken)


def test_an_arm_of_unknown_weight_has_no_dynamics(random_arm):
    with pytest.raises(
        ValueError, match=r"want an inertia of each link, got none .* joint1, joint2"
    ):
        Dynamics(random_arm(0, 2, DHConvention.STANDARD))


def test_drives_are_checked(arms):
    arm = arms[0]
    with pytest.raises(ValueError, match="viscous: want numbers of at least zero"):
        Drives(viscous=[-1.0, 0.0])
    with pytest.raises(ValueError, match="gear: want 2 numbers, one a joint, got 3"):
        Dynamics(arm, drives=Drives(gear=[1.0, 1.0, 1.0]))
    with pytest.raises(ValueError, match="gravity: want shape"):
        Dynamics(arm, gravity=[0.0, 0.0])


def test_a_joint_without_inertia_has_no_acceleration(arms):
    nothing = Inertia(0.0, np.zeros(3), np.zeros((3, 3)))
    arm = arms[0]
    massless = replace(arm, links=tuple(replace(link, inertia=nothing) for link in arm.links))
    with pytest.raises(ValueError, match="a joint moves nothing that has an inertia"):
        Dynamics(massless).forward(*np.zeros((3, arm.n)))
