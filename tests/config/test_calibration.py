"""Calibrations as files: read strictly, written whole, never lost."""

import logging
import re
import subprocess
import sys
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.backends import centred
from splinearm.config import load_cell
from splinearm.config.calibration import (
    calibrated,
    calibration_file,
    calibration_names,
    find_calibration,
    fitting,
    rename_calibration,
    save_calibration,
    use_calibration,
)
from splinearm.config.calibration_table import (
    Calibration,
    ServoCalibration,
    calibration_text,
    read_calibration,
)
from splinearm.config.folder import write_whole
from splinearm.errors import ConfigError
from splinearm.units import DEG

ARM = "wx250s"
THEN = datetime(2026, 11, 22, 19, 30, tzinfo=UTC)


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("SPLINEARM_HOME", str(tmp_path))
    return tmp_path


def elbow(**changes):
    facts = {
        "name": "elbow",
        "servo_id": 4,
        "model": "XM430-W350",
        "zero_ticks": 2047,
        "zero_by": "the pose 'zero'",
        "travel": (-120.0 * DEG, 90.5 * DEG),
        "settings": {"Drive Mode": 1, "Operating Mode": 3, "Homing Offset": 0},
    }
    return ServoCalibration(**{**facts, **changes})


GRIPPER = ServoCalibration(
    name="gripper", servo_id=9, model="XL430-W250", open_ticks=2600, closed_ticks=1800
)


def made(*servos, name="default", date=THEN, **more):
    return Calibration(arm=ARM, name=name, date=date, servos=servos or (elbow(),), **more)


def test_without_a_calibration_a_cell_is_as_its_file_says():
    cell = load_cell(ARM)
    assert calibrated(cell) is cell
    assert find_calibration(ARM) is None
    assert calibration_names(ARM) == ()


def test_a_calibration_overrides_what_it_names_and_nothing_else(caplog):
    cell = load_cell(ARM)
    save_calibration(made(elbow(), GRIPPER, usb_serial="FT1"))
    with caplog.at_level(logging.INFO):
        own = calibrated(cell)
    assert "calibration 'default' of 2026-11-22" in caplog.text
    spec, before = own.chain.servo("elbow"), cell.chain.servo("elbow")
    assert (spec.zero_ticks, spec.settings["Drive Mode"]) == (2047, 1)
    assert spec.settings["Velocity Limit"] == before.settings["Velocity Limit"]
    assert own.chain.servo("gripper").grip.travel == (1800, 2600)
    assert own.chain.servo("gripper").grip.force == cell.chain.servo("gripper").grip.force
    for name in ("waist", "shoulder_shadow"):
        assert own.chain.servo(name) is cell.chain.servo(name)
    assert own.arm is cell.arm


@pytest.mark.property
@settings(max_examples=40)
@given(
    name=st.text(min_size=1).filter(lambda text: text.strip()),
    zero=st.integers(-(2**19), 2**19),
    low=st.floats(-6.0, 0.0),
    serial=st.none() | st.text(min_size=1).filter(lambda text: text.strip()),
)
def test_a_file_says_what_was_saved(tmp_path_factory, name, zero, low, serial):
    file = tmp_path_factory.mktemp("said") / "default.toml"
    servo = elbow(name=name, zero_ticks=zero, travel=(low, 1.0), zero_by=name)
    file.write_text(calibration_text(made(servo, usb_serial=serial)), encoding="utf-8")
    read = read_calibration(file)
    (said,) = read.servos
    assert (read.arm, read.name, read.date, read.usb_serial) == (ARM, "default", THEN, serial)
    assert (said.name, said.zero_ticks, said.zero_by) == (name, zero, name)
    assert said.travel == pytest.approx((low, 1.0), abs=1e-5)
    assert dict(said.settings) == dict(servo.settings)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("zero_ticks = 2047", "zero_ticks = true", r"servo\[0\].zero_ticks: wants .*\(line 10\)"),
        ("zero_ticks = 2047", "", r"servo\[0\].zero_ticks: is missing.*\(line 6\)"),
        ("zero_ticks", "zero_tick", r"servo\[0\].zero_ticks: is missing"),
        ("homing_offset", "goal_current", r"registers.goal_current: is no register .*\(line 16\)"),
        ("operating_mode = 3", "operating_mode = 9", r"has the modes 0, 1, 3.*\(line 15\)"),
        ("drive_mode = 1", "drive_mode = 700", r"drive_mode: wants a whole number.*\(line 14\)"),
        ("date = ", 'date = "tomorrow" # ', r"date: .*\(line 4\)"),
        ("+00:00", "", r"date: wants its time zone too.*\(line 4\)"),
        ("[-120.000, 90.500]", "[90.0, -120.0]", r"wants the lowest first.*\(line 12\)"),
        ("[[servo]]", "[servo]", r"servo: wants tables \[\[servo\]\]"),
        ("calibration/1", "calibration/2", r"schema: wants .*\(line 1\)"),
        ('"elbow"', '"elbow', r"is not TOML: .*line"),
        ('id = 4', 'id = 4\nnick = "e"', r"servo\[0\].nick: is not known here.*\(line 9\)"),
    ],
)  # fmt: skip
def test_a_broken_file_is_refused_with_file_key_and_line(old, new, message):
    file = save_calibration(made())
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))
    with pytest.raises(ConfigError, match=message) as caught:
        calibrated(load_cell(ARM))
    assert str(file) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("servo", "message"),
    [
        (elbow(name="knee"), r"no servo 'knee'; calibrate anew"),
        (elbow(servo_id=44), r"servo\[0\].id: is 44 of servo 'elbow', in the arm's file 4"),
        (elbow(model="XM540-W270"), r"servo\[0\].model: is XM540-W270"),
        (elbow(zero_ticks=9000), r"joint 'elbow' may go to .* --joint elbow`"),
        (elbow(zero_ticks=-9000), r"joint 'elbow' may go to .* --joint elbow`"),
        (
            ServoCalibration(name="elbow", servo_id=4, model="XM430-W350", open_ticks=1,
                             closed_ticks=9),
            r"zero_ticks: is missing: 'elbow' is a leader",
        ),
        (
            ServoCalibration(name="gripper", servo_id=9, model="XL430-W250", zero_ticks=9),
            r"open_ticks: is missing: 'gripper' is a gripper",
        ),
    ],
)  # fmt: skip
def test_a_calibration_of_other_servos_is_refused_with_the_remedy(servo, message):
    save_calibration(made(servo))
    with pytest.raises(ConfigError, match=message) as caught:
        calibrated(load_cell(ARM))
    assert "splinearm calibrate wx250s" in str(caught.value)


def test_a_calibration_of_another_arm_or_under_another_name_is_refused():
    file = save_calibration(made())
    text = file.read_text()
    file.write_text(text.replace(f'arm = "{ARM}"', 'arm = "other"'))
    with pytest.raises(ConfigError, match="is of 'other', not of 'wx250s'"):
        calibrated(load_cell(ARM))
    file.write_text(text.replace('name = "default"', 'name = "mine"'))
    with pytest.raises(ConfigError, match="is 'mine' in a file called 'default'"):
        calibrated(load_cell(ARM))


def test_two_servos_of_one_name_are_refused():
    file = save_calibration(made(elbow(), elbow(servo_id=5)))
    with pytest.raises(ConfigError, match=r"servo\[1\].name: is also that of 'elbow'"):
        read_calibration(file)


def test_the_former_one_stays_under_its_date():
    save_calibration(made())
    later = made(elbow(zero_ticks=1), date=THEN + timedelta(days=1))
    save_calibration(later)
    save_calibration(later)
    assert calibration_names(ARM) == ("default", "default-20261122-193000")
    assert find_calibration(ARM).servos[0].zero_ticks == 1
    assert find_calibration(ARM, "default-20261122-193000").servos[0].zero_ticks == 2047


def test_one_that_grows_joint_by_joint_leaves_no_others_behind():
    first = made(elbow())
    save_calibration(first)
    save_calibration(first.with_servos(elbow(name="waist", servo_id=1)), over=first)
    assert calibration_names(ARM) == ("default",)
    assert [servo.name for servo in find_calibration(ARM).servos] == ["elbow", "waist"]


def test_one_that_was_changed_by_hand_stays_though_its_date_is_the_same():
    save_calibration(made(elbow()))
    mine = made(elbow(zero_ticks=5))
    save_calibration(mine)
    assert calibration_names(ARM) == ("default", "default-20261122-193000")
    save_calibration(made(elbow(zero_ticks=9)), over=made(elbow()))  # not what is there
    assert len(calibration_names(ARM)) == 3


def test_taking_two_in_use_by_turns_leaves_no_copies_behind():
    for name, zero in (("summer", 5), ("winter", 6)):
        save_calibration(made(elbow(zero_ticks=zero), name=name))
    for name in ("summer", "winter", "summer", "winter"):
        use_calibration(ARM, name)
    assert set(calibration_names(ARM)) == {"default", "summer", "winter"}


def test_what_no_longer_fits_the_arm_s_file_is_left_out():
    both = made(elbow(), elbow(name="knee", servo_id=44))
    assert [servo.name for servo in fitting(load_cell(ARM), both).servos] == ["elbow"]


def test_a_broken_one_is_put_aside_as_it_is():
    file = save_calibration(made())
    file.write_text("this is no TOML")
    save_calibration(made())
    assert find_calibration(ARM) is not None
    aside = file.with_name("default-broken.toml.txt")
    assert aside.read_text() == "this is no TOML"
    assert calibration_names(ARM) == ("default",)


def test_one_can_be_renamed_and_taken_in_use():
    save_calibration(made(elbow(zero_ticks=2049)))
    rename_calibration(ARM, "default", "summer")
    assert calibrated(load_cell(ARM)).chain.servo("elbow").zero_ticks == 2048
    assert calibrated(load_cell(ARM), "summer").chain.servo("elbow").zero_ticks == 2049
    use_calibration(ARM, "summer")
    assert calibrated(load_cell(ARM)).chain.servo("elbow").zero_ticks == 2049
    with pytest.raises(ConfigError, match="is there already"):
        rename_calibration(ARM, "summer", "default")


@pytest.mark.parametrize("name", ["../x", "", "a/b", ".hidden", "x" * 200, "a b"])
def test_a_name_must_be_one_that_a_file_can_have_everywhere(name):
    with pytest.raises(ConfigError, match="is no name of a calibration"):
        calibration_file(ARM, name)


def test_one_that_is_not_there_is_refused_with_those_that_are():
    save_calibration(made())
    with pytest.raises(ConfigError, match="no such calibration of wx250s; there are: default"):
        calibrated(load_cell(ARM), "winter")


def test_the_name_of_an_arm_may_have_anything_in_it(home):
    file = calibration_file("../a b/ü")
    assert file.parent.parent == home / "calibrations"
    assert calibration_file("..").parent.parent == home / "calibrations"


def test_virtual_servos_are_never_calibrated_by_it():
    save_calibration(made())
    cell = load_cell(ARM)
    assert centred(cell.chain).servo("elbow").zero_ticks == 2048


def test_what_cannot_be_written_leaves_what_was_there(home):
    file = save_calibration(made())
    before = file.read_text()
    (home / "calibrations").rename(home / "elsewhere")
    (home / "calibrations").write_text("a file where the folder should be")
    with pytest.raises(ConfigError, match="cannot be written"):
        write_whole(file, "new")
    (home / "calibrations").unlink()
    (home / "elsewhere").rename(home / "calibrations")
    assert file.read_text() == before


def test_a_writer_that_is_killed_leaves_a_whole_file(home):
    """Killed anywhere in the middle: at every moment the file is one of those that were written."""
    file = home / "one.toml"
    code = (
        "import itertools, sys; from pathlib import Path\n"
        "from splinearm.config.folder import write_whole\n"
        "for k in itertools.count():\n"
        "    write_whole(Path(sys.argv[1]), f'{k}\\n' * 20000)\n"
        "    print(k, flush=True)\n"
    )
    with subprocess.Popen([sys.executable, "-c", code, str(file)], stdout=subprocess.PIPE) as one:
        for _ in range(8):
            one.stdout.readline()
            lines = file.read_text().splitlines()
            assert (len(lines), len(set(lines))) == (20000, 1)
        one.kill()
    lines = file.read_text().splitlines()
    assert (len(lines), len(set(lines))) == (20000, 1)


def test_drafts_and_links_that_lead_nowhere_are_no_calibrations(home):
    save_calibration(made())
    folder = calibration_file(ARM).parent
    Path(folder / ".default.toml.77").write_text("half")
    Path(folder / "gone.toml").symlink_to(folder / "nowhere")
    assert calibration_names(ARM) == ("default",)
    assert re.fullmatch(r"default\.toml", calibration_file(ARM).name)
