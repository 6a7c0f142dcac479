import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from splinearm.config import Job, load_cell, load_job
from splinearm.errors import ConfigError
from splinearm.trajectories.waypoint import Facing, Move

ONE = "[[waypoint]]\nposition_mm = [400.0, 100.0, 60.0]\n"


@pytest.fixture
def load(arm_text, written) -> Callable[..., Job]:
    """A function that loads a job text beside its arm two.toml."""
    written(arm_text, "two.toml")
    return lambda text, **other: load_job(written(text, "job.toml"), **other)


def test_a_job_says_where_and_how(load, job_text, tmp_path):
    job = load(job_text)
    assert (job.name, job.title) == ("trial", "A trial")
    assert (job.file, job.arm) == (tmp_path / "job.toml", tmp_path / "two.toml")
    assert [point.move for point in job.waypoints] == [Move.LINE, Move.LINE]
    assert [point.speed for point in job.waypoints] == [0.1, 0.1]
    np.testing.assert_array_equal(job.waypoints[1].position, [0.4, 0.2, 0.06])
    assert not any(point.stop or point.blend or point.dwell for point in job.waypoints)


def test_what_a_job_does_not_say_is_usual(load, job_text, edited):
    job = load(edited(job_text, '[motion]\nthrough = "line"\nspeed_mm_s = 100.0\n', ""))
    assert (job.closed, job.limits_share, job.rate) == (False, 1.0, 100.0)
    assert job.position_tolerance == 2e-5
    assert {point.move for point in job.waypoints} == {Move.BSPLINE}
    assert {point.speed for point in job.waypoints} == {None}
    np.testing.assert_allclose(np.rad2deg(job.q_start), [10.0, 20.0])


def test_a_job_may_say_all_of_it(load, job_text, edited):
    text = edited(
        job_text,
        "[motion]",
        "start_deg = [-30, 45.5]\n[motion]\nclosed = true\nlimits_percent = 60\nrate_hz = 250\n"
        "position_tolerance_mm = 0.05",
    )
    job = load(text)
    assert (job.closed, job.limits_share, job.rate) == (True, 0.6, 250.0)
    assert job.position_tolerance == 5e-5
    np.testing.assert_allclose(np.rad2deg(job.q_start), [-30.0, 45.5])


def test_a_waypoint_may_differ_from_the_others(load, job_text):
    text = job_text + (
        '[[waypoint]]\nname = "corner"\nposition_mm = [300, 200, 60]\nspeed_mm_s = 40\n'
        "blend_mm = 5\n"
        '[[waypoint]]\nname = "rest"\nposition_mm = [300, 100, 60]\nthrough = "bspline"\n'
        "dwell_s = 0.5\n"
        '[[waypoint]]\njoints_deg = [15, 90]\nthrough = "joint"\nstop = true\n'
        "[[waypoint]]\nposition_mm = [400, 100, 60]\nquat_wxyz = [0.6, 0, 0, 0.8]\n"
        "[[waypoint]]\nposition_mm = [400, 100, 60]\nrpy_deg = [0, 0, 90]\n"
    )
    corner, rest, joints, quat, rpy = load(text).waypoints[2:]
    assert (corner.name, corner.speed, corner.blend, corner.stop) == ("corner", 0.04, 0.005, False)
    assert (rest.name, rest.move, rest.dwell, rest.stops) == ("rest", Move.BSPLINE, 0.5, True)
    assert (joints.move, joints.stop, joints.position) == (Move.JOINT, True, None)
    np.testing.assert_allclose(np.rad2deg(joints.q), [15.0, 90.0])
    np.testing.assert_allclose(quat.pose.quat, [0.6, 0.0, 0.0, 0.8])
    np.testing.assert_allclose(rpy.pose.matrix()[:3, 0], [0.0, 1.0, 0.0], atol=1e-15)
    np.testing.assert_array_equal(rpy.pose.p, [0.4, 0.1, 0.06])


def test_a_start_may_be_a_named_pose(load, job_text, edited, arm_text, written):
    written(edited(arm_text, "[poses]", "[poses]\naway_deg = [-90, 90]"), "two.toml")
    job = load(edited(job_text, "[motion]", 'start = "away"\n[motion]'))
    np.testing.assert_allclose(np.rad2deg(job.q_start), [-90.0, 90.0])


def test_an_arm_is_a_shipped_one_or_a_path_as_seen_from_the_job(
    written, job_text, edited, arm_text
):
    shipped = load_job(written(edited(job_text, "two.toml", "planar_2r"), "job.toml"))
    assert shipped.arm == load_cell("planar_2r").file
    inside = written(arm_text, "two.toml").parent / "arms"
    inside.mkdir()
    (inside / "two.toml").write_text(arm_text)
    job = load_job(written(edited(job_text, "two.toml", "arms/two.toml"), "job.toml"))
    assert job.arm == inside / "two.toml"


def test_sliding_joints_have_their_own_keys(sliding_arm_text, written, job_text, edited):
    written(sliding_arm_text, "two.toml")
    text = edited(job_text, "[motion]", "start_deg_mm = [0, 50]\n[motion]")
    text += "[[waypoint]]\njoints_deg_mm = [90, 120]\n"
    job = load_job(written(text, "job.toml"))
    np.testing.assert_allclose(job.q_start, [0.0, 0.05])
    np.testing.assert_allclose(job.waypoints[-1].q, [np.pi / 2, 0.12])


def test_another_file_of_the_same_arm_may_take_its_place(load, job_text, arm_text, written, edited):
    calibrated = written(edited(arm_text, "zero_ticks = 2048", "zero_ticks = 2051"), "mine.toml")
    assert load(job_text, arm=calibrated).arm == calibrated


def test_another_arm_may_not(load, job_text):
    with pytest.raises(ConfigError) as caught:
        load(job_text, arm="wx250s")
    assert caught.value.key == "arm"
    assert "this job is for 'two', not for 'wx250s'" in caught.value.reason


@pytest.mark.parametrize(
    ("change", "key", "remedy"),
    [
        (('title = "A trial"\n', ""), "title", "is missing; give a text"),
        (('arm = "two.toml"\n', ""), "arm", "is missing; give a text"),
        (
            ("two.toml", "planar2r"),
            "arm",
            "no shipped arm .*planar_2r.* and .*/planar2r is no file",
        ),
        (("two.toml", "tow.toml"), "arm", "/tow.toml is no file"),
        (("[motion]", 'start = "hom"\n[motion]'), "start", 'did you mean "home"'),
        (
            ("[motion]", "start_deg = [1]\n[motion]"),
            "start_deg",
            r"one a joint \(shoulder, elbow\), got 1",
        ),
        (
            ("[motion]", "start_deg = [0, 141]\n[motion]"),
            "start_deg",
            "joint 'elbow': position 141 deg is above its limit 140 deg",
        ),
        (
            ("[motion]", "start_rad = [0, 1]\n[motion]"),
            "start_rad",
            "did you mean|degrees: start_deg",
        ),
        (("[motion]", 'start = "home"\nstart_deg = [0, 0]\n[motion]'), "start", "take one of them"),
        (
            ('"line"', '"spline"'),
            "motion.through",
            'wants one of "bspline", "line", "arc", "joint"',
        ),
        (("speed_mm_s = 100.0", "speed_mm_s = 0"), "motion.speed_mm_s", "above 0, got 0"),
        (("speed_mm_s = 100.0", "speed_m_s = 0.1"), "motion.speed_m_s", "second: speed_mm_s"),
        (
            ("[motion]", "[motion]\nlimits_percent = 101"),
            "motion.limits_percent",
            "at most 100, got 101",
        ),
        (("[motion]", "[motion]\nlimits_percent = 0"), "motion.limits_percent", "above 0"),
        (("[motion]", "[motion]\nrate_hz = -1"), "motion.rate_hz", "of 1 or more, got -1"),
        (("[motion]", "[motion]\nclosed = 1"), "motion.closed", "wants true or false, got 1"),
        (("[motion]", "[motion]\nrate = 100"), "motion.rate", "this wants hertz: rate_hz"),
        (("[motion]", "[motin]"), "motin", "did you mean 'motion'"),
        ((ONE, ONE + "blend_mm = 5\nstop = true\n"), "waypoint[0].blend_mm", "contradicts stop"),
        ((ONE, ONE + "blend_mm = 5\ndwell_s = 1\n"), "waypoint[0].blend_mm", "contradicts dwell_s"),
        (
            (ONE, ONE + 'blend_mm = 5\nthrough = "bspline"\n'),
            "waypoint[0].blend_mm",
            'through = "line"',
        ),
        ((ONE, ONE + "blend_mm = -5\n"), "waypoint[0].blend_mm", "of 0 or more, got -5"),
        ((ONE, ONE + "dwell_s = -1\n"), "waypoint[0].dwell_s", "of 0 or more, got -1"),
        ((ONE, ONE + "dwell_ms = 100\n"), "waypoint[0].dwell_ms", "this wants seconds: dwell_s"),
        ((ONE, ONE + "blnd_mm = 1\n"), "waypoint[0].blnd_mm", "did you mean 'blend_mm'"),
        ((ONE, "[[waypoint]]\n"), "waypoint[0].position_mm", "is missing; give 3 numbers"),
        (
            (ONE, "[[waypoint]]\nposition_mm = [1, 2]\n"),
            "waypoint[0].position_mm",
            "wants 3 numbers",
        ),
        (
            (ONE, ONE + "joints_deg = [1, 2]\n"),
            "waypoint[0].position_mm",
            "says again what joints_deg",
        ),
        (
            (ONE, ONE + "quat_wxyz = [1, 0, 0, 1]\n"),
            "waypoint[0].quat_wxyz",
            r"got length 1.41421356; .* write \[0.707106781, 0, 0, 0.707106781\]",
        ),
        (
            (ONE, ONE + "quat_wxyz = [1, 0, 0, 0.002]\n"),
            "waypoint[0].quat_wxyz",
            "got length 1.000002",
        ),
        (
            (ONE, "[[waypoint]]\njoints_deg = [1, 2, 3]\n"),
            "waypoint[0].joints_deg",
            "wants 2 numbers",
        ),
        (
            (ONE, "[[waypoint]]\njoints_deg = [151, 2]\n"),
            "waypoint[0].joints_deg",
            "joint 'shoulder': position 151 deg is above its limit 150 deg",
        ),
        (("[[waypoint]]", "[[point]]"), "point", "did you mean|known"),
    ],
)
def test_a_job_that_cannot_be_used_is_refused(change, key, remedy, load, job_text, edited):
    with pytest.raises(ConfigError) as caught:
        load(edited(job_text, *change))
    assert Path(caught.value.file).name == "job.toml"
    assert caught.value.key == key
    assert re.search(remedy, caught.value.reason), caught.value.reason


def test_a_job_goes_somewhere(load, job_text):
    with pytest.raises(ConfigError) as caught:
        load(job_text[: job_text.index("[[waypoint]]")])
    assert caught.value.key == "waypoint"
    assert "give a [[waypoint]] table for each place" in caught.value.reason


def test_what_is_wrong_with_the_arm_is_said_of_the_arm_s_file(load, job_text, written, arm_text):
    load(job_text)
    written(arm_text.replace("a_mm = 300.0", 'a_mm = "x"'), "two.toml")
    with pytest.raises(ConfigError, match=r"two\.toml: joint\[0\]\.a_mm"):
        load(job_text)
    written(arm_text.replace("a_mm = 300.0", "a_mm = "), "two.toml")
    with pytest.raises(ConfigError, match=r"two\.toml: is not TOML.*line 11"):
        load(job_text)


def test_an_arm_is_no_job(arm_text, refusal):
    refusal(load_job, arm_text, "schema", 'wants "splinearm-job/1", got "splinearm-arm/1"')


ARC_KEYS = '\nthrough = "arc"\nposition_mm = [0.0, 300.0, 60.0]\n'


def test_arcs_are_read_with_their_point_or_their_axis(load, job_text, edited):
    through = ARC_KEYS + 'via_mm = [200.0, 200.0, 60.0]\nfacing = "kept"\n'
    via = load(edited(job_text, ONE, "[[waypoint]]" + through)).waypoints[0]
    assert via.move is Move.ARC
    assert via.arc.via == pytest.approx([0.2, 0.2, 0.06])
    assert via.facing is Facing.KEPT
    about = ARC_KEYS + "centre_mm = [0.0, 0.0, 0.0]\naxis = [0.0, 0.0, 2.0]\nturns = 2\n"
    helix = load(edited(job_text, ONE, "[[waypoint]]" + about)).waypoints[0]
    assert helix.arc.turns == 2
    assert helix.arc.normal == pytest.approx([0.0, 0.0, 2.0])
    assert helix.facing is Facing.FREE


@pytest.mark.parametrize(
    ("keys", "key", "says"),
    [
        ("", "waypoint[0].via_mm", "is missing, as is centre_mm"),
        ("via_mm = [1, 2]", "waypoint[0].via_mm", "3 numbers"),
        ("via_mm = [1, 2, 3]\nturns = 1", "waypoint[0].turns", "contradicts via_mm"),
        ("centre_mm = [1, 2, 3]\naxis = [0, 0, 0]", "waypoint[0].axis", "want a direction"),
        ("centre_mm = [1, 2, 3]", "waypoint[0].axis", "missing"),
        ("centre_mm = [1, 2, 3]\naxis = [0, 0, 1]\nturns = -1", "waypoint[0].turns", "0 or more"),
    ],
)
def test_an_arc_that_cannot_be_used_is_refused(keys, key, says, load, job_text, edited):
    with pytest.raises(ConfigError, match=says) as caught:
        load(edited(job_text, ONE, "[[waypoint]]" + ARC_KEYS + keys + "\n"))
    assert caught.value.key == key


def test_arcs_and_facings_are_asked_for_where_they_mean_something(load, job_text, edited):
    with pytest.raises(ConfigError, match="is for arcs"):
        load(edited(job_text, ONE, ONE + "via_mm = [1, 2, 3]\n"))
    joints = '[[waypoint]]\njoints_deg = [1, 2]\nfacing = "kept"\n'
    with pytest.raises(ConfigError, match=r"facing.*is for tool moves to a position"):
        load(edited(job_text, ONE, joints))


def test_what_else_limits_a_motion_is_read(load, job_text, edited):
    asked = "[motion]\njerk_time_s = 0.1\ntool_acceleration_mm_s2 = 500\ntorque_percent = 60"
    job = load(edited(job_text, "[motion]", asked))
    assert job.jerk_time == 0.1
    assert job.tool_acceleration == 0.5
    assert job.torque_share == 0.6
    plain = load(job_text)
    assert (plain.jerk_time, plain.tool_acceleration, plain.torque_share) == (None, None, None)
    with pytest.raises(ConfigError, match="above 0") as caught:
        load(edited(job_text, "[motion]", "[motion]\njerk_time_s = 0"))
    assert caught.value.key == "motion.jerk_time_s"
