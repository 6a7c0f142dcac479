"""Jobs of pieces, and what grippers do in jobs, as files say it."""

import numpy as np
import pytest

from splinearm.config import SavedMotion, load_cell, load_job, save_motion
from splinearm.config.piece import GripAction
from splinearm.errors import ConfigError
from splinearm.trajectories.plan import plan_joint_move
from splinearm.trajectories.taught import TaughtMotion

HEAD = """schema = "splinearm-job/1"
name = "many"
title = "Many pieces"
arm = "planar_2r"
"""
REACH = '[[waypoint]]\nthrough = "joint"\njoints_deg = [10.0, 40.0]\n'
TAUGHT = """[[piece]]
name = "wave"
degree = 3
knots = [0.0, 0.0, 0.0, 0.0, 2.0, 2.0, 2.0, 2.0]
points_deg = [[20.0, 60.0], [20.0, 60.0], [30.0, 50.0], [30.0, 50.0]]
"""
GRIP = '[[piece]]\ngripper = "close"\n'


@pytest.fixture
def load(tmp_path):
    """Load a job text, beside a saved motion and another job."""
    limits = load_cell("planar_2r").arm.limits
    save_motion(tmp_path / "wave.json", plan_joint_move(limits, [0.1, 0.2], [0.4, 0.2]))
    (tmp_path / "reach.toml").write_text(HEAD + REACH)
    (tmp_path / "pieces.toml").write_text(HEAD + GRIP)

    def loaded(text):
        (tmp_path / "job.toml").write_text(HEAD + text)
        return load_job(tmp_path / "job.toml")

    return loaded


def test_pieces_are_read_in_their_order_with_what_they_are(load):
    job = load(
        '[motion]\ntiming = "fastest"\ntimes = "endless"\n'
        + TAUGHT
        + '[[piece]]\nmotion = "wave.json"\ntimes = 3\n[[piece]]\njob = "reach.toml"\n'
        + "[[piece]]\ngripper = 40\nforce_percent = 20\nwait_s = 0.5\nmust_hold = true\n"
    )
    wave, saved, reach, grip = job.pieces
    assert (job.timing, job.times) == ("fastest", None)
    assert isinstance(wave.content, TaughtMotion)
    assert isinstance(saved.content, SavedMotion)
    assert (wave.name, saved.name, saved.times) == ("wave", "piece 2", 3)
    assert reach.content.name == "many"
    assert isinstance(grip.content, GripAction)
    action = grip.content
    assert (action.percent, action.force, action.wait) == (40.0, 0.2, 0.5)
    assert action.must_hold


def test_a_job_of_pieces_begins_where_its_first_motion_does_unless_it_says_another_place(load):
    job = load(GRIP + TAUGHT)
    np.testing.assert_allclose(np.degrees(job.q_start), [20.0, 60.0])
    elsewhere = load("start_deg = [5.0, 6.0]\n" + TAUGHT)
    np.testing.assert_allclose(np.degrees(elsewhere.q_start), [5.0, 6.0])


def test_the_arm_stops_at_a_waypoint_for_its_gripper(load):
    job = load(REACH + 'gripper = "open"\n' + REACH)
    assert job.waypoints[0].stop
    assert job.grips[0].percent == 100.0
    assert list(job.grips) == [0]
    assert job.grips[0].words == "gripper: open"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[[piece]]\nname = 'x'\n", "piece[0]: is nothing; give a motion"),
        (GRIP + "motion = 'wave.json'\n", "piece[0].gripper: contradicts motion"),
        (GRIP + "speed = 3\n", "piece[0].speed: is not known here"),
        (GRIP + "times = 0\n", "wants a whole number from 1 to"),
        (GRIP + "times = 1000000000\n", "wants a whole number from 1 to"),
        ('[[piece]]\ngripper = "opne"\n', 'did you mean "open"?'),
        ("[[piece]]\ngripper = 101\n", "wants a number of at most 100"),
        ("[[piece]]\ngripper = -1\n", "wants a number of 0 or more"),
        (GRIP + "force_percent = 0\n", "force_percent: wants a number in percent above 0"),
        (GRIP + "wait_s = -1\n", "wait_s: wants a number in seconds of 0 or more"),
        ("[[piece]]\nmotion = 'wave.json'\nwait_s = 1\n", "wait_s: is for the gripper"),
        ("[[piece]]\nmotion = 'no.json'\n", "no.json is no file"),
        ("[[piece]]\njob = 'pieces.toml'\n", "has no waypoints; a piece is a job that has"),
        (GRIP + REACH, "piece: contradicts waypoint"),
        ("", "waypoint: is missing"),
        (TAUGHT.replace("[30.0, 50.0]]", "[30.0]]"), "points_deg[3]: wants lists of 2 numbers"),
        (REACH + "must_hold = true\n", "waypoint[0].must_hold: is for the gripper"),
        ("[motion]\ntimes = 0\n" + REACH, "wants a whole number from 1 to"),
        ("[motion]\ntimes = 'ever'\n" + REACH, 'wants a whole number or "endless"'),
        ("[motion]\ntiming = 'fast'\n" + REACH, 'did you mean "fastest"?'),
        (
            '[[waypoint]]\nthrough = "line"\nposition_mm = [400, 0, 60]\nblend_mm = 5\n'
            'gripper = "open"\n',
            "blend_mm: contradicts gripper",
        ),
    ],
)
def test_what_cannot_be_is_refused_with_its_key_in_one_line(load, text, words):
    with pytest.raises(ConfigError) as caught:
        load(text)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_ends_of_a_grippers_travel_are_read_and_checked(tmp_path):
    arm = load_cell("wx250s")
    assert arm.chain.gripper.grip.travel == (1802, 2875)
    text = arm.file.read_text()
    for old, new, words in (
        (
            "open_ticks = 2875",
            "open_ticks = 5000",
            "is beyond where the servo ends, 0 to 4095",
        ),
        ("open_ticks = 2875", "open_ticks = 1802", "want others than closed_ticks"),
        ("open_ticks = 2875", 'open_ticks = "here"', 'wants a whole number or "calibrate"'),
        ("open_ticks = 2875", "closing_force_percent = 0", "above 0"),
    ):
        file = tmp_path / "arm.toml"
        file.write_text(text.replace(old, new))
        with pytest.raises(ConfigError, match=words):
            load_cell(file)
    file.write_text(text.replace("open_ticks = 2875\n", ""))
    assert load_cell(file).chain.gripper.grip.travel is None


def test_a_joints_servo_has_no_ends_of_travel(tmp_path):
    arm = load_cell("wx250s")
    file = tmp_path / "arm.toml"
    file.write_text(
        arm.file.read_text().replace('role = "leader"', 'role = "leader"\nopen_ticks = 5', 1)
    )
    with pytest.raises(ConfigError, match="open_ticks: is not known here"):
        load_cell(file)
