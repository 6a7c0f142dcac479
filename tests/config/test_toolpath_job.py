"""Job files of toolpaths."""

from math import pi

import pytest

from splinearm.config.toolpath_job import load_toolpath_job
from splinearm.errors import ConfigError
from splinearm.toolpaths.operation import Entry, Side
from splinearm.toolpaths.work import Kind

TOOLS = """\
schema = "splinearm-tools/1"
[[tool]]
number = 3
diameter_mm = 6
feed_mm_min = 600
plunge_mm_min = 200
"""
JOB = """\
schema = "splinearm-toolpath/1"
drawing = "part.dxf"
unit = "in"
tools = "tools.toml"
dialect = "grbl"
tolerance_mm = 0.02

[[operation]]
kind = "profile"
tool = 3
layers = "a, b"
side = "inside"
depth_mm = 4
top_mm = -1
step_down_mm = 2
step_over_percent = 50
direction = "conventional"
entry = "ramp"
ramp_deg = 5
lead_mm = 2
stock_mm = 0.2
blend_mm = 0.02
finish = true
tabs = 3

[[operation]]
kind = "drill"
tool = 3
depth_mm = 8
peck_mm = 2
"""


@pytest.fixture
def load(tmp_path):
    (tmp_path / "tools.toml").write_text(TOOLS)

    def load(text):
        file = tmp_path / "job.toml"
        file.write_text(text)
        return load_toolpath_job(file)

    return load


def test_a_job_says_all_of_its_operations(load, tmp_path):
    job = load(JOB)
    assert job.drawing == tmp_path / "part.dxf"
    assert (job.unit, job.dialect.name) == ("in", "grbl")
    assert (job.exactness.tolerance, job.exactness.joining) == (2e-5, 1e-5)
    assert not job.exactness.splines
    profile, drill = job.works
    assert (profile.kind, profile.layers, profile.side) == (Kind.PROFILE, ("a", "b"), Side.INSIDE)
    milling = profile.milling
    assert (milling.depth, milling.top, milling.down, milling.over) == (4e-3, -1e-3, 2e-3, 3e-3)
    assert (milling.climb, milling.entry, milling.finish) == (False, Entry.RAMP, True)
    assert milling.ramp_angle == pytest.approx(pi / 36)
    assert milling.blend == 2e-5
    assert (profile.tabs.count, profile.tabs.length, profile.tabs.height) == (3, 5e-3, 1.5e-3)
    assert (drill.kind, drill.peck, drill.tabs, drill.layers) == (Kind.DRILL, 2e-3, None, ())
    assert drill.milling.cutter.number == 3


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("tool = 3", "tool = 4", "operation[0].tool"),
        ('kind = "profile"', 'kind = "cut"', "operation[0].kind"),
        ("stock_mm = 0.2", "stock_mm = 0", "operation[0].depth_mm"),
        ("depth_mm = 4", "depth = 4", "operation[0].depth"),
        ("lead_mm = 2", "leed_mm = 2", "operation[0].leed_mm"),
        ("tabs = 3", "tabs = -1", "operation[0].tabs"),
        ('dialect = "grbl"', 'dialect = "fanuc"', "dialect"),
        ('unit = "in"', 'unit = "yd"', "unit"),
        ('tools = "tools.toml"', 'tools = "none.toml"', ""),
    ],
)
def test_a_wrong_job_names_its_key(old, new, key, load):
    assert old in JOB
    with pytest.raises(ConfigError) as caught:
        load(JOB.replace(old, new, 1))
    assert caught.value.key == key


def test_a_job_without_operations_is_refused(load):
    with pytest.raises(ConfigError, match="operation"):
        load(JOB.split("[[operation]]", maxsplit=1)[0])
