"""Job and arm files to spoil, and the command line to feed them to."""

from pathlib import Path

import pytest

from splinearm.cli.main import main

JOB = """\
schema = "splinearm-job/1"
name = "triangle"
title = "Triangle"
arm = "planar_2r"
start_deg = [20.0, 40.0]

[motion]
through = "bspline"
speed_mm_s = 200.0

[[waypoint]]
position_mm = [350.0, 100.0, 60.0]

[[waypoint]]
position_mm = [250.0, 250.0, 60.0]

[[waypoint]]
joints_deg = [30.0, 60.0]
through = "joint"
"""

ARM = """\
schema = "splinearm-arm/1"
name = "mine"
title = "Two links of my own"
convention = "dh-standard"

[[joint]]
name = "shoulder"
a_mm = 200.0
alpha_deg = 0.0
d_mm = 50.0
theta_deg = 0.0
min_deg = -150.0
max_deg = 150.0
max_speed_deg_s = 180.0
max_acceleration_deg_s2 = 400.0
mass_kg = 0.2
com_mm = [-100.0, 0.0, 0.0]
inertia_kg_m2 = [1e-5, 7e-4, 7e-4, 0.0, 0.0, 0.0]

[[joint]]
name = "elbow"
a_mm = 150.0
alpha_deg = 0.0
d_mm = 0.0
theta_deg = 0.0
min_deg = -140.0
max_deg = 140.0
max_speed_deg_s = 180.0
max_acceleration_deg_s2 = 400.0
mass_kg = 0.15
com_mm = [-75.0, 0.0, 0.0]
inertia_kg_m2 = [1e-5, 3e-4, 3e-4, 0.0, 0.0, 0.0]

[bus]
baud = 1000000
supply_v = 12.0

[[servo]]
name = "shoulder"
id = 1
model = "XM430-W350"
role = "leader"
joint = "shoulder"
zero_ticks = 2048

[[servo]]
name = "elbow"
id = 2
model = "XM430-W350"
role = "leader"
joint = "elbow"
zero_ticks = 2048

[poses]
home_deg = [20.0, 40.0]
"""


class CommandLine:
    """Runs commands in a folder of their own and keeps what they printed."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.folder = folder
        self._capsys = capsys
        self.out = ""
        self.err = ""

    def __call__(self, *words: object) -> int:
        try:
            code = main([str(word) for word in words])
        except SystemExit as leaving:
            code = int(leaving.code or 0)
        self.out, self.err = self._capsys.readouterr()
        return code

    def write(self, name: str, text: str) -> Path:
        file = self.folder / name
        file.write_text(text, encoding="utf-8")
        return file

    def job(self, *changes: tuple[str, str]) -> Path:
        return self.write("job.toml", _changed(JOB, changes))

    def arm(self, *changes: tuple[str, str]) -> Path:
        return self.write("mine.toml", _changed(ARM, changes))

    def files(self) -> set[str]:
        return {file.name for file in self.folder.iterdir()}


def _changed(text: str, changes: tuple[tuple[str, str], ...]) -> str:
    for old, new in changes:
        if old not in text:
            raise AssertionError(f"{old!r} is not in the file")
        text = text.replace(old, new, 1)
    return text


@pytest.fixture
def cli(tmp_path, capsys, monkeypatch) -> CommandLine:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "160")
    return CommandLine(tmp_path, capsys)
