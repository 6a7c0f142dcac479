"""Tables of cutters: in SI, with what is missing or wrong named."""

from math import inf, pi

import pytest

from splinearm.config.tool_table import load_tools
from splinearm.errors import ConfigError
from splinearm.toolpaths.cutter import Cutter, Tip

TABLE = """
schema = "splinearm-tools/1"

[[tool]]
number = 3
name = "6 mm end mill"
diameter_mm = 6
feed_mm_min = 900
plunge_mm_min = 300
spindle_rpm = 12000
step_down_mm = 2
step_over_percent = 40

[[tool]]
number = 7
tip = "point"
tip_angle_deg = 60
diameter_mm = 3.175
feed_mm_min = 600
plunge_mm_min = 200
cutting_length_mm = 8
"""


@pytest.fixture
def table(tmp_path):
    def read(text=TABLE):
        file = tmp_path / "tools.toml"
        file.write_text(text)
        return load_tools(file)

    return read


def test_cutters_come_in_si_with_what_is_left_to_them(table):
    tools = table()
    mill, point = tools[3], tools[7]
    assert (mill.name, mill.tip, mill.cutting_length) == ("6 mm end mill", Tip.FLAT, inf)
    assert mill.radius == pytest.approx(3e-3)
    assert mill.feed == pytest.approx(0.015)
    assert mill.plunge == pytest.approx(0.005)
    assert mill.speed == pytest.approx(400 * pi)
    assert mill.step_over == pytest.approx(2.4e-3)
    assert (point.name, point.speed) == ("tool 7", 0.0)
    assert point.step_down == pytest.approx(3.175e-3 / 2)
    assert point.cutting_length == pytest.approx(8e-3)


def test_what_a_tip_cuts_at_the_surface_follows_its_shape(table):
    mill, point = table()[3], table()[7]
    assert mill.radius_at(1e-6) == mill.radius
    assert point.radius_at(1e-3) == pytest.approx(1e-3 * 3**-0.5)
    assert point.radius_at(1.0) == point.radius
    facts = {"number": 1, "name": "b", "feed": 1, "plunge": 1, "step_down": 1, "step_over": 1e-3}
    ball = Cutter(diameter=6e-3, tip=Tip.BALL, **facts)
    assert ball.radius_at(3e-3) == pytest.approx(3e-3)
    assert ball.radius_at(0.6e-3) == pytest.approx(1.8e-3)  # sqrt(0.6 * 5.4)


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("number = 7", "number = 3", "tool[1].number"),
        ("number = 7", "", "tool[1].number"),
        ("diameter_mm = 6", "diameter_mm = 0", "tool[0].diameter_mm"),
        ("feed_mm_min = 900", "feed_mm_s = 15", "feed_mm_s"),
        ('tip = "point"', 'tip = "pointed"', "tool[1].tip"),
        ("step_over_percent = 40", "step_over_percent = 140", "step_over_percent"),
        ("tip_angle_deg = 60", "", "tip_angle_deg"),
        ("spindle_rpm = 12000", "spindel_rpm = 12000", "spindel_rpm"),
        ("splinearm-tools/1", "splinearm-arm/1", "schema"),
    ],
)
def test_what_is_wrong_is_named(table, old, new, key):
    with pytest.raises(ConfigError) as caught:
        table(TABLE.replace(old, new))
    assert key in str(caught.value)


@pytest.mark.parametrize(
    "wrong",
    [
        {"diameter": -1.0},
        {"step_over": 7e-3},
        {"tip_angle": 0.0},
        {"cutting_length": 0.0},
        {"number": -1},
        {"feed": inf},
    ],
)
def test_a_cutter_that_cannot_be_is_refused(wrong):
    facts = {"number": 1, "name": "a", "diameter": 6e-3, "feed": 0.01, "plunge": 0.01}
    facts |= {"step_down": 1e-3, "step_over": 2e-3}
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Cutter(**(facts | wrong))
