"""Motion files: what is written comes back; what is not a motion is refused with its place."""

import json

import numpy as np
import pytest

from splinearm.config import load_cell, load_motion, save_motion
from splinearm.errors import ConfigError
from splinearm.trajectories.plan import plan_joint_move


@pytest.fixture(scope="module")
def limits():
    return load_cell("planar_2r").arm.limits


@pytest.fixture(scope="module")
def motion(limits):
    return plan_joint_move(limits, [0.1, -0.2], [1.3, 0.9])


def differences(one, other, ts):
    return [np.abs(a - b).max() for a, b in zip(one.sample(ts), other.sample(ts), strict=True)]


def test_json_keeps_every_bit_and_the_arm(tmp_path, motion):
    save_motion(tmp_path / "m.json", motion, arm="planar_2r")
    again = load_motion(tmp_path / "m.json")
    assert again.arm == "planar_2r"
    ts = np.linspace(0.0, motion.duration, 500)
    assert differences(again.trajectory, motion, ts) == [0.0, 0.0, 0.0]


@pytest.mark.parametrize(("name", "time_step"), [("m.ros.json", 1e-9), ("m.csv", 0.0)])
def test_rows_come_back_as_they_were_written(tmp_path, motion, limits, name, time_step):
    save_motion(tmp_path / name, motion, rate=50.0)
    again = load_motion(tmp_path / name, limits).trajectory
    ts = np.arange(0.0, motion.duration, 0.02)
    worst = differences(again, motion, ts)
    assert max(worst) <= 1e-10 + time_step * 30.0
    assert again.duration == pytest.approx(motion.duration, abs=1e-9)


def test_a_ros_message_may_name_its_joints_in_another_order(tmp_path, motion, limits):
    save_motion(tmp_path / "m.ros.json", motion)
    message = json.loads((tmp_path / "m.ros.json").read_text())
    message["joint_names"].reverse()
    for point in message["points"]:
        for key in ("positions", "velocities", "accelerations"):
            point[key].reverse()
    (tmp_path / "other.json").write_text(json.dumps(message))
    again = load_motion(tmp_path / "other.json", limits).trajectory
    assert np.allclose(again.at(0.3).q, motion.at(0.3).q, atol=1e-3)


def test_a_motion_of_an_arm_with_other_limits_gets_those_of_the_arm(tmp_path, motion, limits):
    save_motion(tmp_path / "m.json", motion)
    slow = limits.scaled(0.5)
    assert load_motion(tmp_path / "m.json", slow).trajectory.limits is slow


def test_nothing_is_overwritten_or_misnamed(tmp_path, motion):
    save_motion(tmp_path / "m.json", motion)
    with pytest.raises(ConfigError, match="is there already"):
        save_motion(tmp_path / "m.json", motion)
    with pytest.raises(ConfigError, match=r"ends in \.json, \.ros\.json or \.csv"):
        save_motion(tmp_path / "m.txt", motion)
    with pytest.raises(ConfigError, match="cannot be written"):
        save_motion(tmp_path / "none" / "m.csv", motion)
    with pytest.raises(ConfigError, match="cannot be read"):
        load_motion(tmp_path / "other.csv")


POINT = {"positions": [0.0, 0.0], "time_from_start": {"sec": 0, "nanosec": 0}}
LATER = {"positions": [0.1, 0.0], "time_from_start": {"sec": 1, "nanosec": 0}}
NAMES = ["joint1", "joint2"]


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("m.json", "{", "line 1: is not JSON"),
        ("m.json", "[1]", "want a motion, got list"),
        ("m.json", "[" * 100_000, "nested too deeply"),
        ("m.json", '{"format": 1}', "format: want"),
        ("m.ros.json", '{"points": []}', "want a message with joint_names and points"),
        ("m.ros.json", {"joint_names": NAMES, "points": []}, "points: want at least two"),
        ("m.ros.json", {"joint_names": ["a"], "points": [POINT]}, "joint_names: want joint1"),
        ("m.ros.json", {"joint_names": NAMES, "points": [POINT]}, "t: want two or more"),
        ("m.ros.json", {"joint_names": NAMES, "points": [{}, LATER]}, r"points\[0\]\.time_from"),
        (
            "m.ros.json",
            {"joint_names": NAMES, "points": [POINT, {**LATER, "positions": [1.0]}]},
            r"points\[1\]\.positions: want 2 numbers, got 1",
        ),
        (
            "m.ros.json",
            {"joint_names": NAMES, "points": [POINT, {**LATER, "positions": ["a", "b"]}]},
            "positions are not all numbers",
        ),
        ("m.csv", "", "is empty"),
        ("m.csv", "t_s,joint1_deg,joint9_deg\n", "line 1: want columns t_s,joint1_deg,joint2_deg"),
        ("m.csv", "t_s,joint1_deg,joint2_deg\n0,1\n", "line 2: want 3 numbers, got 2"),
        ("m.csv", "t_s,joint1_deg,joint2_deg\n0,1,x\n", "line 2: want numbers, got 0,1,x"),
        ("m.csv", "t_s,joint1_deg,joint2_deg\n", "t: want two or more"),
    ],
)
def test_a_file_that_holds_no_motion_is_refused_with_the_place(tmp_path, limits, name, text, says):
    (tmp_path / name).write_text(text if isinstance(text, str) else json.dumps(text))
    with pytest.raises(ConfigError, match=says) as refused:
        load_motion(tmp_path / name, limits)
    assert name in str(refused.value)


def test_a_motion_for_other_joints_is_refused(tmp_path, motion):
    save_motion(tmp_path / "m.json", motion)
    with pytest.raises(ConfigError, match="is for joints joint1, joint2; the arm has waist"):
        load_motion(tmp_path / "m.json", load_cell("wx250s").arm.limits)


def test_rows_without_an_arm_are_refused(tmp_path, motion):
    save_motion(tmp_path / "m.csv", motion)
    with pytest.raises(ConfigError, match="name the arm"):
        load_motion(tmp_path / "m.csv")
