"""Bad input: one clear line with file, key and remedy; exit code 2; nothing moved or written."""

import os
import pty
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from splinearm.cli.main import REFUSED
from splinearm.config import load_job
from splinearm.errors import ConfigError

FIRST = "position_mm = [350.0, 100.0, 60.0]"


def refused(cli, *words, says):
    """Run a command that must be refused with one line that holds every one of ``says``."""
    before = cli.files()
    assert cli(*words) == REFUSED
    assert cli.files() == before
    lines = cli.err.strip().splitlines()
    assert len(lines) == 1, cli.err
    assert lines[0].startswith("splinearm: ")
    for part in says:
        assert part in lines[0], lines[0]


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("speed_mm_s", "sped_mm_s", ["job.toml: motion.sped_mm_s", "speed_mm_s"]),
        ("speed_mm_s = 200.0", "speed_m_s = 0.2", ["job.toml: motion.speed_m_s", "speed_mm_s"]),
        (FIRST, "position_cm = [35.0, 10.0, 6.0]", ["waypoint[0].position_cm", "position_mm"]),
        (FIRST, "position_mm = [350.0, 100.0]", ["waypoint[0].position_mm", "3 numbers"]),
        ("[20.0, 40.0]", "[20.0, 40.0, 10.0]", ["job.toml: start_deg", "2 numbers"]),
        (FIRST, "position_mm = [nan, 100.0, 60.0]", ["waypoint[0].position_mm", "finite"]),
        (FIRST, FIRST + "\nquat_wxyz = [1.0, 1.0, 0.0, 0.0]", ["waypoint[0].quat_wxyz", "1.414"]),
        (FIRST, 'position_mm = "here"', ["waypoint[0].position_mm"]),
        ('arm = "planar_2r"', 'arm = "planar_3r"', ["job.toml: arm", "planar_2r"]),
        ('through = "bspline"', 'through = "bsplin"', ["motion.through", "bspline"]),
        ("[20.0, 40.0]", "[20.0, 240.0]", ["start_deg", "joint2", "240 deg", "148.96 deg"]),
        ('schema = "splinearm-job/1"', 'schema = "splinearm-job/9"', ["schema", "splinearm-job/1"]),
        ("[motion]", "[motion", ["job.toml", "line"]),
        ("[motion]", "[motion]\nrate_hz = 0", ["job.toml: motion.rate_hz", "0"]),
        (FIRST, FIRST + "\nquat_wxyz = [1.0, 0.0, 0.0, 0.0]", ["job.toml", "waypoint 2", "orient"]),
    ],
)
def test_a_job_file_that_cannot_be_used(cli, old, new, says):
    refused(cli, "run", cli.job((old, new)), "--csv", "rows.csv", says=says)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("alpha_deg = 0.0\n", "", ["mine.toml: joint[0].alpha_deg", "missing"]),
        ("id = 2", "id = 1", ["mine.toml: servo[1].id", "1"]),
        ("a_mm = 200.0", "a_m = 0.2", ["mine.toml: joint[0].a_m", "a_mm"]),
        ("mass_kg = 0.2", "mass_kg = true", ["mine.toml: joint[0].mass_kg"]),
        ("max_deg = 150.0", "max_deg = inf", ["mine.toml: joint[0].max_deg", "finite"]),
        ('model = "XM430-W350"', 'model = "XM430-W999"', ["servo[0].model", "XM430-W350"]),
        ('joint = "elbow"', 'joint = "wrist"', ["mine.toml: servo[1].joint", "wrist"]),
        ('convention = "dh-standard"\n', "", ["mine.toml: convention", "missing"]),
    ],
)
def test_an_arm_file_that_cannot_be_used(cli, old, new, says):
    cli.arm((old, new))
    job = cli.job(('arm = "planar_2r"', 'arm = "mine.toml"'))
    refused(cli, "run", job, says=says)


def test_a_file_that_is_not_there(cli):
    refused(cli, "run", "nothing.toml", says=["nothing.toml"])


@pytest.mark.parametrize("command", ["plan", "run"])
def test_a_waypoint_out_of_reach_says_by_how_much(cli, command):
    job = cli.job((FIRST, "position_mm = [500.0, 400.0, 60.0]"))
    refused(cli, command, job, says=["job.toml", "waypoint 1", "out of reach by 90.3", "mm"])


def test_a_waypoint_that_only_a_joint_limit_keeps_away_names_the_joint(cli):
    cli.arm(("min_deg = -140.0\nmax_deg = 140.0", "min_deg = -10.0\nmax_deg = 60.0"))
    job = cli.job(
        ('arm = "planar_2r"', 'arm = "mine.toml"'),
        (FIRST, "position_mm = [100.0, 60.0, 50.0]"),
        ("position_mm = [250.0, 250.0, 60.0]", "position_mm = [200.0, 200.0, 50.0]"),
    )
    refused(cli, "plan", job, says=["job.toml", "waypoint 1", "elbow", "limit"])


def test_blends_that_do_not_go_together_name_the_file_and_the_waypoint(cli):
    job = cli.job(
        ('through = "bspline"', 'through = "line"'),
        ("[250.0, 250.0, 60.0]", "[250.0, 250.0, 60.0]\nblend_mm = 5.0"),
    )
    refused(cli, "plan", job, says=["job.toml", "waypoint 2", "blend of 5 mm"])


def test_a_job_for_another_arm(cli):
    refused(cli, "run", cli.job(), "--arm", "koch_v1_1", says=["planar_2r", "koch_v1_1"])


def test_a_port_that_is_not_there(cli):
    refused(cli, "run", cli.job(), "--on", "/dev/ttyNOWHERE", says=["/dev/ttyNOWHERE"])
    refused(cli, "scan", "/dev/ttyNOWHERE", says=["/dev/ttyNOWHERE"])


def test_a_port_that_is_not_permitted_says_how_to_be_permitted(cli):
    user = os.geteuid()
    refused(cli, "scan", "/dev/ttyNOWHERE", says=[])  # all modules are loaded from here on
    master, slave = pty.openpty()
    port = os.ttyname(slave)
    Path(port).chmod(0)
    try:
        if user == 0:
            os.seteuid(65534)  # root may open anything
        code = cli("scan", port)
    finally:
        os.seteuid(user)
        os.close(master)
        os.close(slave)
    assert code == REFUSED
    for part in (port, "you may not open it", "usermod -aG dialout"):
        assert part in cli.err


@pytest.mark.bus
def test_a_servo_that_does_not_answer_is_named(cli):
    from splinearm.config import load_cell
    from splinearm.sim.virtual_bus import VirtualBus

    cell = load_cell("planar_2r")
    with VirtualBus(cell.arm, cell.chain, cell.poses["home"]) as bus:
        bus.servos[2].mute = True
        refused(cli, "run", cli.job(), "--on", bus.port, says=["servo 2", "joint2", bus.port])


def test_files_are_never_overwritten(cli):
    cli.write("rows.csv", "mine")
    cli.write("run.png", "mine")
    refused(cli, "run", cli.job(), "--csv", "rows.csv", says=["rows.csv", "not overwritten"])
    refused(cli, "run", cli.job(), "--plot", "run.png", says=["run.png", "not overwritten"])
    refused(cli, "plan", cli.job(), "--plot", "run.png", says=["run.png", "not overwritten"])
    assert (cli.folder / "rows.csv").read_text() == "mine"


def test_a_picture_of_no_known_kind(cli):
    refused(cli, "run", cli.job(), "--plot", "run.bmpx", says=["run.bmpx", ".png"])
    refused(cli, "plan", cli.job(), "--plot", "plan", says=["plan", ".svg"])


def test_rows_and_picture_in_one_file(cli):
    says = ["run.png", "two files"]
    refused(cli, "run", cli.job(), "--csv", "run.png", "--plot", "run.png", says=says)


def test_a_folder_that_is_not_there(cli):
    refused(cli, "run", cli.job(), "--csv", "no/rows.csv", says=["no/rows.csv", "folder"])


def test_a_rate_that_is_none(cli):
    refused(cli, "run", cli.job(), "--rate", "0", says=["--rate", "0"])


@pytest.mark.parametrize("text", ["1,2,3", "1,x", "nan,1"])
def test_a_start_that_does_not_fit_the_arm(cli, text):
    refused(cli, "virtual-bus", "planar_2r", f"--start-deg={text}", says=["--start-deg", text])


def test_a_pose_that_the_arm_does_not_have(cli):
    refused(cli, "virtual-bus", "planar_2r", "--pose", "nirvana", says=["nirvana", "home"])


def test_no_command_shows_the_help(cli):
    assert cli() == REFUSED
    assert "splinearm demo" in cli.out


def test_errors_leave_no_thread_behind(cli):
    before = threading.active_count()
    cli("run", "nothing.toml")
    assert threading.active_count() == before


def test_a_motion_that_cannot_be_carried_out(cli):
    refused(cli, "run", "none.json", says=["none.json", "cannot be read"])
    refused(cli, "plan", cli.job(), "--save", "m.txt", says=["m.txt", ".ros.json"])
    cli("plan", cli.job(), "--save", "m.ros.json")
    refused(cli, "run", "m.ros.json", says=["m.ros.json", "name the arm"])
    cli("plan", cli.job(), "--save", "m.json")
    refused(cli, "run", "m.json", "--arm", "wx250s", says=["m.json", "joint1", "waist"])
    refused(cli, "plan", cli.job(), "--save", "m.json", says=["m.json", "is there already"])


@pytest.mark.parametrize(("where", "code"), [("> /dev/full", 1), (">&-", 0)])
def test_output_that_cannot_be_written_ends_in_one_line(where, code):
    command = f"{sys.executable} -m splinearm arms {where}"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, check=False)
    assert done.returncode == code
    said = "splinearm: cannot go on: [Errno 28] No space left on device\n"
    assert done.stderr == (said if code else "")


def test_a_file_that_no_name_can_be_is_refused():
    with pytest.raises(ConfigError, match="check its name"):
        load_job("a\0b.toml")
