"""The shipped arms against poses, Jacobians and torques that others computed from other files."""

import json
import tomllib
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from splinearm.config import Cell, load_cell, shipped_arms
from splinearm.drivers.chain import ServoRole
from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics import Arm, DHConvention, DHLink, Pose, quaternion

DATA = Path(__file__).parent.parent / "data" / "arms"
LICENCES = Path(__file__).parent.parent.parent / "licences"
STANDARD_GRAVITY = 9.81  # as in the cases
ARMS = shipped_arms()
CONVENTIONS = {
    "planar_2r": DHConvention.STANDARD,
    "open_manipulator_x": DHConvention.STANDARD,
    "wx250s": DHConvention.MODIFIED,
    "wx200": DHConvention.MODIFIED,
    "rx150": DHConvention.MODIFIED,
    "koch_v1_1": None,
    "omx_f": None,
}


@cache
def cell(name: str) -> Cell:
    return load_cell(name)


@cache
def cases(name: str) -> dict[str, np.ndarray]:
    found = json.loads((DATA / f"{name}.cases.json").read_text())["cases"]
    return {key: np.array([case[key] for case in found]) for key in found[0]}


def check_poses(arm: Arm, name: str) -> None:
    """Compare every pose of the cases: positions to 1e-12 m, orientations to 1e-12 rad."""
    known = cases(name)
    T = arm.fk(known["q"])
    np.testing.assert_allclose(T[:, :3, 3], known["position"], rtol=0.0, atol=1e-12)
    # q and -q are one rotation, and near no rotation arccos of w says nothing below 1e-8: the sine
    # of half the angle between two orientations is the length of their quotient's vector part
    between = quaternion.multiply(
        quaternion.conjugate(known["quat_wxyz"]), quaternion.from_matrix(T[:, :3, :3])
    )
    angles = 2.0 * np.arcsin(np.linalg.norm(between[:, 1:], axis=1))
    assert angles.max() < 1e-12


def com_jacobians(arm: Arm, q: np.ndarray) -> list[np.ndarray]:
    """Give for each link the Jacobian (6, n) of its centre of mass, from axes and levers."""
    Ts = arm.frames(q)
    joints = [T @ np.linalg.inv(link.T_joint_link) for T, link in zip(Ts, arm.links, strict=True)]
    found = []
    for i, link in enumerate(arm.links):
        com = (Ts[i] @ [*link.inertia.com, 1.0])[:3]
        J = np.zeros((6, arm.n))
        for j, T in enumerate(joints[: i + 1]):
            J[:3, j] = np.cross(T[:3, 2], com - T[:3, 3])
            J[3:, j] = T[:3, 2]
        found.append(J)
    return found


def gravity_torque(arm: Arm, q: np.ndarray) -> np.ndarray:
    """Give what the joints need to hold the arm, shape (n,), N m: sum of J_com^T m g."""
    return sum(
        link.inertia.mass * STANDARD_GRAVITY * J[2]
        for link, J in zip(arm.links, com_jacobians(arm, q), strict=True)
    )


def mass_matrix(arm: Arm, q: np.ndarray) -> np.ndarray:
    """Give the joint-space inertia, shape (n, n), without motors."""
    Ts = arm.frames(q)
    M = np.zeros((arm.n, arm.n))
    for T, link, J in zip(Ts, arm.links, com_jacobians(arm, q), strict=True):
        R = T[:3, :3]
        M += link.inertia.mass * J[:3].T @ J[:3]
        M += J[3:].T @ R @ link.inertia.tensor @ R.T @ J[3:]
    return M


def within_limits(limits: JointLimits, count: int) -> np.ndarray:
    share = np.random.default_rng(5).random((count, limits.n))
    return limits.q_min + share * (limits.q_max - limits.q_min)


def test_every_shipped_arm_has_its_cases():
    assert {path.name.removesuffix(".cases.json") for path in DATA.glob("*.cases.json")} == set(
        ARMS
    )
    assert set(CONVENTIONS) == set(ARMS)


@pytest.mark.parametrize("name", ARMS)
def test_an_arm_s_poses_are_those_of_its_maker_s_file(name):
    check_poses(cell(name).arm, name)


@pytest.mark.parametrize("name", ARMS)
def test_an_arm_s_jacobian_is_that_of_its_maker_s_file(name):
    known = cases(name)
    got = cell(name).arm.jacobian(known["q"])
    np.testing.assert_allclose(got, known["jacobian"], rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("name", ARMS)
def test_masses_and_their_places_give_the_gravity_torques(name):
    known = cases(name)
    got = [gravity_torque(cell(name).arm, q) for q in known["q"]]
    # the cases have 12 digits of up to 4 N m
    np.testing.assert_allclose(got, known["gravity_torque"], rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("convention", list(DHConvention), ids=lambda c: c.value)
@pytest.mark.parametrize("name", ARMS)
def test_dh_tables_of_either_convention_give_the_same_poses(name, convention):
    facts = json.loads((DATA / "dh_tables.json").read_text())
    columns, table = facts["columns"][convention.value], facts["arms"][name][convention.value]
    limits = cell(name).arm.limits
    rows = [
        DHLink(joint, **dict(zip(columns, row, strict=True)))
        for joint, row in zip(limits.names, table["rows"], strict=True)
    ]
    base = Pose(table["base_xyz"], table["base_quat_wxyz"]).matrix()
    tool = Pose(table["tool_xyz"], table["tool_quat_wxyz"]).matrix()
    arm = Arm.from_dh(name, rows, convention, limits, T_base_first=base, T_flange_tool=tool)
    check_poses(arm, name)


@pytest.mark.parametrize("name", ARMS)
def test_an_arm_is_described_as_its_file_says(name):
    arm = cell(name).arm
    assert arm.convention is CONVENTIONS[name]
    assert (arm.dh is None) is (arm.convention is None)
    assert cell(name).name == arm.name == name
    assert set(arm.limits.kinds) == {JointKind.REVOLUTE}
    np.testing.assert_array_equal(arm.T_world_base, np.eye(4))


@pytest.mark.parametrize("name", ARMS)
def test_home_is_inside_the_limits_and_not_singular(name):
    arm, home = cell(name).arm, cell(name).poses["home"]
    room = 5.0 * np.pi / 180.0
    assert (home >= arm.limits.q_min + room).all()
    assert (home <= arm.limits.q_max - room).all()
    J = arm.jacobian(home)
    J[:3] /= 0.2  # a usual reach, so that metres and radians weigh alike
    wanted = min(arm.n, 6)
    assert np.linalg.svd(J, compute_uv=False)[wanted - 1] > 0.2
    assert arm.frames(home)[:, 2, 3].min() > -1e-12, "a link below the table"
    assert arm.fk(home)[2, 3] > 0.05, "the tool near the table"


@pytest.mark.parametrize("name", ARMS)
def test_gravity_and_the_highest_acceleration_leave_torque_to_spare(name):
    arm = cell(name).arm
    worst = max(
        (
            (np.abs(mass_matrix(arm, q)) @ arm.limits.qdd_max + np.abs(gravity_torque(arm, q)))
            / arm.limits.torque_max
        ).max()
        for q in within_limits(arm.limits, 300)
    )
    assert worst < 0.75


@pytest.mark.parametrize("name", ARMS)
def test_speed_limits_leave_forty_percent_of_the_no_load_speed(name):
    chain, limits = cell(name).chain, cell(name).arm.limits
    for servo, qd_max in zip(chain.leaders_of(limits.names), limits.qd_max, strict=True):
        volts = 5.0 if servo.model.startswith("XL330") else 12.0
        figures = {figure.voltage: figure.speed for figure in servo.servo_model.no_load}
        assert qd_max <= 0.6 * figures[volts]


def test_servos_are_those_of_the_makers():
    ids = {name: [servo.servo_id for servo in cell(name).chain.servos] for name in ARMS}
    assert ids == {
        "planar_2r": [1, 2],
        "wx250s": [1, 2, 3, 4, 5, 6, 7, 8, 9],
        "wx200": [1, 2, 3, 4, 5, 6, 7],
        "rx150": [1, 2, 3, 4, 5, 6],
        "open_manipulator_x": [11, 12, 13, 14, 15],
        "omx_f": [11, 12, 13, 14, 15, 16],
        "koch_v1_1": [1, 2, 3, 4, 5, 6],
    }
    for name in ARMS:
        chain = cell(name).chain
        assert [s.name for s in chain.leaders_of(cell(name).arm.joint_names)]
        zeros = {servo.zero_ticks for servo in chain.servos}
        assert zeros == ({None} if name == "koch_v1_1" else {2048})


def test_shadows_follow_their_leaders_the_other_way_round():
    for name, pairs in {"wx250s": {3: 2, 5: 4}, "wx200": {3: 2}}.items():
        servos = {servo.servo_id: servo for servo in cell(name).chain.servos}
        shadows = {i: s for i, s in servos.items() if s.role is ServoRole.SHADOW}
        assert {i: s.settings["Secondary(Shadow) ID"] for i, s in shadows.items()} == pairs
        for i, leader in pairs.items():
            assert servos[i].joint == servos[leader].joint
            assert servos[i].settings["Drive Mode"] != servos[leader].settings["Drive Mode"]


def test_a_joint_with_a_shadow_has_twice_the_torque():
    np.testing.assert_array_equal(
        cell("wx250s").arm.limits.torque_max, [4.1, 8.2, 8.2, 4.1, 4.1, 1.5]
    )
    np.testing.assert_array_equal(
        cell("koch_v1_1").arm.limits.torque_max, [1.5, 1.5, 0.52, 0.52, 0.52]
    )


@pytest.mark.parametrize("name", ARMS)
def test_an_arm_file_carries_its_notice_and_its_licence_is_there(name):
    text = cell(name).file.read_text(encoding="utf-8")
    top = " ".join(line.lstrip("# ") for line in text.partition("\n\n")[0].splitlines())
    assert f"Notice: {cell(name).notice}" in top
    if name != "planar_2r":
        assert "Sources:" in top
        wanted = cell(name).licence.removeprefix("BSD")
        assert any(wanted in licence.name for licence in LICENCES.iterdir())


@pytest.mark.parametrize("name", ARMS)
def test_the_numbers_of_an_arm_file_are_readable(name):
    read: list[str] = []

    def keep(text: str) -> float:
        read.append(text)
        return float(text)

    tomllib.loads(cell(name).file.read_text(encoding="utf-8"), parse_float=keep)
    assert max(len(text.lstrip("-").replace(".", "")) for text in read) <= 16


@pytest.mark.parametrize("name", ARMS)
def test_inertias_give_the_mass_matrix_of_the_maker_s_file(name):
    known = json.loads((DATA / "mass_matrices.json").read_text())["arms"][name]
    for case in known:
        wanted = np.array(case["mass_matrix"])
        scale = np.sqrt(np.outer(np.diag(wanted), np.diag(wanted)))
        got = mass_matrix(cell(name).arm, np.array(case["q"]))
        # the inertias of links that were joined have 9 digits
        np.testing.assert_allclose(got / scale, wanted / scale, rtol=0.0, atol=2e-9)
