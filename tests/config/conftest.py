import re
from collections.abc import Callable
from pathlib import Path

import pytest

from splinearm.errors import ConfigError

ARM = """\
schema = "splinearm-arm/1"
name = "two"
title = "Two joints"
convention = "dh-standard"

[tool]
xyz_mm = [250.0, 0.0, 0.0]

[[joint]]
name = "shoulder"
a_mm = 300.0
alpha_deg = 0.0
d_mm = 60.0
theta_deg = 0.0
min_deg = -150.0
max_deg = 150.0
max_speed_deg_s = 160.0
max_acceleration_deg_s2 = 600.0
mass_kg = 0.3
com_mm = [-150.0, 0.0, 0.0]
inertia_kg_m2 = [6e-5, 0.00228, 0.00228, 0.0, 0.0, 0.0]

[[joint]]
name = "elbow"
a_mm = 0.0
alpha_deg = 0.0
d_mm = 0.0
theta_deg = 0.0
min_deg = -140.0
max_deg = 140.0
max_speed_deg_s = 160.0
max_acceleration_deg_s2 = 600.0
mass_kg = 0.25
com_mm = [125.0, 0.0, 0.0]
inertia_kg_m2 = [5e-5, 0.0013, 0.0013, 0.0, 0.0, 0.0]

[bus]
supply_v = 12.0

[[servo]]
name = "one"
id = 1
model = "XM430-W350"
role = "leader"
joint = "shoulder"
zero_ticks = 2048
[servo.registers]
velocity_limit = 200

[[servo]]
name = "helper"
id = 2
model = "XM430-W350"
role = "shadow"
joint = "shoulder"
zero_ticks = 2048
[servo.registers]
drive_mode = 1
secondary_id = 1

[[servo]]
name = "three"
id = 3
model = "XL430-W250"
role = "leader"
joint = "elbow"
zero_ticks = 2048

[[servo]]
name = "hand"
id = 4
model = "XL430-W250"
role = "gripper"
zero_ticks = "calibrate"

[poses]
home_deg = [10.0, 20.0]
"""

SLIDING_ARM = """\
schema = "splinearm-arm/1"
name = "slider"
title = "A joint that turns and one that slides"
convention = "frames"

[[joint]]
name = "turn"
xyz_mm = [0.0, 0.0, 100.0]
axis = [0.0, 0.0, 1.0]
min_deg = -180.0
max_deg = 180.0
max_speed_deg_s = 90.0
max_acceleration_deg_s2 = 360.0
max_torque_nm = 4.0

[[joint]]
name = "slide"
kind = "prismatic"
xyz_mm = [0.0, 0.0, 50.0]
axis = [1.0, 0.0, 0.0]
min_mm = 0.0
max_mm = 200.0
max_speed_mm_s = 150.0
max_acceleration_mm_s2 = 500.0
max_force_n = 20.0

[poses]
home_deg_mm = [90.0, 120.0]
"""

JOB = """\
schema = "splinearm-job/1"
name = "trial"
title = "A trial"
arm = "two.toml"

[motion]
through = "line"
speed_mm_s = 100.0

[[waypoint]]
position_mm = [400.0, 100.0, 60.0]

[[waypoint]]
position_mm = [400.0, 200.0, 60.0]
"""


@pytest.fixture
def arm_text() -> str:
    """The text of an arm file with two joints and four servos."""
    return ARM


@pytest.fixture
def sliding_arm_text() -> str:
    """The text of an arm file with a sliding joint and no servos."""
    return SLIDING_ARM


@pytest.fixture
def job_text() -> str:
    """The text of a job for the arm of ``arm_text`` in a file two.toml beside it."""
    return JOB


@pytest.fixture
def written(tmp_path: Path) -> Callable[..., Path]:
    """A function that writes a text into a file and gives its path."""

    def write(text: str, name: str = "two.toml") -> Path:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture
def edited() -> Callable[..., str]:
    """A function that replaces the first place where a text stands, which must be there."""

    def edit(text: str, old: str, new: str) -> str:
        assert old in text
        return text.replace(old, new, 1)

    return edit


@pytest.fixture
def refusal(written: Callable[..., Path]) -> Callable[..., ConfigError]:
    """A function that loads a text as a file and gives the error, having checked what it says."""

    def refuse(load: Callable[[Path], object], text: str, key: str, remedy: str) -> ConfigError:
        path = written(text, "refused.toml")
        with pytest.raises(ConfigError) as caught:
            load(path)
        error = caught.value
        assert error.file == str(path)
        assert error.key == key
        assert re.search(remedy, error.reason), error.reason
        assert str(error).startswith(str(path))
        return error

    return refuse
