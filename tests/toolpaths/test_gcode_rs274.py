"""Our reader and writer beside LinuxCNC's own interpreter, where it is installed."""

import re
from itertools import pairwise
from math import pi

import numpy as np
import pytest

from splinearm.curves.bspline import BSpline
from splinearm.toolpaths.action import ArcFeed, Feed, Rapid, SplineFeed
from splinearm.toolpaths.gcode_dialect import DIALECTS
from splinearm.toolpaths.gcode_interpreter import run_gcode
from splinearm.toolpaths.gcode_writer import write_gcode

MM = 1e-3
CALL = re.compile(r"^\s*\d+\s+N\S*\s+(\w+)\((.*)\)\s*$")


@pytest.fixture
def oracle(tmp_path, rs274):
    """Give a function that lets LinuxCNC read a program: kinds and ends of its ways, in mm."""

    def read(text):
        file = tmp_path / "part.ngc"
        file.write_text(text)
        lines = rs274(file).stdout.splitlines()
        return ways([match.groups() for match in map(CALL.match, lines) if match])

    return read


def ways(calls):
    found, unit, offsets = [], 1.0, {"SET_G5X_OFFSET": 0.0, "SET_G92_OFFSET": 0.0}
    for name, words in calls:
        values = words.split(",")
        if name == "USE_LENGTH_UNITS":
            unit = 1.0 if "MM" in words else 25.4
        elif name in offsets:
            first = 1 if name == "SET_G5X_OFFSET" else 0
            offsets[name] = unit * np.array(values[first : first + 3], dtype=float)
        elif name in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED"):
            end = unit * np.array(values[:3], dtype=float) + sum(offsets.values())
            found.append(("rapid" if name == "STRAIGHT_TRAVERSE" else "feed", end))
        elif name == "ARC_FEED":
            found.append(("arc", unit * np.array(values[:6], dtype=float)))
        elif name.startswith("NURBS"):
            found.append(("spline", None))
    return found


def ours(file):
    kinds = {Rapid: "rapid", Feed: "feed", ArcFeed: "arc", SplineFeed: "spline"}
    return [(kinds[type(a)], a) for a in run_gcode(file) if type(a) in kinds]


def moved(pairs):
    """Drop ways that go nowhere, which the two count in their own ways."""
    place, kept = np.zeros(3), []
    for kind, end in pairs:
        if kind in ("rapid", "feed"):
            if np.abs(end - place).max() < 2e-4:
                continue
            place = end
        kept.append((kind, end))
    return kept


PROGRAMS = {
    "lines": "G21 G90 F100\nG0 X1 Y2\nG1 Z-1\nG91 X2\nG20\nG1 X0.5\nG90 G21 X0\n",
    "offsets": "G21 F1\nG10 L2 P2 X100 Y10\nG55 G0 X1\nG92 X0\nG0 X5\nG92.2\nG0 X5\n"
    "G92.1\nG54 X0\n",
    "local": "G21\nG52 X3\nG0 X0\nG53 G0 X0\nG10 L20 P1 X7\nG0 X0\nG92.1\nG0 X0\n",
    "homes": "G21\nG0 X5 Y5\nG28.1\nG0 X9\nG28\nG30 X1\n",
    "modes": "G21 M70 G91\nG0 X1\nM72\nG0 X1 Y3\n",
    "drill": "G21 G0 Z10\nF60 G99 G81 X1 Y2 Z-3 R1\nX4\nG80\nG98 G82 X8 Z-2 R1 P0.1\nX9\nG80\n",
    "peck": "G21 F60\nG83 X0 Z-2.5 R0 Q1\nX3\nG80\nG73 X5 Z-2.5 R0 Q1\nG80\n",
    "bore": "G21 F60 S100 M3\nG85 X1 Z-1 R0\nX2\nG89 X3 Z-1 R0 P0.1\nG86 X4 Z-1 R0 P0.1\nG80\n",
    "row": "G21 F60 G91\nG81 X1 Z-1 R1 L3\nG80\n",
    "sums": "#1=3\n#2=[#1*2+1]\nG21 G0 X#2 Y[2**3 mod 5] Z-[sin[30]]\nX[round[2.5]] Y[fix[-2.5]]\n",
    "loop": "G21\no1 while [#5 lt 5]\n#5=[#5+1]\no2 if [#5 mod 2]\nG0 X#5\no2 else\n"
    "G0 Y#5\no2 endif\no1 endwhile\no3 repeat [2]\nG91 G0 X1\no3 endrepeat\n",
    "call": "G21\no<step> sub\nG0 X#1 Y#2\no<step> endsub [#1+1]\no<step> call [4] [5]\n"
    "G0 Z#<_value>\n",
}  # fmt: skip


@pytest.mark.parametrize("name", PROGRAMS)
def test_places_are_those_of_linuxcnc(tmp_path, oracle, name):
    text = PROGRAMS[name] + "M2\n"
    wanted = moved(oracle(text))
    found = moved([(kind, a.end / MM) for kind, a in ours(tmp_path / "part.ngc")])
    assert [kind for kind, _ in found] == [kind for kind, _ in wanted]
    np.testing.assert_allclose([e for _, e in found], [e for _, e in wanted], atol=2e-3)


@pytest.mark.parametrize("plane", [17, 18, 19])
@pytest.mark.parametrize("code", ["G2", "G3"])
@pytest.mark.parametrize(
    "words",
    ["{a}9 {b}5 {i}2", "{a}5 {b}5 {i}2 P2", "{a}7 {b}7 R2", "{a}7 {b}7 R-2", "{i}2 {c}3 P2"],
)
def test_arcs_are_those_of_linuxcnc(tmp_path, oracle, plane, code, words):
    letters = {17: "XYZIJ", 18: "ZXYKI", 19: "YZXJK"}[plane]
    names = dict(zip("abcij", letters, strict=True))
    text = f"G21 F9 G{plane}\nG0 X5 Y5 Z5\n{code} " + words.format(**names) + "\nM2\n"
    ((_, wanted),) = [way for way in oracle(text) if way[0] == "arc"]
    ((_, arc),) = [way for way in ours(tmp_path / "part.ngc") if way[0] == "arc"]
    axes = [(arc.axis + 1) % 3, (arc.axis + 2) % 3]
    np.testing.assert_allclose(arc.end[axes] / MM, wanted[:2], atol=2e-4)
    np.testing.assert_allclose(arc.centre[axes] / MM, wanted[2:4], atol=2e-4)
    np.testing.assert_allclose(arc.end[arc.axis] / MM, wanted[5], atol=2e-4)
    assert np.sign(arc.turn) == np.sign(wanted[4])
    assert abs(wanted[4]) - 1 <= abs(arc.turn) / (2 * pi) + 1e-9 <= abs(wanted[4]) + 2e-9


def test_linuxcnc_takes_what_we_write_and_every_arc_is_one(oracle):
    plan = [Rapid(start=np.zeros(3), end=np.array([5.0, 0.0, 0.0]) * MM)]
    cut = {"feed": 0.01, "blend": None}
    for axis in (2, 1, 0):
        for turn in (0.5, -1.5, 3.0, -5.0):
            start = plan[-1].end
            arc = {"start": start, "axis": axis, "turn": turn, **cut}
            centre = start - np.roll([3.0, 0.0, 0.0], axis + 1) * MM
            made = ArcFeed(end=start, centre=centre, **arc)
            plan.append(ArcFeed(end=made.at(np.array([1.0]))[0], centre=centre, **arc))
            end = plan[-1].end
            plan.append(
                ArcFeed(**{**arc, "start": end, "end": start, "turn": -turn}, centre=centre)
            )
    flat = np.array([(0, 0), (1, 2), (3, 2), (4, 0), (6, 1)], dtype=float)
    points = plan[-1].end + np.column_stack((flat, np.zeros(5))) * MM
    knots = np.array([0, 0, 0, 0, 1, 2, 2, 2, 2.0])
    for weights in (None, np.array([1.0, 2.0, 1.0, 1.0, 1.0])):
        curve = BSpline(knots, points, 3, weights)
        plan.append(SplineFeed(start=points[0], end=points[-1], curve=curve, **cut))
        plan.append(Rapid(start=points[-1], end=points[0]))
    found = oracle(write_gcode(plan, DIALECTS["linuxcnc"], "a test (of all)"))
    kinds = [kind for kind, _ in found]
    assert kinds.count("arc") == sum(
        1 + (abs(a.turn) > 1.5 * pi) for a in plan if isinstance(a, ArcFeed)
    )
    assert kinds.count("spline") >= 2
    rapids = [end for kind, end in found if kind == "rapid"]
    for end, way in zip(rapids, [a for a in plan if isinstance(a, Rapid)], strict=True):
        np.testing.assert_allclose(end, way.end / MM, atol=1e-4)
    assert all((a.end == b.start).all() for a, b in pairwise(plan))
