"""What holds for the package as a whole."""

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

import splinearm

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "splinearm"

PUBLIC = {
    "ArcAbout",
    "ArcThrough",
    "Arm",
    "BSpline",
    "DHConvention",
    "DHLink",
    "Facing",
    "Guard",
    "JointLimits",
    "JointSetpoint",
    "JointState",
    "JointTrajectory",
    "Loop",
    "MotionLimits",
    "Move",
    "Pose",
    "Recorder",
    "SplinearmError",
    "Tolerances",
    "Waypoint",
    "load_cell",
    "load_job",
    "load_motion",
    "open_arm",
    "plan",
    "plan_job",
    "point_to_point",
    "run_job",
    "save_motion",
    "shipped_arms",
}


def test_the_front_door_has_just_these_names():
    assert set(dir(splinearm)) == PUBLIC


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_every_public_name_is_there_and_documented(name):
    assert getattr(splinearm, name).__doc__


def test_a_name_that_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        splinearm.nonsense  # noqa: B018 - the access is the test


def _modules_after(statement):
    code = f"import sys; {statement}; print(' '.join(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_importing_the_package_loads_no_library():
    loaded = _modules_after("import splinearm")
    assert not loaded & {
        "numpy",
        "numba",
        "mujoco",
        "dynamixel_sdk",
        "serial",
        "rich",
        "matplotlib",
    }


def test_asking_for_help_loads_no_library():
    statement = "from splinearm.cli.main import build_parser; build_parser().format_help()"
    loaded = _modules_after(statement)
    assert not loaded & {
        "numpy",
        "numba",
        "mujoco",
        "dynamixel_sdk",
        "serial",
        "rich",
        "matplotlib",
    }


def test_planning_loads_neither_simulator_nor_servos():
    loaded = _modules_after("import splinearm; splinearm.plan; splinearm.load_job")
    assert not loaded & {"numba", "mujoco", "dynamixel_sdk", "serial", "matplotlib", "scipy"}


def _sources():
    return sorted(SOURCE.rglob("*.py"))


@pytest.mark.parametrize("file", _sources(), ids=lambda file: str(file.relative_to(SOURCE)))
def test_no_file_is_too_long_to_read(file):
    # the errors are one tree, drawn on top of their file: a second file would hide half of it
    longest = 600 if file.name == "errors.py" else 400
    assert len(file.read_text(encoding="utf-8").splitlines()) <= longest


def test_only_the_command_line_prints():
    for file in _sources():
        if "cli" in file.parts:
            continue
        calls = [
            node.func.id
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        ]
        assert "print" not in calls, file


def test_every_module_can_be_imported_by_itself():
    for file in _sources():
        module = ".".join(file.relative_to(SOURCE.parent).with_suffix("").parts)
        importlib.import_module(module.removesuffix(".__init__"))


def test_a_python_that_is_too_old_is_told_so_in_one_line():
    code = 'import sys; sys.version_info = (3, 10, 4, "final", 0); import splinearm.cli.main'
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == (
        "splinearm: C01 Python is too old: this is 3.10.4; install Python 3.11 or newer\n"
    )
